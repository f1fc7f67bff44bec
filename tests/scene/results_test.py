#!/usr/bin/python3
"""The numbers a run ends with: reactions and moments, forces, strain energy and work, extremes, volume,
probes, and the table with a line for each load step."""
import csv
import math
import os
import tempfile
import unittest

from boxes import SPRING, THREE_PLANES, TIGHT
from trefoil_program import record_of, run

BOX = ["-mesh_generate", "box", "-mesh_resolution", "3", "-material_poisson", "0.3"]
STANDS = [*BOX, "-constraints", "low", "-constraint_low_where", "z == zmin"]
PUSHED = ["-loads", "top,side", "-load_top_where", "z == zmax", "-load_top_force",
          "2e4, 1e4, -1.5e5", "-load_side_where", "x == xmax", "-load_side_pressure", "5e4*z",
          "-load_gravity", "0, 3, -9.81", "-material_density", "1e3"]


def total(parts, key):
    return [math.fsum(part[key][i] for part in parts) for i in range(3)]


class Balance(unittest.TestCase):
    def check(self, scene, ranks):
        """Forces and moments, about the origin and on the deformed body, add up to nothing."""
        record = record_of([*scene, *TIGHT], ranks)
        self.assertEqual(record["status"], 0, record["printed"])
        loads, held = record["loads"], record["constraints"]
        size = sum(math.hypot(*load["force"]) for load in loads) + sum(
            math.hypot(*constraint["reaction"]) for constraint in held)
        for force, reaction in (("force", "reaction"), ("moment", "moment")):
            rest = [a + b for a, b in zip(total(loads, force), total(held, reaction))]
            self.assertLess(math.hypot(*rest), 1e-6 * size, (force, rest))
        return record

    def test_loads_and_reactions(self):
        for order in ("1", "2"):
            records = [self.check([*STANDS, *PUSHED, "-order", order], ranks)
                       for ranks in (1, 2, 3)]
            for record in records[1:]:
                for one, other in zip(records[0]["constraints"], record["constraints"]):
                    self.assertLess(math.dist(one["reaction"], other["reaction"]), 1)

    def test_weight(self):
        """A body that stands is held by its weight, rho g V, whatever its strains."""
        record = record_of([*STANDS, "-snes_trefoil_energy_tolerance", "1e-20", "-load_gravity",
                            "0, 0, -9.81", "-material_density", "1e3"], 2)
        reaction = record["constraints"][0]["reaction"]
        self.assertLess(math.dist(reaction, (0, 0, 9810)), 1e-9 * 9810)

    def test_several_constraints_and_single_components(self):
        record = self.check([*BOX, "-constraints", "floor,wall,back", "-constraint_floor_where",
                             "z == zmin", "-constraint_floor_move", "free, free, 0",
                             "-constraint_wall_where", "x == xmin", "-constraint_wall_move",
                             "0, free, free", "-constraint_back_where", "y == ymin",
                             "-constraint_back_move", "free, 0, free", *PUSHED], 2)
        for constraint, axis in zip(record["constraints"], (2, 0, 1)):
            for i in {0, 1, 2} - {axis}:
                self.assertEqual(constraint["reaction"][i], 0)

    def test_moved_ends_hold_each_other(self):
        record = self.check([*STANDS, "-constraints", "low,high", "-constraint_high_where",
                             "z == zmax", "-constraint_high_move", "0.2, 0, 0.5"], 1)
        low, high = record["constraints"]
        self.assertGreater(high["reaction"][2], 1e4)
        self.assertLess(math.hypot(*total((low, high), "reaction")), 1e-4)

    def test_in_the_plane(self):
        record = self.check(["-mesh_generate", "square", "-mesh_resolution", "4", "-constraints",
                             "low", "-constraint_low_where", "y == ymin", "-loads", "top",
                             "-load_top_where", "y == ymax", "-load_top_force", "3e4, -1e4"], 2)
        self.assertEqual(record["constraints"][0]["reaction"][2], 0)


class ClosedForm(unittest.TestCase):
    """A cube pulled as a spring: P = young (s - 1), nothing across."""
    YOUNG, FORCE = 1e6, 2e5

    def test_spring(self):
        stretch = 1 + self.FORCE / self.YOUNG
        for ranks in (1, 2):
            record = record_of([*THREE_PLANES, *TIGHT, *SPRING, "-material_young", str(self.YOUNG),
                                "-loads", "top", "-load_top_where", "z == zmax", "-load_top_force",
                                f"0, 0, {self.FORCE}", "-probes", "tip,inside", "-probe_tip",
                                "xmax, ymax, zmax", "-probe_inside", "0.3, 0.4, 0.35"], ranks)
            result = record["result"]
            expected = {"strain_energy": self.FORCE ** 2 / (2 * self.YOUNG),
                        "load_work": self.FORCE ** 2 / self.YOUNG, "volume": stretch}
            for key, value in expected.items():
                self.assertAlmostEqual(result[key] / value, 1, delta=1e-9, msg=key)
            self.assertAlmostEqual(result["largest_displacement"]["value"], stretch - 1, delta=1e-9)
            self.assertEqual(result["largest_displacement"]["at"][2], 1)
            self.assertAlmostEqual(result["least_det_F"]["value"], stretch, delta=1e-9)
            # Cauchy's stress is P s / J = P: the area across stays.
            self.assertAlmostEqual(result["largest_von_mises"]["value"] / self.FORCE, 1, delta=1e-9)
            for name, height in (("tip", 1), ("inside", 0.35)):
                self.assertLess(math.dist(result["probes"][name],
                                          (0, 0, height * (stretch - 1))), 1e-9)
            self.assertAlmostEqual(record["regions"][0]["volume"], 1, delta=1e-12)
            self.assertEqual(record["regions"][0]["cells"], 384)

    def test_regions_have_their_mass(self):
        record = record_of([*STANDS, "-regions", "low,top", "-region_low_where", "z < 0.4",
                            "-region_top_where", "z > 0.6", "-region_top_material_density", "5",
                            "-material_density", "2"], 2)
        regions = {region["name"]: region for region in record["regions"]}
        self.assertEqual(list(regions), ["body", "low", "top"])
        for name, density in (("body", 2), ("low", 2), ("top", 5)):
            self.assertAlmostEqual(regions[name]["volume"], 1 / 3, delta=1e-12)
            self.assertAlmostEqual(regions[name]["mass"], density / 3, delta=1e-12)
            self.assertEqual(regions[name]["cells"], 54)


class Probes(unittest.TestCase):
    def test_on_bent_cells(self):
        """On the surface of a ball of quadratic cells: what lies on it is found in its bent cells."""
        move = "0.1*x, 0.2*y, -0.1*z"
        for ranks in (1, 2):
            record = record_of(["-mesh_generate", "ball", "-mesh_resolution", "2", "-order", "2",
                                "-constraints", "all", "-constraint_all_where",
                                "x^2 + y^2 + z^2 > 0.2", "-constraint_all_move", move, "-probes",
                                "pole,near", "-probe_pole", "0, 0, 0.5", "-probe_near",
                                "0.3, 0.2, 0.25"], ranks)
            self.assertLess(math.dist(record["result"]["probes"]["pole"], (0, 0, -0.05)), 1e-12)
            self.assertLess(math.dist(record["result"]["probes"]["near"],
                                      (0.03, 0.04, -0.025)), 1e-3)

    def test_outside(self):
        refused = run([*STANDS, "-probes", "far", "-probe_far", "1, 1, 1.2"], 2)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("probe 'far' at (1, 1, 1.2) lies outside", refused.stdout.replace("1.,", "1,"))
        self.assertIn("nearest vertex", refused.stdout)


class Table(unittest.TestCase):
    def rows(self, options, ranks=1):
        with tempfile.TemporaryDirectory() as folder:
            done = run([*options, "-output_csv", "run.csv", "-snes_trefoil_record", "run.json"],
                       ranks, folder)
            self.assertEqual(done.returncode, 0, done.stdout)
            self.assertEqual(sorted(os.listdir(folder)), ["run.csv", "run.json"])
            with open(os.path.join(folder, "run.csv"), encoding="utf-8") as file:
                return [{key: float(value) for key, value in row.items()}
                        for row in csv.DictReader(file)]

    def test_a_line_for_each_load_step(self):
        scene = [*STANDS, *TIGHT, *PUSHED, "-load_steps", "4", "-probes", "tip", "-probe_tip", "1, 1, 1"]
        for ranks in (1, 2):
            rows = self.rows(scene, ranks)
            self.assertEqual([row["t"] for row in rows], [0.25, 0.5, 0.75, 1])
            for row in rows:
                for axis, weight in (("x", 2e4 - 2.5e4), ("y", 1e4 + 3e3), ("z", -1.5e5 - 9810)):
                    self.assertLess(abs(row["low_reaction_" + axis] + row["t"] * weight), 1)
                    self.assertLess(abs(row["top_force_z"] + 1.5e5 * row["t"]), 1e-6)
            drops = [row["tip_displacement_z"] for row in rows]
            self.assertEqual(drops, sorted(drops, reverse=True))
            self.assertGreater(rows[-1]["load_work"], rows[-1]["strain_energy"])

    def test_the_record_says_the_same(self):
        record = record_of([*STANDS, *TIGHT, *PUSHED, "-load_steps", "2"])
        rows = self.rows([*STANDS, *TIGHT, *PUSHED, "-load_steps", "2"])
        self.assertEqual(len(record["steps"]), 2)
        for step, row in zip(record["steps"], rows):
            self.assertEqual(step["t"], row["t"])
            self.assertEqual(step["iterations"], row["iterations"])
            self.assertAlmostEqual(step["reaction"]["low"][2], row["low_reaction_z"], delta=1e-3)
            self.assertAlmostEqual(step["strain_energy"], row["strain_energy"], delta=1e-3)
        self.assertEqual(sum(step["iterations"] for step in record["steps"]),
                         record["result"]["iterations"])
        self.assertEqual(record["steps"][-1]["energy"], record["result"]["energy"])


class Screen(unittest.TestCase):
    def test_the_closing_words(self):
        printed = run([*STANDS, *PUSHED]).stdout
        for line in (r"^strain energy \S+, work of the loads \S+$",
                     r"^solver's estimate of the relative energy error \d",
                     r"^low: reaction \(\S+, \S+, \S+\), moment \(\S+, \S+, \S+\)$",
                     r"^top: force \(20000, 10000, -150000\)$",
                     r"^largest displacement \S+ at \(\S+, \S+, \S+\)$",
                     r"^largest von Mises stress \S+ at", r"^least det F \S+ at .*; volume \S+$"):
            self.assertRegex(printed, "(?m)" + line)

    def test_one_iteration_is_one(self):
        record = record_of([*STANDS])
        self.assertIn("converged in 1 iteration, 0 line-search trials", record["printed"])
        self.assertIn("nothing is strained", record["printed"])
        self.assertNotIn("inf", record["printed"].split("least det F")[0])

    def test_inverted_elements_are_a_warning(self):
        """Half the cube is turned inside out where it is held: elements are inverted for good."""
        record = record_of([*BOX, "-constraints", "all", "-constraint_all_where",
                            "z < 0.1 || z > 0.6", "-constraint_all_move", "0, 0, -0.9*(z > 0.6)"])
        self.assertEqual(record["status"], 0)
        inverted = record["result"]["inverted"]
        self.assertGreater(inverted, 0)
        self.assertRegex(record["printed"],
                         rf"converged in .*; WARNING: {inverted} elements are inverted[;\n]")
        self.assertTrue(any(f"{inverted} elements are inverted" in warning
                            for warning in record["result"]["warnings"]))


if __name__ == "__main__":
    unittest.main(verbosity=2)
