#!/usr/bin/python3
"""Hosts that know nothing of Trefoil by PETSc's own methods and by the plugin: iterations until the
residual has fallen by 1e-8, as Markdown, and a summary that lists where the plugin is not the best.

    python3 tests/embed/host_table.py                                 some 20 minutes on one core
    python3 tests/embed/host_table.py --hosts elements --options "-snes_trefoil_filter adaptive"

A method of PETSc's counts where it converges to an energy no higher than the plugin's; energies are the
same to 1e-6."""
import argparse
import math
import os
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from hosts import HOSTS, ROOT, TREFOIL, outcome, run

MOST = 200
STOP = f"-snes_rtol 1e-8 -snes_atol 0 -snes_stol 0 -snes_max_it {MOST} -ksp_type preonly"
STOCK = {"bt": "-snes_linesearch_type bt", "l2": "-snes_linesearch_type l2",
         "newtontr": "-snes_type newtontr", "basic": "-snes_linesearch_type basic"}
PLUGIN = "trefoil"
SOLVERS = ("lu", "cholesky")
STRETCHES = (0.3, 0.35, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.1, 1.3, 1.5, 2, 2.5, 3, 4, 6)
SAME_ENERGY = 1e-6
PYTHON = "/usr/bin/python3"
CACHE = tempfile.TemporaryDirectory()  # of what FEniCS compiles, for all runs


@dataclass(frozen=True)
class Host:
    program: tuple
    options: str = ""
    poissons: tuple = (0.3, 0.49)
    stretches: tuple = STRETCHES
    by_environment: bool = False  # it reads no options from its command line

    def run(self, poisson, stretch, options):
        """Whether it converged, its iterations and its energy."""
        scene = f"-poisson {poisson} -stretch {stretch}" if stretch else ""
        options = f"{self.options} {scene} {STOP} {options}"
        variables = {"XDG_CACHE_HOME": CACHE.name, "DIJITSO_CACHE_DIR": CACHE.name}
        if self.by_environment:
            options, variables["PETSC_OPTIONS"] = "", options
        printed, _, _ = run(list(self.program), options, variables=variables)
        try:
            return outcome(printed)
        except AssertionError:  # it ended in an error
            return False, MOST, math.nan


TABLE = {
    "elements": Host((os.path.join(HOSTS, "elements"),), "-cells 5"),
    "plex_fe": Host((os.path.join(HOSTS, "plex_fe"),)),
    "dolfinx_stretch": Host((PYTHON, os.path.join(ROOT, "examples", "embed", "dolfinx_stretch.py")),
                            "-cells 5 -pc_factor_mat_solver_type mumps"),
    "dolfin_twist": Host((PYTHON, os.path.join(ROOT, "tests", "embed", "dolfin_twist.py"), "24"),
                         poissons=(0.3,), stretches=(None,), by_environment=True),
}


class Scene:
    """One host, Poisson's ratio, stretch and linear solver, by all methods."""

    def __init__(self, name, poisson, stretch, solver):
        self.name, self.poisson, self.stretch, self.solver = name, poisson, stretch, solver
        self.ends = {}

    def solve(self, options):
        for method, own in {**STOCK, PLUGIN: f"{TREFOIL} {options}"}.items():
            self.ends[method] = TABLE[self.name].run(self.poisson, self.stretch,
                                                     f"-pc_type {self.solver} {own}")
        return self

    def __str__(self):
        where = f"stretch {self.stretch:g}, nu {self.poisson:g}, " if self.stretch else ""
        return f"{self.name}, {where}{self.solver}"

    def ends_above(self, method, other):
        ours, lowest = self.ends[method][2], self.ends[other][2]
        return ours > lowest + SAME_ENERGY * abs(lowest)

    def rivals(self):
        """PETSc's methods that converge, as low as the plugin does where it does."""
        done = [method for method in STOCK if self.ends[method][0]]
        if not self.ends[PLUGIN][0]:
            return done
        return [method for method in done if not self.ends_above(method, PLUGIN)]

    def iterations(self):
        return self.ends[PLUGIN][1] if self.ends[PLUGIN][0] else None

    def best(self):
        return min((self.ends[method][1] for method in self.rivals()), default=None)


def table(scenes):
    """Two rows of iterations for each host and Poisson's ratio; where they differ, LU/Cholesky."""
    rows = {}
    for scene in scenes:
        rows.setdefault((scene.name, scene.poisson), {}).setdefault(scene.stretch, []).append(scene)
    lines = []
    for (name, poisson), by_stretch in rows.items():
        if not lines or lines[-1][0] != name:
            heads = ["" if stretch is None else f"{stretch:g}" for stretch in by_stretch]
            lines.append((name, "\n| host, nu | by | " + " | ".join(heads) + " |"))
            lines.append((name, "|" + "---|" * (len(heads) + 2)))
        for label, iterations in (("PETSc's best", Scene.best), ("plugin", Scene.iterations)):
            cells = ["/".join(dict.fromkeys(str(iterations(scene) or "-") for scene in found))
                     for found in by_stretch.values()]
            lines.append((name, f"| `{name}` {poisson:g} | {label} | " + " | ".join(cells) + " |"))
    return "\n".join(line for _, line in lines)


def summary(scenes):
    """The plugin against the best of PETSc's methods, and the scenes where it is not as good."""
    done = [scene for scene in scenes if scene.ends[PLUGIN][0]]
    ratios = [scene.ends[PLUGIN][1] / scene.best() for scene in done if scene.best()]
    lines = [f"{len(scenes)} scenes: the plugin converges in {len(done)}, one of PETSc's methods in "
             f"{sum(any(scene.ends[method][0] for method in STOCK) for scene in scenes)}, the best of "
             f"them ({len(ratios)} scenes, as low) with "
             f"{math.exp(-sum(map(math.log, ratios)) / max(len(ratios), 1)):.2f} times the plugin's "
             "iterations (geometric mean)."]
    for method in STOCK:
        lines.append(f"- `{method}` converges in {sum(scene.ends[method][0] for scene in scenes)}, as "
                     f"low in {sum(method in scene.rivals() for scene in scenes)}")
    for scene in scenes:
        converged, iterations, _ = scene.ends[PLUGIN]
        lower = [method for method in STOCK
                 if converged and scene.ends[method][0] and scene.ends_above(PLUGIN, method)]
        if not converged:
            lines.append(f"- {scene}: the plugin does not converge, PETSc's best: {scene.best()}")
        elif scene.best() and iterations > scene.best() + 2:
            lines.append(f"- {scene}: {iterations} iterations, PETSc's best {scene.best()}")
        if lower:
            lines.append(f"- {scene}: lower by {', '.join(lower)}")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hosts", default=",".join(TABLE), help="default: %(default)s")
    parser.add_argument("--options", default="", help="of the plugin, default: none")
    parser.add_argument("--jobs", type=int, default=1, help="runs at once, default: %(default)s")
    arguments = parser.parse_args()
    scenes = [Scene(name, poisson, stretch, solver) for name in arguments.hosts.split(",")
              for poisson in TABLE[name].poissons for stretch in TABLE[name].stretches
              for solver in SOLVERS]
    with ThreadPoolExecutor(arguments.jobs) as pool:
        scenes = list(pool.map(lambda scene: scene.solve(arguments.options), scenes))
    print(table(scenes) + "\n\n" + summary(scenes))


if __name__ == "__main__":
    main()
