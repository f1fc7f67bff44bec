#!/usr/bin/python3
"""Vertices that slide in planes of any normal: the same as by components where both can say it, and a
turned body is the body that is not turned."""
import math
import os
import tempfile
import unittest

from boxes import THREE_PLANES, TIGHT, energy
from group_test import cube
from trefoil_program import record_of, refusal_of

LIFTED = ["-constraints", "floor,wall,back,lid"]
MATERIAL = ["-material_young", "1e5", "-material_poisson", "0.3", *TIGHT]
# Columns of a rotation: where the axes of the cube lie.
C, S = math.cos(0.7), math.sin(0.7)
E1, E2, E3 = (C, S * 0.6, S * 0.8), (-S, C * 0.6, C * 0.8), (0, -0.8, 0.6)


def turned(p):
    return [p[0] * a + p[1] * b + p[2] * c for a, b, c in zip(E1, E2, E3)]


def formula(axis):
    """The coordinate along an axis."""
    return "(" + " + ".join(f"({component!r})*{name}" for component, name in zip(axis, "xyz")) + ")"


def values(axis, factor=1.0):
    return ", ".join(repr(factor * component) for component in axis)


class Slides(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.straight = cls.write("straight.mesh", lambda p: p)
        cls.turned = cls.write("turned.mesh", turned)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def write(cls, name, place):
        vertices, cells = cube()
        path = os.path.join(cls.folder.name, name)
        with open(path, "w", encoding="ascii") as file:
            file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices {len(vertices)}\n")
            file.writelines(" ".join(map(repr, place(p))) + " 0\n" for p in vertices)
            file.write(f"Tetrahedra {len(cells)}\n")
            file.writelines(" ".join(str(v + 1) for v in cell) + " 0\n" for cell in cells)
            file.write("End\n")
        return path

    def straight_scene(self):
        return ["-mesh_file", self.straight, *THREE_PLANES[4:], *MATERIAL, "-loads", "top",
                "-load_top_where", "z == 1", "-load_top_traction", "1e4*x, 0, 2e4", "-probes",
                "tip", "-probe_tip", "1, 1, 1"]

    def turned_scene(self):
        z, x = formula(E3), formula(E1)
        traction = ", ".join(f"1e4*{x}*({a!r}) + 2e4*({c!r})" for a, c in zip(E1, E3))
        return ["-mesh_file", self.turned, *MATERIAL, "-constraints", "floor,wall,back",
                "-constraint_floor_where", f"{z} == 0", "-constraint_floor_slide", values(E3),
                "-constraint_wall_where", f"{x} == 0", "-constraint_wall_slide", values(E1, -3),
                "-constraint_back_where", f"{formula(E2)} == 0", "-constraint_back_slide",
                values(E2), "-loads", "top", "-load_top_where", f"{z} == 1",
                "-load_top_traction", traction, "-probes", "tip", "-probe_tip",
                values(turned((1, 1, 1)))]

    def test_a_turned_body_is_the_same(self):
        for options in ([], ["-order", "2"], ["-initial", "rest"], ["-load_steps", "2"],
                        ["-pc_type", "gamg", "-ksp_rtol", "1e-12"], ["-assembly", "plain"]):
            straight = record_of(self.straight_scene() + options)
            for ranks in (1, 2, 3):
                with self.subTest(options=options, ranks=ranks):
                    record = record_of(self.turned_scene() + options, ranks)
                    self.assertEqual(record["status"], 0, record["printed"])
                    self.assertLess(abs(energy(record) / energy(straight) - 1), 1e-9)
                    tip = turned(straight["result"]["probes"]["tip"])
                    for found, expected in zip(record["result"]["probes"]["tip"], tip):
                        self.assertAlmostEqual(found, expected, delta=1e-6)
                    self.compare_reactions(record, straight)

    def compare_reactions(self, record, straight):
        sums = [0, 0, 0]
        for found, expected in zip(record["constraints"], straight["constraints"]):
            for key in ("reaction", "moment"):
                for a, b in zip(found[key], turned(expected[key])):
                    self.assertAlmostEqual(a, b, delta=1e-3)
            sums = [s + r for s, r in zip(sums, found["reaction"])]
        for total, load in zip(sums, record["loads"][0]["force"]):
            self.assertAlmostEqual(total, -load, delta=1e-3)

    def test_along_an_axis_it_is_a_component(self):
        by_slide = record_of([
            "-mesh_file", self.straight, "-constraints", "ground,wall,back", "-constraint_ground_where", "z == zmin",
            "-constraint_ground_slide", "0, 0, 2", "-constraint_wall_where", "x == xmin",
            "-constraint_wall_move", "0, free, free", "-constraint_back_where", "y == ymin",
            "-constraint_back_slide", "0, -1, 0", *MATERIAL, "-loads", "top", "-load_top_where",
            "z == 1", "-load_top_traction", "1e4*x, 0, 2e4"])
        self.assertLess(abs(energy(by_slide) / energy(record_of(self.straight_scene())) - 1), 1e-12)

    def test_in_the_plane(self):
        """Uniaxial tension between two oblique planes through the origin is no uniform state; but a
        square on its corner, held at its two lower sides, is the square that stands upright."""
        upright = ["-mesh_generate", "square", "-mesh_resolution", "4", *MATERIAL, "-constraints",
                   "floor,wall", "-constraint_wall_where", "x == xmin", "-constraint_wall_move",
                   "0, free", "-constraint_floor_where", "y == ymin", "-loads", "top",
                   "-load_top_where", "y == ymax", "-load_top_traction", "0, 2e4"]
        moved, slid = (record_of([*upright, *floor], 2) for floor in (
            ["-constraint_floor_move", "free, 0"], ["-constraint_floor_slide", "0, 1"]))
        self.assertLess(abs(energy(slid) / energy(moved) - 1), 1e-12)
        # A plane that is turned by a little holds the body all the same, with the wall as a rail.
        oblique = record_of([*upright, "-constraint_floor_slide", "0.001, 1"], 2)
        self.assertEqual(oblique["status"], 0, oblique["printed"])
        self.assertLess(abs(energy(oblique) / energy(moved) - 1), 1e-2)
        self.assertGreater(abs(energy(oblique) / energy(moved) - 1), 1e-9)

    def test_refused(self):
        scene = ["-mesh_file", self.straight, "-constraints", "a,b", "-constraint_a_where", "z == 0"]
        for options, words in (
                (["-constraint_a_slide", "0, 0, 0"], ["-constraint_a_slide", "normal"]),
                (["-constraint_a_slide", "0, 1"], ["-constraint_a_slide", "3"]),
                (["-constraint_a_slide", "t, 1, 0"], ["-constraint_a_slide", "t"]),
                (["-constraint_a_slide", "1, 1, 0", "-constraint_a_move", "0, 0, 0"], ["both"]),
                (["-constraint_a_slide", "0, 1, 1", "-constraint_b_move", "0, 0, 1"],
                 ["'a'", "another constraint moves it"]),
                (["-constraint_a_slide", "0, 0.7071, 0.7072", "-constraint_b_where", "z == 0",
                  "-constraint_b_slide", "0, 1, 1"], ["'b'", "the same normal"])):
            b = ["-constraint_b_where", "x == 0 && z == 0" if "b_move" in str(options) else "z == 1"]
            for ranks in (1, 2):
                sentence = refusal_of([*scene, *b, *options], ranks)
                for word in words:
                    self.assertIn(word, sentence)


if __name__ == "__main__":
    unittest.main(verbosity=2)
