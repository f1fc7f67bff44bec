#!/usr/bin/python3
"""What constraints, loads and regions take: comparisons within a tolerance, counts and areas said and
recorded, warnings where the tolerance decides, parts of a path between rest and t = 1."""
import math
import os
import tempfile
import unittest

from boxes import TIGHT, energy
from trefoil_program import record_of, run

BOX = ["-mesh_generate", "box", "-mesh_resolution", "4"]
HELD = ["-constraints", "low", "-constraint_low_where", "z == zmin"]


def noisy_box(path, noise):
    """A cube of 2 x 2 x 2 cells whose upper and lower faces are uneven by `noise`."""
    n = 3
    with open(path, "w", encoding="ascii") as file:
        nodes = [(x / 2, y / 2, z / 2) for z in range(n) for y in range(n) for x in range(n)]
        file.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(nodes)}\n")
        for i, (x, y, z) in enumerate(nodes):
            z += noise * (i % 3 - 1) * (z != 0.5)
            file.write(f"{i + 1} {x!r} {y!r} {z!r}\n")
        cells = []
        for z, y, x in ((a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, 1)):
            for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
                place, cell = [x, y, z], []
                cell.append(1 + place[0] + n * place[1] + n * n * place[2])
                for axis in order:
                    place[axis] += 1
                    cell.append(1 + place[0] + n * place[1] + n * n * place[2])
                even = order in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
                cells.append(cell if even else [cell[i] for i in (1, 0, 2, 3)])
        file.write(f"$EndNodes\n$Elements\n{len(cells)}\n")
        file.writelines(f"{i + 1} 4 2 0 1 {' '.join(map(str, cell))}\n"
                        for i, cell in enumerate(cells))
        file.write("$EndElements\n")


class Tolerance(unittest.TestCase):
    def noisy(self, noise, *options, ranks=1):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "noisy.msh")
            noisy_box(path, noise)
            return record_of(["-mesh_file", path, *options], ranks)

    def test_noise_of_rounding_changes_nothing(self):
        for low, high in (("z == zmin", "z == zmax"), ("z <= zmin", "z >= zmax"),
                          ("z == 0", "1 <= z")):
            scene = ["-constraints", "low", "-constraint_low_where", low, "-loads", "top",
                     "-load_top_where", high, "-load_top_traction", "0, 0, 1e5"]
            clean = self.noisy(0, *scene)
            for noise, ranks in ((1e-16, 1), (1e-12, 2), (2e-10, 1)):
                noisy = self.noisy(noise, *scene, ranks=ranks)
                self.assertEqual(noisy["constraints"][0]["vertices"], 9)
                self.assertEqual(noisy["loads"][0]["facets"], 8)
                self.assertEqual(noisy["result"]["warnings"], [])
                self.assertLess(abs(energy(noisy) / energy(clean) - 1), 1e-6)

    def test_strict_comparisons_are_strict(self):
        """The face z = 0.5 lies on neither side of itself."""
        for where, vertices in (("z < 0.5", 9), ("z > 0.5", 9), ("z <= 0.5", 18), ("z != 0.5", 18),
                                ("z >= 0.5 && z < 1", 9)):
            record = self.noisy(0, "-constraints", "some", "-constraint_some_where", where,
                                "-snes_max_it", "1")
            self.assertEqual(record["constraints"][0]["vertices"], vertices, where)

    def test_formulas_keep_their_value(self):
        """Operators of a choice are our own: precedence, powers, functions, the conditional."""
        for where in ("1 + 2*3^2 == 19", "2^3^2 == 512", "-2^2 + 8 == 4 || z < -1", "10 - 4 - 3 == 3",
                      "12/3/2 == 2", "0 || 1 && 1", "1 || 0 && 0", "x < 2 ? 1 : 0",
                      "max(x, y) <= 1 && 3 > 2", "1 + 1 < 3"):
            record = self.noisy(0, *HELD, "-regions", "all", "-region_all_where", where,
                                "-snes_max_it", "1")
            self.assertEqual(record["status"], 0, where)

    def test_a_tolerance_of_ones_own(self):
        wide = self.noisy(1e-4, *HELD, "-where_tolerance", "1e-3")
        self.assertEqual(wide["constraints"][0]["vertices"], 9)
        exact = self.noisy(1e-12, *HELD, "-constraints", "low,high", "-constraint_high_where",
                           "z > 0.6", "-where_tolerance", "0")
        self.assertEqual(exact["constraints"][0]["vertices"], 3)

    def test_what_moves_is_exact(self):
        """Not in `move`: x == 0.5 + 1e-12 is another place there."""
        for ranks in (1, 2):
            record = record_of([*BOX, *HELD, "-constraints", "low,high", "-constraint_high_where",
                                "z == zmax", "-constraint_high_move",
                                "0, 0, 0.1*(x == 0.5 + 1e-12)"], ranks)
            self.assertLess(record["result"]["energy_scale"], 1e-20)


class Warnings(unittest.TestCase):
    def test_more_vertices_within_the_tolerance(self):
        for ranks in (1, 3):
            record = record_of([*BOX, "-constraints", "low", "-constraint_low_where", "z < 0.25"],
                               ranks)
            self.assertEqual(record["constraints"][0]["vertices"], 25)
            self.assertEqual(len(record["result"]["warnings"]), 1)
            self.assertIn("-constraint_low_where", record["result"]["warnings"][0])
            self.assertIn("25 more vertices", record["result"]["warnings"][0])
            self.assertEqual(record["printed"].count("WARNING: -constraint_low_where"), 1)

    def test_more_facets_within_the_tolerance(self):
        record = record_of([*BOX, *HELD, "-loads", "side", "-load_side_where",
                            "x == xmax && z > 0.25", "-load_side_traction", "1, 0, 0"], 2)
        self.assertEqual(record["loads"][0]["facets"], 16)
        self.assertIn("8 more facets", record["result"]["warnings"][0])

    def test_none_where_it_does_not_decide(self):
        for where in ("z < 0.3", "z == 0", "z <= 0.25", "x^2 + y^2 + z^2 < 1.01 && z < 0.3"):
            record = record_of([*BOX, "-constraints", "low", "-constraint_low_where", where])
            self.assertEqual(record["result"]["warnings"], [], where)


class Taken(unittest.TestCase):
    SCENE = [*BOX, "-constraints", "low,corner", "-constraint_low_where", "z == zmin",
             "-constraint_corner_where", "x + y + z == 3", "-loads", "bolt,side",
             "-load_bolt_where", "z == zmax && x <= 0.5", "-load_bolt_force", "0, 0, -150",
             "-load_side_where", "x == xmax", "-load_side_pressure", "2", "-load_gravity",
             "0, 0, -10", "-material_density", "3"]

    def test_said_and_recorded(self):
        for ranks in (1, 2, 3):
            record = record_of(self.SCENE, ranks)
            low, corner = record["constraints"]
            self.assertEqual((low["name"], low["vertices"]), ("low", 25))
            self.assertAlmostEqual(low["area"], 1, delta=1e-12)
            self.assertEqual((corner["vertices"], corner["area"]), (1, 0))
            loads = {load["name"]: load for load in record["loads"]}
            expected = {"gravity": (0, 0, (0, 0, -30)), "bolt": (16, 0.5, (0, 0, -150)),
                        "side": (32, 1, (-2, 0, 0))}
            self.assertEqual(set(loads), set(expected))
            for name, (facets, area, force) in expected.items():
                self.assertEqual(loads[name]["facets"], facets)
                self.assertAlmostEqual(loads[name]["area"], area, delta=1e-12)
                self.assertLess(math.dist(loads[name]["force"], force), 1e-11)
            for line in ("low: 25 vertices, area 1", "corner: 1 vertex, area 0",
                         "bolt: 16 facets, area 0.5, total force (0, 0, -150)"):
                self.assertIn(line + "\n", record["printed"])

    def test_the_same_work_by_traction_force_and_pressure(self):
        """On a plane face of area 1 a traction, a force and a pressure are one load."""
        top = [*BOX, *HELD, *TIGHT, "-loads", "top", "-load_top_where", "z == zmax"]
        energies = [energy(record_of(top + load, ranks)) for load, ranks in (
            (["-load_top_traction", "0, 0, 1e4"], 1), (["-load_top_force", "0, 0, 1e4"], 2),
            (["-load_top_pressure", "-1e4"], 1),
            (["-load_top_pressure", "-5e3", "-load_top_force", "0, 0, 5e3"], 2))]
        for each in energies:
            self.assertLess(abs(each / energies[0] - 1), 1e-10)

    def test_pressure_pushes_in_on_every_side(self):
        """Of all sides together the force is zero; in the plane and on bent sides as well."""
        for mesh, dimension in (("box", 3), ("ball", 3), ("square", 2)):
            for order in ("1", "2"):
                record = record_of(["-mesh_generate", mesh, "-mesh_resolution", "3", "-order", order,
                                    "-constraints", "low", "-constraint_low_where",
                                    "y < ymin + 0.4", "-loads", "sea", "-load_sea_where", "1",
                                    "-load_sea_pressure", "7"], 2)
                self.assertLess(math.hypot(*record["loads"][0]["force"]), 1e-11)
                self.assertLess(record["result"]["energy"] - record["result"]["energy_rest"], 0)
                self.assertEqual(len(record["loads"][0]["force"]), 3, dimension)


if __name__ == "__main__":
    unittest.main(verbosity=2)
