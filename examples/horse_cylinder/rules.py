#!/usr/bin/python3
"""Figure 12 by every filter, as Markdown: what each needs, summed over the load steps.

    python3 examples/horse_cylinder/rules.py [--refine 0 1] [--meshes horse.mesh cylinder.mesh]

One solve a load step, after which friction lags. Seconds are those of the program, over those of `clamp`
in the same turn."""
import argparse
import json
import os
import subprocess
import tempfile

import make_mesh

HERE = os.path.dirname(os.path.abspath(__file__))
PROGRAM = os.environ.get("TREFOIL", os.path.join(HERE, "..", "..", "build", "trefoil"))
RULES = ("clamp", "absolute", "adaptive", "on_demand", "three_state")


def record_of(options, rule):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "record.json")
        subprocess.run([os.path.abspath(PROGRAM), *options, "-output_file",
                        os.path.join(folder, "out.xdmf"), "-snes_trefoil_filter", rule,
                        "-contact_friction_iterations", "1",
                        "-snes_trefoil_monitor", "false", "-snes_trefoil_record", path],
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        if not os.path.exists(path):
            raise SystemExit(f"no record from: trefoil {' '.join(options)} -snes_trefoil_filter {rule}")
        with open(path, encoding="utf-8") as file:
            return json.load(file)


def rows(name, options, rules):
    seconds_of_first = None
    for rule in rules:
        record = record_of(options, rule)
        result, seconds = record["result"], record["time"]["total"]
        seconds_of_first = seconds_of_first or seconds
        indefinite = sum(entry["refused"] for entry in record["history"])
        counts = [result["iterations"], result["truncated"], result["linear_solves"],
                  f"{result['factorisations'] - indefinite}{f' + {indefinite}' if indefinite else ''}"]
        end = [f"{seconds / seconds_of_first:.2f}", f"{result['energy']:.6g}",
               "" if result["converged"] else f"ends at t = {record['steps'][-1]['t']:.3g}"]
        print("| " + " | ".join(map(str, [f"{name}, {record['mesh']['elements']}", f"`{rule}`",
                                          *counts, *end])) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--refine", type=int, nargs="*", default=[0, 1], help="of the stand-in")
    parser.add_argument("--meshes", nargs=2, metavar=("HORSE", "CYLINDER"), help="the paper's")
    parser.add_argument("--rules", nargs="+", default=RULES)
    arguments = parser.parse_args()
    print("| bodies, elements | filter | iterations | shortened by contact | linear solves | "
          "factorisations, + refused | seconds | energy | |")
    print("|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        stand_in = os.path.join(folder, "saddle_cylinder.mesh")
        make_mesh.write(stand_in)
        for refine in arguments.refine:
            rows("stand-in", [os.path.join(HERE, "scene.yaml"), "-mesh_file", stand_in,
                              "-mesh_refine", str(refine)], arguments.rules)
    if arguments.meshes:
        horse, cylinder = (os.path.abspath(path) for path in arguments.meshes)
        rows("horse", [os.path.join(HERE, "horse.yaml"), "-body_horse_file", horse,
                       "-body_cylinder_file", cylinder], arguments.rules)


if __name__ == "__main__":
    main()
