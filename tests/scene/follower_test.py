#!/usr/bin/python3
"""Pressures that follow the body, and springs it stands on: closed forms, on every element, assembly
path and number of ranks; and what has no potential."""
import math
import unittest

from boxes import SLIDING, SPRING, THREE_PLANES, TIGHT
from trefoil_program import record_of, refusal_of, run

YOUNG = 1e6
PLANE = ["-mesh_generate", "square", "-mesh_resolution", "4", "-constraints", "floor,wall",
         "-constraint_floor_where", "y == ymin", "-constraint_floor_move", "free, 0",
         "-constraint_wall_where", "x == xmin", "-constraint_wall_move", "0, free"]
MATERIAL = [*SPRING, "-material_young", str(YOUNG), *TIGHT]


def squeezed(pressure, dimension):
    """The stretch of a body that is squeezed from all sides: young (s - 1) = -p s^(dimension - 1)."""
    if dimension == 2:
        return YOUNG / (YOUNG + pressure)
    return (-YOUNG + math.sqrt(YOUNG ** 2 + 4 * pressure * YOUNG)) / (2 * pressure)


class Follower(unittest.TestCase):
    def expect(self, record, stretch, pressure, dimension):
        self.assertEqual(record["status"], 0, record["printed"])
        end = record["result"]
        length = math.sqrt(dimension) * abs(1 - stretch)
        self.assertLess(abs(end["largest_displacement"]["value"] / length - 1), 1e-6)
        volume = stretch ** dimension
        self.assertLess(abs(end["volume"] / volume - 1), 1e-6)
        # The potential is the pressure times the volume.
        self.assertLess(abs(end["load_work"] / (pressure * (1 - volume)) - 1), 1e-6)
        force = record["loads"][0]["force"][:dimension]
        for component in force:
            self.assertLess(abs(component / (-pressure * stretch ** (dimension - 1)) - 1), 1e-6)
        for i in range(dimension):
            reactions = sum(c["reaction"][i] for c in record["constraints"])
            self.assertLess(abs(reactions / -force[i] - 1), 1e-6)

    def test_squeezed_from_all_sides(self):
        """Three faces, whose common rim slides in the planes of symmetry."""
        for pressure in (3e5, -2e4):
            for order in ("1", "2"):
                for ranks in (1, 2, 3):
                    with self.subTest(pressure=pressure, order=order, ranks=ranks):
                        record = record_of(
                            THREE_PLANES + MATERIAL +
                            ["-order", order, "-loads", "p", "-load_p_where",
                             "x == xmax || y == ymax || z == zmax", "-load_p_pressure",
                             str(pressure), "-load_p_follower"], ranks)
                        self.expect(record, squeezed(pressure, 3), pressure, 3)
                        self.assertLessEqual(record["result"]["iterations"], 25)

    def test_in_the_plane(self):
        for order in ("1", "2"):
            for assembly in ("split", "plain"):
                record = record_of(PLANE + MATERIAL + [
                    "-order", order, "-assembly", assembly, "-loads", "p", "-load_p_where",
                    "x == xmax || y == ymax", "-load_p_pressure", "3e5", "-load_p_follower"], 2)
                self.expect(record, squeezed(3e5, 2), 3e5, 2)

    def test_in_load_steps(self):
        record = record_of(THREE_PLANES + MATERIAL + [
            "-load_steps", "3", "-loads", "p", "-load_p_where",
            "x == xmax || y == ymax || z == zmax", "-load_p_pressure", "3e5", "-load_p_follower"])
        self.expect(record, squeezed(3e5, 3), 3e5, 3)
        first = record["steps"][0]["largest_displacement"]["value"]
        self.assertLess(abs(first / (math.sqrt(3) * (1 - squeezed(1e5, 3))) - 1), 1e-6)

    def test_a_dead_pressure_is_another_load(self):
        record = record_of(THREE_PLANES + MATERIAL + [
            "-loads", "p", "-load_p_where", "x == xmax || y == ymax || z == zmax",
            "-load_p_pressure", "2e4"])
        moved = record["result"]["largest_displacement"]["value"]
        self.assertLess(abs(moved / (math.sqrt(3) * 0.02) - 1), 1e-6)


class Springs(unittest.TestCase):
    def test_a_body_that_stands_on_springs(self):
        """Pulled up by 2e4 on an area of one: the springs give 2e4 / k, the body 2e4 / young."""
        pulled = ["-loads", "top,bed", "-load_top_where", "z == zmax", "-load_top_traction",
                  "0, 0, 2e4", "-load_bed_where", "z == zmin", "-load_bed_spring", "1e5"]
        held = SLIDING[:4] + SLIDING[8:] + ["-constraints", "wall,back"]
        for kind in (["-load_bed_spring_normal"], []):
            for order in ("1", "2"):
                for ranks in (1, 2, 3):
                    record = record_of(held + MATERIAL + pulled + kind +
                                       ["-order", order, "-probes", "top", "-probe_top",
                                        "0.5, 0.5, 1"], ranks)
                    self.assertEqual(record["status"], 0, record["printed"])
                    self.assertLess(abs(record["result"]["probes"]["top"][2] / 0.22 - 1), 1e-6)
                    bed = record["loads"][1]
                    self.assertLess(abs(bed["force"][2] / -2e4 - 1), 1e-6)
                    # Springs store k/2 u^2, which is work against the body.
                    work = record["result"]["load_work"]
                    self.assertLess(abs(work / (2e4 * 0.22 - 1e5 / 2 * 0.2 ** 2) - 1), 1e-6)

    def test_alone_they_hold_a_body(self):
        pushed = ["-mesh_generate", "box", "-mesh_resolution", "3", *MATERIAL, "-loads",
                  "push,bed", "-load_push_where", "x == xmax", "-load_push_force", "1e3, 0, 0",
                  "-load_bed_where", "z == zmin", "-load_bed_spring", "1e5"]
        for ranks in (1, 2):
            record = record_of(pushed, ranks)
            self.assertEqual(record["status"], 0, record["printed"])
            self.assertLess(abs(record["loads"][1]["force"][0] / -1e3 - 1), 1e-6)
        loose = run([*pushed, "-load_bed_spring_normal"])
        self.assertEqual(loose.returncode, 1)
        self.assertIn("3 of 6 rigid-body modes free", loose.stdout)


class Rims(unittest.TestCase):
    def test_one_that_is_free_is_said(self):
        """A pressure on the face at the end of a block that bends under another load."""
        block = ["-mesh_generate", "box", "-mesh_resolution", "3", *MATERIAL, "-constraints", "wall",
                 "-constraint_wall_where", "z == zmin", "-loads", "p,bend", "-load_p_where",
                 "x == xmax", "-load_p_pressure", "1e5", "-load_bend_where", "z == zmax",
                 "-load_bend_force", "0, 5e4, 0"]
        for ranks in (1, 2, 3):
            loose = record_of([*block, "-load_p_follower"], ranks)
            self.assertIn("a rim that is free", "".join(loose["result"]["warnings"]))
            self.assertIn("WARNING: a pressure that follows", loose["printed"])
            self.assertEqual(record_of(block, ranks)["result"]["warnings"], [])

    def test_one_in_planes_of_symmetry_is_none(self):
        record = record_of([*THREE_PLANES, *MATERIAL, "-loads", "p", "-load_p_where",
                            "x == xmax || y == ymax || z == zmax", "-load_p_pressure", "3e5",
                            "-load_p_follower"], 2)
        self.assertEqual(record["result"]["warnings"], [])


class Refused(unittest.TestCase):
    def test_in_one_sentence(self):
        scene = [*THREE_PLANES, "-loads", "p", "-load_p_where", "z == zmax"]
        for options, words in (
                (["-load_p_traction", "0, 0, 1", "-load_p_follower"], ["-load_p_pressure"]),
                (["-load_p_pressure", "1 + x", "-load_p_follower"], ["'1 + x'", "t alone"]),
                (["-load_p_pressure", "1", "-load_p_follower", "-load_p_where", "z == zmax*t"],
                 ["-load_p_where", "follows the body"]),
                (["-load_p_spring", "-1"], ["-load_p_spring", "negative"]),
                (["-load_p_traction", "0, 0, 1", "-load_p_spring_normal"], ["-load_p_spring"])):
            for ranks in (1, 2):
                sentence = refusal_of([*scene, *options], ranks)
                for word in words:
                    self.assertIn(word, sentence)


if __name__ == "__main__":
    unittest.main(verbosity=2)
