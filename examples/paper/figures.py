#!/usr/bin/python3
"""Figures 2 to 9 and 11 of the paper: what its three filters do, and the program's defaults.

    examples/paper/figures.py                      on bodies that are generated, a minute or two
    examples/paper/figures.py --large horse.mesh --same cylinder_a.mesh cylinder_b.mesh

--large is the body of Figures 2, 4 and 7 (default: knot), --same are two meshes of one body for
Figure 11 (default: the generated cylinder at two resolutions). Leaves curves.png
(Figures 2, 3), ratios.png (4, 7), sweeps.png (5, 6, 8, 9) in the folder -o, and prints tables.

Debian: python3-numpy python3-matplotlib
"""
import argparse
import os
import sys

import poses
from speed_error import judgement

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError as missing:
    sys.exit(f"figures.py: {missing.name} is missing: apt install python3-matplotlib")

PAPER = (poses.ADAPTIVE, poses.ABSOLUTE, poses.CLAMP)
ALL = (*PAPER, poses.DEFAULTS)
COLOURS = {"adaptive": "tab:green", "absolute": "tab:blue", "clamp": "tab:red", "defaults": "0.2",
           "on_demand": "tab:purple", "tikhonov": "tab:orange"}
POISSON = (0.1, 0.3, 0.4, 0.45, 0.49, 0.495, 0.499, 0.4999)
RESOLUTIONS = (4, 6, 8, 12)
THRESHOLDS = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
ON_DEMAND = poses.Strategy("on_demand", "on_demand")
FAR, NEAR = "stretched by 3 lengths", "stretched by a fifth"


def tidy(axes, title, x, y):
    axes.set_title(title, fontsize=9)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(True, color="0.92")
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def save(figure, folder, name):
    handles = {label: handle for axes in figure.axes
               for handle, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(handles.values(), handles.keys(), loc="lower center", ncol=len(handles),
                  frameon=False, fontsize=9)
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    figure.savefig(os.path.join(folder, name), dpi=90)
    plt.close(figure)


def draw_energies(axes, scene, records):
    """Energy above the lowest that any of them found, in units of its scale."""
    lowest = min(record["result"]["energy"] for record in records.values())
    for name, record in records.items():
        scale = record["result"]["energy_scale"]
        states = [entry for entry in record["history"]
                  if judgement.is_of_last_loads(record, entry)]
        axes.semilogy([entry["k"] for entry in states],
                      [max((entry["energy"] - lowest) / scale, 1e-9) for entry in states],
                      ".-", color=COLOURS[name], label=name, linewidth=1, markersize=4)
    tidy(axes, scene.name, "iteration [-]", "energy above the lowest [-]")


def curves(run, folder, scenes):
    """Figures 2 and 3."""
    figure, panels = plt.subplots(2, 3, figsize=(10.5, 5.6))
    print("\n| scene | adaptive | absolute | clamp | defaults |\n|---|---|---|---|---|")
    for axes, scene in zip(panels.flat, scenes):
        records = run(scene, ALL)
        draw_energies(axes, scene, records)
        print(f"| {scene.name} | " + " | ".join(counts(record) for record in records.values())
              + " |")
    save(figure, folder, "curves.png")


def counts(record):
    """Iterations and mean line-search trials an iteration, as in the paper's Table 1."""
    result = record["result"]
    steps = max(1, len([entry for entry in record["history"] if entry["step"]]))
    return (f"{result['iterations']} ({result['line_search_trials'] / steps:.1f})"
            + ("" if result["converged"] else " *"))


def ratios(run, folder, scenes):
    """Figures 4 and 7."""
    figure, panels = plt.subplots(2, len(scenes), figsize=(10.5, 5.2), squeeze=False)
    for (steps, trust), scene in zip(panels.T, scenes):
        for name, record in run(scene, PAPER).items():
            taken = [entry for entry in record["history"] if entry["step"] and entry["rho"]]
            k, colour = [entry["k"] for entry in taken], COLOURS[name]
            steps.plot(k, [entry["step"] for entry in taken], ".-", color=colour, label=name,
                       linewidth=1, markersize=4)
            trust.plot(k, [entry["rho"] for entry in taken], "-", color=colour, linewidth=1)
            clamped = [entry for entry in taken if entry["weight"] < 1 and name == "adaptive"]
            trust.plot([entry["k"] for entry in clamped], [entry["rho"] for entry in clamped], "o",
                       color=colour, markersize=3, label="adaptive takes clamp" if clamped else None)
        trust.set_ylim(0.4, 1.6)
        tidy(steps, scene.name, "iteration [-]", "step length [-]")
        tidy(trust, scene.name, "iteration [-]", "trust-region ratio rho [-]")
    save(figure, folder, "ratios.png")


def draw_sweep(axes, run, values, scene_at, methods_at, title, label):
    """Iterations over a parameter, by strategy."""
    lines = {}
    for value in values:
        for name, record in run(scene_at(value), methods_at(value)).items():
            lines.setdefault(name, []).append(record["result"]["iterations"])
    for name, line in lines.items():
        axes.plot(range(len(line)), line, ".-", color=COLOURS[name], label=name, linewidth=1)
    tidy(axes, title, label, "iterations [-]")
    axes.set_xticks(range(len(values)), [f"{value:g}" for value in values], fontsize=7,
                    rotation=30)
    axes.set_ylim(0, None)


def sweeps(run, folder, cylinder, program):
    """Figures 5, 6, 8 and 9, all on the cylinder stretched to four times its length."""
    def sized(resolution):
        return poses.body_of("cylinder", program, ("-mesh_resolution", str(resolution)))

    def thresholded(value):
        return (poses.ADAPTIVE, poses.Strategy("tikhonov", "tikhonov",
                                               ("-snes_trefoil_floor", repr(value))))

    figure, panels = plt.subplots(2, 3, figsize=(10.5, 5.6))
    far = poses.scene_of(cylinder, FAR, 0.495)
    draw_sweep(panels[0, 0], run, POISSON, lambda nu: poses.scene_of(cylinder, FAR, nu),
               lambda _: ALL, "Poisson's ratio (Figure 5)", "nu [-]")
    for axes, pose, short, nu in ((panels[0, 1], FAR, "far", 0.495),
                                  (panels[0, 2], NEAR, "a little", 0.3)):
        draw_sweep(axes, run, RESOLUTIONS,
                   lambda size, pose=pose, nu=nu: poses.scene_of(sized(size), pose, nu),
                   lambda _: ALL, f"resolution, {short}, nu {nu} (Figure 6)", "cells across [-]")
    for axes, nu in ((panels[1, 0], 0.495), (panels[1, 1], 0.3)):
        scene = poses.scene_of(cylinder, FAR, nu)
        draw_energies(axes, scene, run(scene, (poses.ADAPTIVE, poses.CLAMP, ON_DEMAND)))
        axes.set_title(f"projection on demand, nu {nu} (Figure 8)", fontsize=9)
    draw_sweep(panels[1, 2], lambda scene, methods: renamed(run, scene, methods), THRESHOLDS,
               lambda _: far, thresholded, "threshold of tikhonov (Figure 9)",
               "share of the largest eigenvalue [-]")
    save(figure, folder, "sweeps.png")


def renamed(run, scene, methods):
    """Records of tikhonov with each threshold under a name of their own."""
    found = run(scene, methods[:1])
    method = methods[1]
    found["tikhonov"] = run(scene, (poses.Strategy(f"tikhonov {method.more[1]}", method.filter,
                                                   method.more),)).popitem()[1]
    return found


def two_meshes(run, bodies):
    """Figure 11."""
    print("\n| mesh | tetrahedra | adaptive | absolute | clamp | defaults |\n|---|---|---|---|---|---|")
    for body in bodies:
        records = run(poses.scene_of(body, FAR, 0.495), ALL)
        print(f"| {body.name} | {body.cells} | "
              + " | ".join(counts(record) for record in records.values()) + " |")


def read_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--large", default="knot", metavar="BODY")
    parser.add_argument("--same", nargs=2, metavar="BODY")
    parser.add_argument("--program", default=poses.PROGRAM,
                        help="the program trefoil (default: $TREFOIL, else build/trefoil)")
    parser.add_argument("--reuse", action="store_true", help="take records that are there")
    parser.add_argument("-o", "--output", default="figures", help="folder of the results")
    return parser.parse_args()


def main():
    options = read_arguments()
    program = options.program
    runner = poses.Runner(program, options.output, options.reuse)

    def run(scene, methods):
        """Records by strategy."""
        found = runner.run_all([scene], methods, 1, lambda line: print(line, file=sys.stderr))
        if None in found.values():
            sys.exit(f"figures.py: {runner.complaints}")
        return {method.name: record for (_, method), record in found.items()}

    large, knot, box, cylinder = (poses.body_of(word, program) for word in
                                  (options.large, "knot", "box", "cylinder"))
    same = ([poses.body_of(word, program) for word in options.same] if options.same else
            [cylinder, poses.body_of("cylinder", program, ("-mesh_resolution", "7"))])
    of_large = [poses.scene_of(large, *pose) for pose in
                ((FAR, 0.495), (FAR, 0.3), (NEAR, 0.495), (NEAR, 0.3))]
    of_others = [poses.scene_of(knot, "bent by 90 degrees", 0.495),
                 poses.scene_of(box, "turned by 180 degrees", 0.495)]
    curves(run, options.output, [*of_large, *of_others])
    ratios(run, options.output, of_large)
    two_meshes(run, same)
    sweeps(run, options.output, cylinder, program)


if __name__ == "__main__":
    main()
