#!/usr/bin/python3
"""Rules and proxies in steps in time: Newton iterations and factorisations a step, as Markdown.

    python3 tests/benchmarks/time_rules.py rules knot ball bar.msh
    python3 tests/benchmarks/time_rules.py proxies square knot ball

A body of Young's modulus 1e4 and density 1e3, its farthest vertex at norm 1, held at the low end of x
and shaken by an initial velocity of up to --speed in waves, makes ten steps of backward Euler by each rule;
a generated one by each proxy, with little waves at a relative decrement of 1e-10. Counts do not depend
on what else runs on the machine; only which runs are given up, after --seconds, does.
"""
import argparse
import json
import os
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("TREFOIL", os.path.join(ROOT, "build", "trefoil"))
GENERATED = ("knot", "box", "cylinder", "ball", "square")
RULES = ("on_demand", "clamp", "absolute", "adaptive")
PROXIES = ("hessian", "mass", "identity")
STEPS = 10


def body(name, speed):
    """Options of the mesh, what holds it and how it is thrown."""
    flat = name == "square"
    waves = [f"{speed}*sin(3*y)", f"{speed}*sin(3*{'x' if flat else 'z'})", f"{speed}*sin(3*x)"]
    mesh = ["-mesh_generate", name] if name in GENERATED else ["-mesh_file", name]
    return [*mesh, "-mesh_normalize", "-mesh_repair", "drop", "-material_density", "1e3",
            "-constraints", "end", "-constraint_end_where", "x < xmin + 0.1*(xmax - xmin)",
            "-initial_velocity", ", ".join(waves[:2] if flat else waves)]


def record_of(options, seconds):
    """The record of a run, or nothing where it did not end in so many seconds."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "record.json")
        try:
            subprocess.run([PROGRAM, *options, "-snes_trefoil_monitor", "false", "-snes_trefoil_record",
                            path], stdout=subprocess.DEVNULL, timeout=seconds, check=False)
        except subprocess.TimeoutExpired:
            return None
        if not os.path.exists(path):
            raise SystemExit(f"no record from: trefoil {' '.join(options)}")
        with open(path, encoding="utf-8") as file:
            return json.load(file)


def cell(record, seconds):
    """Iterations / factorisations + those that failed, all by the ten steps; and how many steps came of
    it where some were halved."""
    if record is None:
        return f"not in {seconds} s"
    result, history = record["result"], record["history"]
    failed = sum(entry["refused"] for entry in history)  # factorisations of indefinite matrices
    text = f"{result['iterations'] / STEPS:.1f} / {(result['factorisations'] - failed) / STEPS:.1f}"
    text += f" + {failed / STEPS:.1f}" if failed else ""
    steps = len(record["steps"]) - 1
    text += f", {steps} steps" if steps > STEPS else ""
    return text if result["converged"] else "failed"


def rows_of_rules(meshes, steps, nus, speed, seconds):
    print("| mesh, elements | nu | dt | " + " | ".join(f"`{rule}`" for rule in RULES) + " |")
    print("|---|---|---|" + "---|" * len(RULES))
    for mesh in meshes:
        for nu in nus:
            for dt in steps:
                cells, elements = [], ""
                for rule in RULES:
                    record = record_of([*body(mesh, speed), "-material_young", "1e4", "-material_poisson",
                                        str(nu), "-time_step", str(dt), "-time_end", str(STEPS * dt),
                                        "-snes_trefoil_filter", rule], seconds)
                    cells.append(cell(record, seconds))
                    elements = record["mesh"]["elements"] if record else elements
                name = os.path.splitext(os.path.basename(mesh))[0]
                print(f"| {name} {elements} | {nu} | {dt} | " + " | ".join(cells) + " |", flush=True)


def rows_of_proxies(meshes, steps, seconds):
    print("| mesh, elements | dt | " + " | ".join(f"`{proxy}`" for proxy in PROXIES) + " |")
    print("|---|---|" + "---|" * len(PROXIES))
    for mesh in meshes:
        for dt in steps:
            cells, elements = [], ""
            for proxy in PROXIES:
                record = record_of([*body(mesh, 0.01), "-material_young", "1e4", "-material_poisson",
                                    "0.3", "-time_step", str(dt), "-time_end", str(STEPS * dt),
                                    "-time_velocity_tolerance", "0", "-snes_trefoil_energy_tolerance",
                                    "1e-10", "-snes_trefoil_proxy", proxy, "-snes_max_it", "100000"],
                                   seconds)
                cells.append(cell(record, seconds).split(" / ")[0])
                elements = record["mesh"]["elements"] if record else elements
            print(f"| {os.path.basename(mesh)} {elements} | {dt} | " + " | ".join(cells) + " |",
                  flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("rules", "proxies"))
    parser.add_argument("meshes", nargs="+", help="files, or of " + ", ".join(GENERATED))
    parser.add_argument("--steps", type=float, nargs="+", default=[1e-3, 1e-2, 1e-1])
    parser.add_argument("--nu", type=float, nargs="+", default=[0.3, 0.45, 0.495])
    parser.add_argument("--speed", type=float, default=2, help="largest initial velocity, of the rules")
    parser.add_argument("--seconds", type=float, default=100, help="after which a run is given up")
    arguments = parser.parse_args()
    if arguments.what == "rules":
        rows_of_rules(arguments.meshes, arguments.steps, arguments.nu, arguments.speed,
                      arguments.seconds)
    else:
        rows_of_proxies(arguments.meshes, arguments.steps, arguments.seconds)


if __name__ == "__main__":
    main()
