#!/usr/bin/python3
"""How time and memory of an iteration grow: whole runs of the knot over its size, Poisson's ratio and
ranks. Prints a Markdown table, counts beside times; asserts nothing. Times are of a machine that may
be shared: compare rows of one run.

    tests/benchmarks/cost_model.py [--resolutions 4,9,13] [--poissons 0.3,0.495,0.4999]
                                   [--ranks 1,2] [trefoil options ...]
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TREFOIL = os.path.join(ROOT, "build", "trefoil")
PHASES = ("assembly", "filter", "linear_solve", "line_search")


def run(resolution, poisson, ranks, options):
    """The record of some iterations from the start, which are the ones that cost."""
    with tempfile.TemporaryDirectory() as folder:
        record = os.path.join(folder, "record.json")
        words = [TREFOIL, "-options_file",
                 os.path.join(ROOT, "examples", "knot.yaml"), "-output_file",
                 os.path.join(folder, "knot.xdmf"), "-snes_trefoil_record", record,
                 "-mesh_resolution", resolution, "-material_poisson", poisson,
                 "-snes_max_it", "5", *options]
        if int(ranks) > 1:
            words = ["mpirun", "-n", ranks, *words]
        environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1",
                           OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        if not os.path.exists(TREFOIL):
            sys.exit(f"cost_model.py: there is no {TREFOIL}; cmake --build build --target trefoil")
        result = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                env=environment, check=False)
        if not os.path.exists(record):  # five iterations that do not converge leave one
            said = [line for line in result.stdout.splitlines() if line.startswith("trefoil: ")]
            sys.exit(f"cost_model.py: {said[0] if said else 'the program left no record'}")
        with open(record, encoding="utf-8") as file:
            return json.load(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--resolutions", default="4,9,13")
    parser.add_argument("--poissons", default="0.3,0.495,0.4999")
    parser.add_argument("--ranks", default="1,2")
    arguments, options = parser.parse_known_args()
    print("| elements | nu | ranks | iterations | indefinite | assembly | filter | solve | search |"
          " read + set-up + output, s | mesh, B | matrices, B | factor, B | peak, B |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|")
    for resolution in arguments.resolutions.split(","):
        for poisson in arguments.poissons.split(","):
            for ranks in arguments.ranks.split(","):
                record = run(resolution, poisson, ranks, options)
                elements, time = record["mesh"]["elements"], record["time"]
                count = record["result"]["iterations"]
                share = [entry["indefinite"] for entry in record["history"] if entry["indefinite"]]
                each = " | ".join(f"{1e9 * time[phase] / count / elements:.0f}" for phase in PHASES)
                rest = time["read"] + time["setup"] + time["output"]
                memory = " | ".join(f"{record['memory'][key] / elements:.0f}" for key in
                                    ("mesh_bytes", "matrix_bytes", "factor_bytes", "peak_bytes"))
                print(f"| {elements} | {poisson} | {ranks} | {count} |"
                      f" {100 * sum(share) / max(len(share), 1):.0f} % | {each} | {rest:.2f} |"
                      f" {memory} |", flush=True)
    print("\nassembly, filter, solve, search: nanoseconds an element and iteration; "
          "memory: bytes an element")


if __name__ == "__main__":
    main()
