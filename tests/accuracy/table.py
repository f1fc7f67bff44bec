#!/usr/bin/python3
"""Error against unknowns, time and memory of linear, quadratic and P2-P0 elements as Poisson's ratio nears
1/2: runs build/tests/accuracy/table_case, prints a Markdown table and draws it. Run by hand; seconds are
the processor's for the whole run, on this machine: compare rows of one run.

    cmake --build build --target table_case
    tests/accuracy/table.py [--plane] [-o errors.png] [--csv errors.csv]
"""
import argparse
import csv
import math
import os
import resource
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.join(ROOT, "build", "tests", "accuracy", "table_case")
COLUMNS = ("element", "nu", "resolution", "unknowns", "L2", "H1", "iterations", "seconds", "MB")
SPACE = {"tet4": (4, 8, 16, 24), "tet10": (2, 4, 6, 8, 12), "tet10_p0": (2, 4, 6, 8, 12)}
PLANE = {"tri3": (16, 32, 64, 128, 256), "tri6": (4, 8, 16, 32, 64), "tri6_p0": (4, 8, 16, 32, 64)}
POISSONS = ("0.3", "0.49", "0.499", "0.4999", "0.49999")


def processor_seconds():
    """Of all processes that were run and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def rows_of(elements):
    for nu in POISSONS:
        for element, resolutions in elements.items():
            for resolution in resolutions:
                environment = dict(os.environ, OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")
                before = processor_seconds()
                finished = subprocess.run([PROGRAM, element, nu, str(resolution)], env=environment,
                                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                          text=True, check=False)
                if finished.returncode != 0:  # plain elements at the largest ratio
                    print(f"| {element} | {nu} | {resolution} | not solved |" + " |" * 5)
                    continue
                row = dict(zip(COLUMNS, finished.stdout.strip().split(",")))
                row["seconds"] = f"{processor_seconds() - before:.2f}"
                print("| " + " | ".join(row[name] for name in COLUMNS) + " |", flush=True)
                yield row


def best_trade(rows, elements):
    """How long the other elements take for the error of the finest linear mesh."""
    linear, *others = elements
    for nu in POISSONS:
        of = {name: [row for row in rows if row["element"] == name and row["nu"] == nu]
              for name in elements}
        finest = min(of[linear], key=lambda row: float(row["L2"]))
        for other in others:
            as_good = [row for row in of[other] if float(row["L2"]) <= float(finest["L2"])]
            if not as_good:
                print(f"nu {nu}: no {other} mesh reaches the L2 error {finest['L2']}")
                continue
            first = min(as_good, key=lambda row: float(row["seconds"]))
            share = float(first["seconds"]) / float(finest["seconds"])
            print(f"nu {nu}: {linear} at resolution {finest['resolution']} has L2 {finest['L2']} in "
                  f"{finest['seconds']} s; {other} at {first['resolution']} has {first['L2']} in "
                  f"{first['seconds']} s, {share:.3f} of the time")


def orders(rows, elements):
    """Observed between the two finest meshes of each kind."""
    for nu in POISSONS:
        for element in elements:
            found = [row for row in rows if row["element"] == element and row["nu"] == nu]
            if len(found) < 2:
                continue
            coarse, fine = found[-2:]
            ratio = math.log(int(fine["resolution"]) / int(coarse["resolution"]))
            L2, H1 = (math.log(float(coarse[name]) / float(fine[name])) / ratio
                      for name in ("L2", "H1"))
            print(f"nu {nu}: {element} order {L2:.2f} in L2, {H1:.2f} in H1")


def draw(rows, elements, path):
    try:
        import matplotlib
        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
    except ImportError:
        sys.exit("table.py: apt install python3-matplotlib, then use /usr/bin/python3")
    figure, panels = plt.subplots(1, 3, figsize=(12, 4), sharey=True, constrained_layout=True)
    for panel, (quantity, label) in zip(panels, (("unknowns", "unknowns"), ("seconds", "time, s"),
                                                 ("MB", "memory, MB"))):
        for nu, colour in zip(POISSONS, ("tab:blue", "tab:green", "tab:orange", "tab:red", "black")):
            for element, style in zip(elements, ("o--", "s-", "D:")):
                chosen = [row for row in rows if row["element"] == element and row["nu"] == nu]
                panel.loglog([float(row[quantity]) for row in chosen],
                             [float(row["L2"]) for row in chosen], style, color=colour,
                             label=f"{element}, nu {nu}", markersize=4)
        panel.set_xlabel(label)
        panel.grid(True, which="both", alpha=0.25)
    panels[0].set_ylabel("relative error of the displacement, L2")
    panels[0].legend(fontsize=6, loc="lower left")
    figure.savefig(path, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plane", action="store_true", help="triangles instead of tetrahedra")
    parser.add_argument("-o", "--output", help="picture, for example errors.png")
    parser.add_argument("--csv", help="the rows as comma-separated values")
    arguments = parser.parse_args()
    if not os.path.exists(PROGRAM):
        sys.exit(f"table.py: there is no {PROGRAM}; cmake --build build --target table_case")
    elements = PLANE if arguments.plane else SPACE
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|")
    rows = list(rows_of(elements))
    print()
    best_trade(rows, tuple(elements))
    orders(rows, elements)
    if arguments.csv:
        with open(arguments.csv, "w", encoding="ascii", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
    if arguments.output:
        draw(rows, tuple(elements), arguments.output)


if __name__ == "__main__":
    main()
