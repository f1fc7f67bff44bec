#!/usr/bin/python3
"""Linear solvers by size: the choice of `-solver auto` beside what direct and iterative take.

    python3 tests/benchmarks/large.py [cells ...]        (50000 100000)
    python3 tests/benchmarks/large.py --weak [cells a rank]   the same work on 1, 2, 4 ranks

TREFOIL names the program. Seconds compare within a run only; iterations, bytes and energies are exact.
A run that takes longer than ten minutes counts as failed.
"""
import json
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("TREFOIL", os.path.join(ROOT, "build", "trefoil"))
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_rmaps_base_oversubscribe="1", OMP_NUM_THREADS="1")


def box(cells):
    """A cube, stretched to twice its length with a quarter turn."""
    across = max(2, round((cells / 6) ** (1 / 3)))
    return ["-mesh_generate", "box", "-mesh_resolution", str(across), "-constraints",
            "held,pulled", "-constraint_held_where", "x == xmin", "-constraint_pulled_where",
            "x == xmax", "-constraint_pulled_move", "1, 1-z-y, y-z"]


def knot(cells):
    """The knot of the examples: thin, so that factors are small."""
    refine = 1 if cells < 170000 else 2
    return [os.path.join(ROOT, "examples", "knot.yaml"), "-mesh_refine", str(refine),
            "-output_file", "knot.xdmf"]


def run(scene, ranks, *options):
    """The record of a run, or None."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["mpirun", "-n", str(ranks), PROGRAM, *scene, "-material_poisson", "0.495",
                   *options, "-snes_trefoil_record", "record.json"]
        try:
            subprocess.run(command, cwd=folder, env=ENVIRONMENT, timeout=600, check=False,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            with open(os.path.join(folder, "record.json"), encoding="utf-8") as file:
                return json.load(file)
        except (OSError, subprocess.TimeoutExpired):
            return None


def seconds(record):
    return record["time"]["total"] if record and record["result"]["converged"] else float("inf")


def megabytes(text):
    found = re.search(r"([0-9.]+) (MB|GB)", text)
    return float(found[1]) * (1000 if found[2] == "GB" else 1) if found else float("nan")


def described(record):
    if not record:
        return f"{'failed':>34}"
    result, cells = record["result"], record["mesh"]["elements"]
    iterations = sum(entry["linear_iterations"] for entry in record["history"])
    return (f"{result['iterations']:4d}/{result['linear_solves']:<4d}{iterations:6d} "
            f"{record['time']['total']:8.1f} {record['memory']['peak_bytes'] / cells:8.0f}")


def compare(name, scene, ranks):
    """One line: both solvers, the distance of their energies, the factor's size, the choice."""
    direct, iterative = (run(scene, ranks, "-solver", kind) for kind in ("direct", "iterative"))
    chosen = run(scene, ranks, "-snes_max_it", "0", "-initial", "rest")
    known = iterative or direct
    difference = factor = float("nan")
    if direct and iterative:
        difference = ((iterative["result"]["energy"] - direct["result"]["energy"]) /
                      direct["result"]["energy_scale"])
    if direct:
        factor = (direct["memory"]["factor_bytes"] / 1e6 /
                  megabytes(direct["solver"]["linear_reason"]))
    takes_direct = chosen is not None and "gamg" not in chosen["solver"]["linear"]
    price = seconds(direct if takes_direct else iterative) / min(seconds(direct), seconds(iterative))
    print(f"{name:5} {known['mesh']['elements'] if known else 0:8d} {ranks:2d} "
          f"{described(direct)} {described(iterative)} {difference:9.1e} {factor:6.2f} "
          f"{'direct' if takes_direct else 'iterative':9} {price:5.2f}", flush=True)


def weak(cells):
    print("   cells ranks   iterations/solves CG  seconds  peak bytes a cell")
    for ranks in 1, 2, 4:
        record = run(box(cells * ranks), ranks, "-solver", "iterative")
        print(f"{record['mesh']['elements'] if record else 0:8d} {ranks:5d} {described(record)}",
              flush=True)


def main():
    words = [word for word in sys.argv[1:] if word != "--weak"]
    sizes = [int(word) for word in words]
    if "--weak" in sys.argv:
        weak(sizes[0] if sizes else 100000)
        return
    print("body     cells  n   direct: it/solves  CG  seconds  B/cell  iterative: the same      "
          "  energies factor auto      price")
    for cells in sizes or [50000, 100000]:
        for ranks in 1, 2:
            for name, scene in ("box", box(cells)), ("knot", knot(cells)):
                compare(name, scene, ranks)


if __name__ == "__main__":
    main()
