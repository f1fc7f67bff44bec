#!/usr/bin/python3
"""What each part of a default run buys: the same scenes without it, or with another, as Markdown.

    python3 tests/benchmarks/parts.py                     the cylinder and the knot
    python3 tests/benchmarks/parts.py horse.mesh --ratios 0.495

Every body takes the eight poses of examples/paper/poses.py at the Poisson ratios given. A row has
geometric means over the scenes relative to the defaults: iterations, linear solves with those of the guess,
processor seconds without the output; and in how many scenes the run ends higher or lower than the defaults by
more than 1e-4 of the energy's scale, or not at all. Runs of a scene follow each other; seconds compare
within a table only.
"""
import argparse
import math
import os
import resource
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "examples", "paper"))

import poses  # noqa: E402  (of the folder above)

PARTS = {
    "the defaults": (),
    "no path": ("-load_steps", "1"),
    "no path, from rest": ("-initial", "rest"),
    "no path, `harmonic`": ("-initial", "harmonic"),
    "no path, `arap`": ("-initial", "arap"),
    "no Shamanskii steps": ("-snes_trefoil_corrections", "0"),
    "at most 2": ("-snes_trefoil_corrections", "2"),
    "Shamanskii steps to a gain of .1": ("-snes_trefoil_correction_gain", "0.1"),
    "to a gain of .3": ("-snes_trefoil_correction_gain", "0.3"),
    "search `armijo`": ("-snes_trefoil_search", "armijo"),
    "not verified": ("-snes_trefoil_verify_minimum", "false"),
    "stop at 1e-6": ("-snes_trefoil_energy_tolerance", "1e-6"),
    "stop at 1e-10": ("-snes_trefoil_energy_tolerance", "1e-10"),
    "rule `clamp`": ("-snes_trefoil_filter", "clamp"),
    "rule `on_demand`": ("-snes_trefoil_filter", "on_demand"),
    "rule `three_state`": ("-snes_trefoil_filter", "three_state"),
}


class Variant:
    """The defaults with more options; what examples/paper's runner takes as a method."""
    tolerance = None

    def __init__(self, name):
        self.name = name

    def options_of(self, _):
        return PARTS[self.name]


class Result:
    """What counts of a run; `energy` infinite where it has not converged."""

    def __init__(self, record, seconds):
        result = record["result"] if record else {"converged": False}
        self.phases = dict(record["time"]) if record else {}
        self.phases["total"] = self.phases.get("total", 0) - self.phases.pop("output", 0)
        self.seconds = seconds
        self.iterations = result.get("iterations", 0)
        self.solves = result.get("linear_solves", 0) + result.get("guess_linear_solves", 0)
        self.energy = result["energy"] if result["converged"] else math.inf
        self.scale = result.get("energy_scale", 1)


def run(runner, scene, name):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    record = runner.run_once(scene, Variant(name))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    written = record["time"]["output"] / record["time"]["total"] if record else 0
    return Result(record, seconds * (1 - written))


def mean_ratio(pairs):
    """Geometric mean of a/b over pairs of which neither is zero."""
    logs = [math.log(a / b) for a, b in pairs if a > 0 and b > 0]
    return f"{math.exp(sum(logs) / len(logs)):.2f}" if logs else "-"


def row(name, results):
    """Of pairs of results, with the part changed and by the defaults."""
    ended = [(run, usual) for run, usual in results if math.isfinite(run.energy + usual.energy)]
    higher = sum(run.energy > usual.energy + 1e-4 * usual.scale for run, usual in ended)
    lower = sum(run.energy < usual.energy - 1e-4 * usual.scale for run, usual in ended)
    means = [mean_ratio((getattr(run, what), getattr(usual, what)) for run, usual in ended)
             for what in ("iterations", "solves", "seconds")]
    return f"| {name} | " + " | ".join(means) + f" | {higher} | {lower} | {len(results) - len(ended)} |"


def shares(usual):
    """How the seconds of the defaults divide, over all scenes."""
    total = sum(result.phases.get("total", 0) for result in usual)
    names = sorted({name for result in usual for name in result.phases} - {"total"},
                   key=lambda name: -sum(result.phases.get(name, 0) for result in usual))
    return ", ".join(
        f"{name.replace('_', ' ')} {sum(result.phases.get(name, 0) for result in usual) / total:.1%}"
        for name in names)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bodies", nargs="*", default=["cylinder", "knot"],
                        help="mesh files, or what the program generates")
    parser.add_argument("--ratios", type=float, nargs="+", default=[0.3, 0.495])
    parser.add_argument("--seconds", type=float, default=300, help="after which a run is given up")
    arguments = parser.parse_args()
    bodies = [poses.body_of(word, poses.PROGRAM) for word in arguments.bodies]
    with tempfile.TemporaryDirectory() as folder:
        runner = poses.Runner(poses.PROGRAM, folder, reuse=False, timeout=arguments.seconds)
        for ratio in arguments.ratios:
            scenes = [poses.scene_of(body, pose, ratio)
                      for body in bodies for pose in (*poses.LARGE, *poses.SMALL)]
            found = [{name: run(runner, scene, name) for name in PARTS} for scene in scenes]
            usual = [each["the defaults"] for each in found]
            print(f"\nnu {ratio}, {len(scenes)} scenes; of the defaults' seconds: {shares(usual)}\n\n"
                  "| | iterations | solves | seconds | higher | lower | failed |\n"
                  "|---|---|---|---|---|---|---|")
            for name in PARTS:
                print(row(name, [(each[name], each["the defaults"]) for each in found]), flush=True)


if __name__ == "__main__":
    main()
