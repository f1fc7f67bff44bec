#!/usr/bin/python3
"""The force of Hertz's contact against its closed form, as Markdown; `-n` cells resolve 1.3 a.

    python3 tests/benchmarks/hertz.py [-n 4 6 9 12] [--slope 0.05] [--distance 0.1] [--stiffness 1]

A paraboloid z = r^2 / (2 R) of an elastic half-space is pressed by delta = a^2 / R onto a rigid
half-space: F = 4/3 E* sqrt(R) delta^1.5, with E* = E / (1 - nu^2) and the radius a of contact. A
quarter of it is meshed, cubes at the contact and shells around them that grow with their distance,
up to 12 a. What is cut off there moves as under a point load F of Boussinesq, which differs from
Hertz's by (a / r)^2. delta is measured from where the barrier stands that bears the mean pressure
2/3 p0, p0 = 3 F / (2 pi a^2).
"""
import argparse
import json
import math
import os
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("TREFOIL", os.path.join(ROOT, "build", "trefoil"))
POISSON = 0.3
CORE, FAR = 1.3, 12  # of the cubes and of all, in radii of contact
CORNERS = [(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
SPLIT = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]


class QuarterSpace:
    """Points and tetrahedra of x, y, z >= 0 up to a radius: n^3 cubes, and shells of the 3 n^2
    squares that bound them. A cell is divided by its diagonal away from the origin, so that
    neighbours fit."""

    def __init__(self, n, core, far):
        self.n, self.core = n, core
        self.layers = math.ceil(math.log(far / core) / math.log(1 + 1 / n))
        self.growth = (far / core) ** (1 / self.layers)
        self.points, self.cells, self.numbers = [], [], {}
        for k in range(n):
            for j in range(n):
                for i in range(n):
                    self.divide([(i + p, j + q, k + r, 0) for p, q, r in CORNERS])
        for layer in range(self.layers):
            for b in range(n):
                for a in range(n):
                    self.divide([(n, a + p, b + q, layer + r) for r, p, q in CORNERS])
                    self.divide([(a + p, n, b + q, layer + r) for p, r, q in CORNERS])
                    self.divide([(a + p, b + q, n, layer + r) for p, q, r in CORNERS])

    def divide(self, corners):
        corners = [self.number(*corner) for corner in corners]
        self.cells += [[corners[c] for c in cell] for cell in SPLIT]

    def number(self, i, j, k, layer):
        if (i, j, k, layer) not in self.numbers:
            self.numbers[i, j, k, layer] = len(self.points)
            size = self.core / self.n * self.growth ** layer
            share = min(1, 2 * layer / self.layers)  # from a cube to a sphere
            size *= 1 + share * (self.n / math.sqrt(i * i + j * j + k * k) - 1) if layer else 1
            self.points.append((size * i, size * j, size * k))
        return self.numbers[i, j, k, layer]


def write_mesh(path, n, radius):
    """The quarter space with a = 1, whose surface is raised at the paraboloid up to r = 2."""
    mesh = QuarterSpace(n, CORE, FAR)
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(mesh.points)}\n")
        for x, y, z in mesh.points:
            raised = min(x * x + y * y, 4) / (2 * radius) * max(0, 1 - z / 5)
            file.write(f"{x!r} {y!r} {z + raised!r} 0\n")
        file.write(f"Tetrahedra\n{len(mesh.cells)}\n")
        file.writelines("%d %d %d %d 0\n" % tuple(c + 1 for c in cell) for cell in mesh.cells)
        file.write("End\n")
    return len(mesh.cells)


def gap_under(pressure):
    """d / dhat at which the barrier's -b' = 2 (s - 1) ln s + (1 - s)^2 / s is pressure / kappa."""
    low, high = 1e-9, 1
    for _ in range(50):
        s = (low + high) / 2
        if 2 * (s - 1) * math.log(s) + (1 - s) ** 2 / s > pressure:
            low = s
        else:
            high = s
    return low


def measure(n, slope=0.05, distance=0.1, stiffness=1):
    """Elements, force over Hertz's, record of the run.

    slope: a / R. distance: dhat / delta. stiffness: kappa / E."""
    radius = 1 / slope
    delta, dhat = 1 / radius, distance / radius
    force = 4 / 3 / (1 - POISSON ** 2) * math.sqrt(radius) * delta ** 1.5
    start = 1.5 * dhat  # the gap at rest
    gap = dhat * gap_under(force / math.pi / stiffness)
    r = "sqrt(x^2 + y^2 + z^2)"
    boussinesq = force * (1 + POISSON) / (2 * math.pi)  # F / (4 pi G)
    across = f"{boussinesq}*(z/{r}^3 - {1 - 2 * POISSON}/({r}*({r} + z)))"
    along = f"{boussinesq}*({2 * (1 - POISSON)}/{r} + z^2/{r}^3) - {delta - gap + start}"
    inside = f"{r} < {0.99 * FAR}"
    with tempfile.TemporaryDirectory() as folder:
        elements = write_mesh(os.path.join(folder, "quarter.mesh"), n, radius)
        diagonal = math.dist((0, 0, 0), (FAR, FAR, FAR))
        subprocess.run([
            PROGRAM, "-mesh_file", "quarter.mesh", "-material_young", "1", "-material_poisson",
            str(POISSON), "-constraints", "far,x,y", "-constraint_far_where", f"{r} > {0.99 * FAR}",
            "-constraint_far_move", f"t*x*({across}), t*y*({across}), t*({along})",
            "-constraint_x_where", f"x == xmin && {inside}", "-constraint_x_move", "0, free, free",
            "-constraint_y_where", f"y == ymin && {inside}", "-constraint_y_move", "free, 0, free",
            "-obstacles", "floor", "-obstacle_floor_plane", "0, 0, 1", "-obstacle_floor_at",
            f"0, 0, {-start}", "-contact_distance", repr(dhat / diagonal), "-contact_stiffness",
            str(stiffness), "-contact_self", "false", "-snes_trefoil_record", "record.json"],
            cwd=folder, stdout=subprocess.DEVNULL, check=True)
        with open(os.path.join(folder, "record.json"), encoding="utf-8") as file:
            record = json.load(file)
    return elements, 4 * abs(record["steps"][-1]["reaction"]["far"][2]) / force, record


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, nargs="+", default=[4, 6, 9, 12])
    parser.add_argument("--slope", type=float, default=0.05, help="a / R")
    parser.add_argument("--distance", type=float, default=0.1, help="dhat / delta")
    parser.add_argument("--stiffness", type=float, default=1, help="kappa / E")
    arguments = parser.parse_args()
    print("| elements | a/h | a/R | dhat/a | vertices in contact | iterations | F, off Hertz's by |")
    print("|---|---|---|---|---|---|---|")
    for n in arguments.n:
        elements, ratio, record = measure(n, arguments.slope, arguments.distance,
                                          arguments.stiffness)
        result = record["result"]
        print(f"| {elements} | {n / CORE:.1f} | {arguments.slope:g} | "
              f"{arguments.distance * arguments.slope:g} | {result['contact_pairs']} | "
              f"{result['iterations']} | {100 * (ratio - 1):+.2f} % |", flush=True)


if __name__ == "__main__":
    main()
