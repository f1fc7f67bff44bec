#!/usr/bin/python3
"""The paper's Figure 10 on a generated cylinder: one stretch, four energies, three filters.

    examples/paper/figure10.py [trefoil options ...]     prints a table for the README

Each cell has iterations / line-search trials up to the paper's stop test; `energies` is how far the
filters' final energies are apart, relative to the energy's scale.
"""
import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("TREFOIL", os.path.join(ROOT, "build", "trefoil"))
ENERGIES = ("stable_neo_hookean", "mooney_rivlin", "arap", "symmetric_dirichlet")
FILTERS = ("clamp", "absolute", "adaptive")


def run(energy, name, options):
    """The record of a run; None where it left none."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "record.json")
        scene = os.path.join(ROOT, "examples", "paper", f"figure10_{energy}.yaml")
        result = subprocess.run(
            [PROGRAM, "-options_file", scene, "-snes_trefoil_filter", name,
             "-snes_trefoil_record", path, *options],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if not os.path.exists(path):
            print(result.stdout, file=sys.stderr)
            return None
        with open(path, encoding="utf-8") as file:
            return json.load(file)


def cell(record):
    """Iterations and line-search trials."""
    result = record["result"]
    return (f"{result['iterations']} / {result['line_search_trials']}"
            + ("" if result["converged"] else " (not converged)"))


def main():
    print("| energy | " + " | ".join(FILTERS) + " | energies |\n|---|---|---|---|---|")
    failures = 0
    for energy in ENERGIES:
        records = [run(energy, name, sys.argv[1:]) for name in FILTERS]
        if None in records:
            return 1
        failures += sum(not record["result"]["converged"] for record in records)
        values = [record["result"]["energy"] for record in records]
        spread = (max(values) - min(values)) / records[-1]["result"]["energy_scale"]
        print(f"| `{energy}` | " + " | ".join(map(cell, records)) + f" | {spread:.0e} |",
              flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
