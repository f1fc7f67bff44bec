#!/usr/bin/python3
"""Draws how runs of Trefoil converged, from the JSON records that -snes_trefoil_record wrote.

    python3 examples/plot_convergence.py record.json -o convergence.png
    python3 examples/plot_convergence.py adaptive.json clamp.json absolute.json -o comparison.png

Records of the same mesh are compared: energies are above the lowest that any of them ends with. Each
load step is a curve; all but the last are above their own ends.
Debian: python3-numpy python3-matplotlib
"""

import argparse
import json
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "python"))

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.lines import Line2D

    from history import final_energies, load_steps
except ImportError as missing:
    sys.exit(f"plot_convergence.py: {missing.name} is missing: "
             "apt install python3-numpy python3-matplotlib, then use /usr/bin/python3")

# Marker of a step by the weight w of its filter.
MARKERS = ((1.0, "o", "w = 1 (absolute)"), (0.5, "v", "w = 1/2 (clamp)"),
           (0.0, "s", "w = 0 (Newton)"), (None, "D", "another w"))


class Record:
    """One run: its history as columns, and what to call it."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as stream:
            data = json.load(stream)
        history, mesh, result = data["history"], data["mesh"], data["result"]
        if not history:
            raise ValueError("its history is empty")
        self.name = os.path.splitext(os.path.basename(path))[0]
        self.iterations, self.energy, self.weight, self.step, self.seconds = (
            np.array([float("nan") if entry[key] is None else entry[key] for entry in history],
                     dtype=float)
            for key in ("k", "energy", "weight", "step", "seconds"))
        self.final_energy = float(result["energy"])
        self.load_steps = load_steps(data)
        self.step_ends = final_energies(data)
        self.scale = max(abs(float(result.get("energy_scale") or 0)), abs(self.final_energy))
        self.converged = bool(result["converged"])
        self.mesh = (mesh["vertices"], mesh["elements"], mesh["element"])
        self.label = f"{data['solver']['filter']}, {mesh['elements']} {mesh['element']}"
        if not self.converged:
            self.label += " (not converged)"

    def steps(self):
        """Which entries are steps: the last one only says where the run ended."""
        return self.step > 0

    def marker_groups(self):
        """Pairs of a marker and the steps that it marks."""
        rest = self.steps()
        for weight, marker, _ in MARKERS:
            chosen = rest if weight is None else rest & np.isclose(self.weight, weight)
            rest = rest & ~chosen
            if chosen.any():
                yield marker, chosen


def read(path):
    try:
        return Record(path)
    except OSError as error:
        sys.exit(f"plot_convergence.py: cannot read {path}: {error.strerror}")
    except json.JSONDecodeError as error:
        sys.exit(f"plot_convergence.py: {path} is not JSON: {error}")
    except KeyError as error:
        sys.exit(f"plot_convergence.py: {path} is no record of Trefoil: it lacks {error}")
    except (AttributeError, TypeError, ValueError) as error:
        sys.exit(f"plot_convergence.py: {path} is no record of Trefoil: {error}")


def above_the_lowest(records):
    """For every record its energies above the lowest final energy on its mesh, and the floor:
    what rounding leaves of such a difference."""
    heights = []
    for record in records:
        same_mesh = [other for other in records if other.mesh == record.mesh]
        lowest = min(other.final_energy for other in same_mesh)
        floor = max(np.finfo(float).eps * max(other.scale for other in same_mesh), 1e-300)
        ends = np.full(len(record.energy), lowest)
        for (first, end), final in zip(record.load_steps[:-1], record.step_ends):
            ends[first:end] = final
        heights.append((np.maximum(record.energy - ends, floor), floor))
    return heights


def draw_curve(axes, record, x, y, colour):
    for first, end in record.load_steps:
        axes.plot(x[first:end], y[first:end], "-", color=colour, linewidth=1.2, alpha=0.8)
    for marker, chosen in record.marker_groups():
        axes.plot(x[chosen], y[chosen], marker, color=colour, markersize=6,
                  markeredgecolor="white", markeredgewidth=0.6)


def used_markers(records):
    used = {marker for record in records for marker, _ in record.marker_groups()}
    return [Line2D([], [], linestyle="", marker=marker, color="0.35", label=name)
            for _, marker, name in MARKERS if marker in used]


def plot(records, output):
    labels = [record.label for record in records]
    if len(set(labels)) < len(labels):
        labels = [f"{record.name}: {label}" for record, label in zip(records, labels)]
    colours = plt.get_cmap("tab10")(np.arange(len(records)) % 10)
    heights = above_the_lowest(records)

    figure, (by_iteration, by_time, steps) = plt.subplots(1, 3, figsize=(13.5, 4.9))
    for record, colour, (height, _) in zip(records, colours, heights):
        draw_curve(by_iteration, record, record.iterations, height, colour)
        draw_curve(by_time, record, record.seconds, height, colour)
        draw_curve(steps, record, record.iterations, np.where(record.steps(), record.step, np.nan),
                   colour)

    for axes in (by_iteration, by_time):
        axes.set_yscale("log")
        for floor in {floor for height, floor in heights if (height <= floor).any()}:
            axes.axhline(floor, color="0.6", linewidth=0.8, linestyle=":")
            axes.annotate("rounding", (0.01, floor), xycoords=("axes fraction", "data"),
                          xytext=(0, 3), textcoords="offset points", ha="left", fontsize=8,
                          color="0.45")
        axes.set_ylabel("energy above the lowest final one [J in SI units]")
    by_iteration.set_title("Energy over iterations")
    by_time.set_title("Energy over time")
    by_time.set_xlabel("time since the solve began [s]")
    steps.set_title("Step length")
    steps.set_ylabel("fraction of the full step [-]")
    shortest = min((record.step[record.steps()].min() for record in records
                    if record.steps().any()), default=1.0)
    if shortest < 0.05:
        steps.set_yscale("log")
    else:
        longest = max((record.step[record.steps()].max() for record in records
                       if record.steps().any()), default=1.0)
        steps.set_ylim(0, 1.08 * max(longest, 1.0))
    for axes in (by_iteration, steps):
        axes.set_xlabel("iteration [-]")
        axes.xaxis.get_major_locator().set_params(integer=True)
    for axes in (by_iteration, by_time, steps):
        axes.grid(True, color="0.92")
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)

    names = [Line2D([], [], color=colour, linewidth=2, label=label)
             for colour, label in zip(colours, labels)]
    entries = names + used_markers(records)
    columns = min(len(entries), 4)
    rows = -(-len(entries) // columns)
    figure.suptitle("Convergence of Trefoil" if len(records) > 1
                    else f"Convergence of Trefoil: {labels[0]}")
    figure.tight_layout(rect=(0, 0.03 + 0.05 * rows, 1, 1))
    figure.legend(handles=entries, loc="lower center", ncol=columns, frameon=False)
    figure.savefig(output, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", nargs="+", help="JSON records of Trefoil")
    parser.add_argument("-o", "--output", default="convergence.png", help="the picture")
    arguments = parser.parse_args()
    records = [read(path) for path in arguments.records]
    try:
        plot(records, arguments.output)
    except (OSError, ValueError) as error:
        sys.exit(f"plot_convergence.py: cannot draw {arguments.output}: {error}")


if __name__ == "__main__":
    main()
