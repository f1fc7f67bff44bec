#!/usr/bin/python3
"""The paper's Figures 13 and 14: speed-ups over many bodies, in large and in small poses.

    examples/paper/histograms.py                              generated bodies
    examples/paper/histograms.py horse.mesh knot --quarter frog.msh -o study

Runs each body in 8 poses at Poisson ratios .495 and .3 by the paper's method with its three filters
and by the program's defaults, from --quarter bodies a quarter of these scenes. Prints a table and
leaves figure13.png, figure14.png, table.md and the records in the folder -o; --reuse takes records
that are there. Speed-ups are ratios of iterations, those of the defaults counted to the energy where
the paper's adaptive method stops; a run that has not converged counts with the 200 that it took.

Debian: python3-numpy python3-matplotlib
"""
import argparse
import os
import random
import sys

import poses

import numpy as np

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError as missing:
    sys.exit(f"histograms.py: {missing.name} is missing: apt install python3-matplotlib")

RATIOS = (0.495, 0.3)
METHODS = (poses.ADAPTIVE, poses.ABSOLUTE, poses.CLAMP, poses.DEFAULTS)
GENERATED = ("knot", "box", "cylinder", "ball")
NEARLY = 1.01  # times the energy of the paper's adaptive method: where the defaults end above it


def scenes_of(bodies, quartered):
    """Pairs (pose, scene); of a body that is quartered the same quarter every time."""
    found = []
    for body in [*bodies, *quartered]:
        every = [(pose, poses.scene_of(body, pose, ratio))
                 for pose in (*poses.LARGE, *poses.SMALL) for ratio in RATIOS]
        if body in quartered:
            every = random.Random(body.name).sample(every, len(every) // 4)
        found += every
    return found


class Speed:
    """Speed-ups on one scene."""

    def __init__(self, records):
        adaptive, absolute, clamp, defaults = records
        result, end = adaptive["result"], defaults["result"]
        self.over_clamp = clamp["result"]["iterations"] / result["iterations"]
        self.over_absolute = absolute["result"]["iterations"] / result["iterations"]
        reached = poses.iterations_to(defaults, result["energy"])
        self.of_defaults = result["iterations"] / reached if reached else None
        self.time_of_defaults = adaptive["time"]["total"] / defaults["time"]["total"]
        self.failures = [not record["result"]["converged"] for record in records]
        strain = result["energy"] - result["energy_rest"]
        self.ends_above = end["energy"] - end["energy_rest"] > NEARLY * strain
        self.ends_below = strain > NEARLY * (end["energy"] - end["energy_rest"])


def mean(values):
    return float(np.exp(np.mean(np.log(values)))) if len(values) else float("nan")


def cell(values):
    known = [value for value in values if value is not None]
    if not known:
        return ""
    of_all = "" if len(known) == len(values) else f", in {len(known)}"
    return f"{mean(known):.2f} ({min(known):.2f} to {max(known):.2f}{of_all})"


def table(speeds):
    """`speeds`: by (pose, ratio) a list."""
    lines = ["| poses, nu | scenes | adaptive over clamp | over absolute | defaults over adaptive | "
             "in whole time | not in 200: adaptive, absolute, clamp, defaults | "
             "defaults end above, below adaptive |", "|" + "---|" * 8]
    for words, group in (("large", poses.LARGE), ("small", poses.SMALL)):
        for ratio in RATIOS:
            some = [speed for pose in group for speed in speeds.get((pose, ratio), [])]
            if not some:
                continue
            failures = ", ".join(str(sum(column)) for column in
                                 zip(*(speed.failures for speed in some)))
            lines.append(f"| {words}, {ratio:g} | {len(some)} | "
                         + " | ".join(cell([getattr(speed, name) for speed in some]) for name in
                                      ("over_clamp", "over_absolute", "of_defaults",
                                       "time_of_defaults"))
                         + f" | {failures} | {sum(speed.ends_above for speed in some)}, "
                         f"{sum(speed.ends_below for speed in some)} |")
    return "\n".join(lines) + "\n"


def draw(file, speeds, group):
    """Histograms in doublings' quarters; rows are Poisson ratios, poses colours."""
    edges = 2 ** np.arange(-1.5, 5.01, 0.25)
    titles = {"over_clamp": "adaptive over clamp", "over_absolute": "adaptive over absolute",
              "of_defaults": "defaults over adaptive"}
    figure, panels = plt.subplots(2, 3, figsize=(10.5, 5), sharex=True, sharey="row")
    for row, ratio in zip(panels, RATIOS):
        for axes, (name, title) in zip(row, titles.items()):
            values = [[getattr(speed, name) for speed in speeds.get((pose, ratio), [])]
                      for pose in group]
            values = [np.clip([v for v in some if v is not None], edges[0], edges[-1] * 0.999)
                      for some in values]
            axes.hist(values, bins=edges, stacked=True, label=group)
            axes.axvline(1, color="0.3", linewidth=0.8)
            axes.set_xscale("log", base=2)
            axes.set_title(f"{title}, nu {ratio:g}", fontsize=9)
            axes.spines[["top", "right"]].set_visible(False)
            axes.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
        row[0].set_ylabel("scenes [-]")
    for axes in panels[-1]:
        axes.set_xlabel("ratio of iterations [-]")
    figure.legend(*panels[0][0].get_legend_handles_labels(), loc="lower center", ncol=4,
                  frameon=False, fontsize=9)
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    figure.savefig(file, dpi=90)
    plt.close(figure)


def read_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bodies", nargs="*", help="mesh files, or names of what trefoil generates "
                        f"(default: {' '.join(GENERATED)})")
    parser.add_argument("--quarter", nargs="+", default=[], metavar="BODY",
                        help="bodies of which a quarter of the scenes is run")
    parser.add_argument("--program", default=poses.PROGRAM,
                        help="the program trefoil (default: $TREFOIL, else build/trefoil)")
    parser.add_argument("--reuse", action="store_true", help="take records that are there")
    parser.add_argument("-o", "--output", default="histograms", help="folder of the results")
    return parser.parse_args()


def main():
    options = read_arguments()
    words = options.bodies or ([] if options.quarter else GENERATED)
    bodies, quartered = ([poses.body_of(word, options.program) for word in some]
                         for some in (words, options.quarter))
    runner = poses.Runner(options.program, options.output, options.reuse)
    speeds, above, failed = {}, [], []
    for pose, scene in scenes_of(bodies, quartered):
        records = runner.run_all([scene], METHODS, 1, lambda line: print(line, flush=True))
        if None in records.values():
            failed.append(scene.name)
            continue
        speed = Speed([records[scene, method] for method in METHODS])
        speeds.setdefault((pose, scene.poisson), []).append(speed)
        if speed.ends_above:
            above.append(scene.name)
    text = table(speeds) + "".join(f"\nThe defaults end above adaptive: {name}" for name in above)
    with open(os.path.join(options.output, "table.md"), "w", encoding="utf-8") as file:
        file.write(text)
    print("\n" + text)
    for number, group in ((13, poses.LARGE), (14, poses.SMALL)):
        draw(os.path.join(options.output, f"figure{number}.png"), speeds, group)
    if failed:
        sys.exit("histograms.py: left out, without a record of every method: " + "; ".join(failed))


if __name__ == "__main__":
    main()
