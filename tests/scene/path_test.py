#!/usr/bin/python3
"""The path that a hard scene is led on of the program's own accord: where it is taken, where it is
cut, and where it is not."""
import math
import os
import sys
import tempfile
import unittest

from boxes import BOX, ENDS
from trefoil_program import ROOT, record_of

sys.path.insert(0, os.path.join(ROOT, "tests"))
from hard_case_meshes import bar  # noqa: E402  (beside the folder of this file)

# A cube, two faces held, one turned about its axis: half a turn, written as where it ends.
TURN = ["-material_poisson", "0.495", "-material_young", "1", "-constraints", "held,turned",
        "-constraint_held_where", "x == xmin", "-constraint_held_move", "0, 0, 0",
        "-constraint_turned_where", "x == xmax", "-constraint_turned_move", "0, 1 - 2*y, 1 - 2*z"]
HALF_TURN = [*TURN, "-mesh_generate", "box", "-mesh_resolution", "6"]


def above_rest(record):
    return record["result"]["energy"] - record["result"]["energy_rest"]


class HalfTurn(unittest.TestCase):
    def test_ends_where_loading_leads(self):
        for ranks in (1, 2):
            for model in ("stable_neo_hookean", "neo_hookean"):
                scene = [*HALF_TURN, "-material_model", model]
                with self.subTest(model=model, ranks=ranks):
                    ours, loaded = record_of(scene, ranks), record_of([*scene, "-load_steps", "4"])
                    self.assertEqual(ours["status"], 0)
                    self.assertEqual(ours["result"]["inverted"], 0)
                    self.assertLess(above_rest(ours), 1.001 * above_rest(loaded))
                    self.assertGreater(above_rest(ours), 0.999 * above_rest(loaded))

    def test_of_a_bar_keeps_its_elements(self):
        """A leap ends in a minimum of five times the energy, with all elements whole."""
        with tempfile.TemporaryDirectory() as folder:
            mesh = os.path.join(folder, "bar.mesh")
            bar(mesh)
            scene = [*TURN, "-mesh_file", mesh]
            ours = record_of(scene)
            leap = record_of([*scene, "-initial", "harmonic"])
        self.assertEqual([ours["status"], leap["status"]], [0, 0])
        self.assertTrue(leap["result"]["minimum"])
        self.assertEqual(ours["result"]["inverted"], 0)
        self.assertAlmostEqual(above_rest(ours), 0.14004, delta=2e-4)
        self.assertGreater(above_rest(leap), 2 * above_rest(ours))

    def test_record_lists_the_steps(self):
        record = record_of(HALF_TURN)
        steps, result = record["steps"], record["result"]
        self.assertGreater(len(steps), 2)
        self.assertEqual([step.get("loose", False) for step in steps],
                         [True] * (len(steps) - 1) + [False])
        self.assertEqual(sum(step["iterations"] for step in steps), result["iterations"])
        self.assertEqual(steps[-1]["t"], 1)
        self.assertEqual(steps[-1]["energy"], result["energy"])
        self.assertEqual(len(result["load_step_iterations"]), len(steps))

    def test_none_where_the_user_says_how(self):
        for option in (["-initial", "harmonic"], ["-load_steps", "1"],
                       ["-snes_type", "newtonls", "-snes_max_it", "3"]):
            with self.subTest(option=option):
                record = record_of(HALF_TURN + option)
                self.assertLessEqual(len(record["steps"]), 1)
                self.assertNotIn("load_step_iterations", record["result"])
                self.assertNotIn("path to", record["printed"])

    def test_defaults_written_out_change_nothing(self):
        left = record_of(HALF_TURN)
        for option in (["-initial", "auto"], ["-snes_type", "trefoil"]):
            with self.subTest(option=option):
                given = record_of([*HALF_TURN, *option])
                self.assertEqual(given["result"].get("load_step_iterations"),
                                 left["result"]["load_step_iterations"])


def turn_in_time(degrees):
    """A cube whose top turns about its axis, written in t."""
    angle = f"{math.radians(degrees)}*t"
    return [*ENDS, "-material_poisson", "0.495", "-constraint_low_move", "0, 0, 0",
            "-constraint_high_move", f"(x-0.5)*(cos({angle})-1) - (y-0.5)*sin({angle}), "
            f"(x-0.5)*sin({angle}) + (y-0.5)*(cos({angle})-1), 0"]


class OwnWay(unittest.TestCase):
    """What is written in t and goes another way than the program would lead it is followed."""

    def test_of_a_turn_by_more_than_half(self):
        for degrees in (270, 360):
            with self.subTest(degrees=degrees):
                scene = turn_in_time(degrees)
                ours, loaded = record_of(scene), record_of([*scene, "-load_steps", "8"])
                self.assertEqual(ours["status"], 0)
                self.assertGreater(len(ours["steps"]), 2)
                self.assertIn("a way of its own", ours["printed"])
                self.assertAlmostEqual(above_rest(ours) / above_rest(loaded), 1, delta=1e-2)

    def test_of_what_returns(self):
        scene = [*ENDS, "-constraint_low_move", "0, 0, 0", "-constraint_high_move"]
        there = record_of([*scene, "0, 0, 0.4*sin(_pi*t)"])
        self.assertGreater(len(there["steps"]), 2)
        self.assertLess(above_rest(there), 1e-9)

    def test_of_a_load(self):
        scene = [*BOX, "-constraints", "low", "-constraint_low_where", "z == zmin", "-loads", "pull",
                 "-load_pull_where", "z == zmax", "-load_pull_traction"]
        for traction, steps in (("0, 0, 10*t + 40*t*(1-t)", 3), ("0, 0, 10*t*t", 1), ("0, 0, 10*t", 1),
                                ("0, 0, 10", 1)):
            with self.subTest(traction=traction):
                self.assertEqual(len(record_of([*scene, traction])["steps"]), steps)

    def test_of_no_scene_that_the_program_would_lead_alike(self):
        still = [*ENDS, "-constraint_low_move", "0, 0, 0", "-constraint_high_move"]
        for scene in (turn_in_time(60), [*still, "0.1*t, 0, 0.2*z*t"], [*still, "0.1*sin(_pi/2*t), 0, 0.2*t*t"],
                      [*still, "free, 0.1*x*t, 0.2*t"]):
            with self.subTest(move=scene[-1]):
                record = record_of(scene)
                self.assertEqual(len(record["steps"]), 1)
                self.assertNotIn("path to", record["printed"])


class Cut(unittest.TestCase):
    def test_is_halved_where_a_step_starts_at_infinite_energy(self):
        """Log J: the last third of half a turn is too far in one step."""
        record = record_of([*HALF_TURN, "-mesh_resolution", "8", "-material_model", "neo_hookean"])
        self.assertEqual(record["status"], 0)
        self.assertGreater(record["result"]["path_halvings"], 0)
        self.assertIn("is halved", record["printed"])
        self.assertIn("halved down", record["printed"])
        self.assertEqual(record["result"]["inverted"], 0)


    def test_iterations_that_are_not_allowed_end_it_at_once(self):
        record = record_of([*HALF_TURN, "-snes_max_it", "1"])
        self.assertNotEqual(record["status"], 0)
        self.assertNotIn("halved", record["printed"])
        self.assertNotIn("other equilibria", record["printed"])
        self.assertFalse(record["result"]["converged"])
        self.assertIn("-snes_max_it", record["result"]["reason"])
        self.assertEqual(record["result"]["iterations"], 1)
        self.assertLess(record["result"]["t"], 1)


class Mild(unittest.TestCase):
    def test_takes_no_more_steps_than_newton(self):
        """One leap, and no more of its steps than Newton's method needs to come as far."""
        for move in ("0, 0, 0.02", "0.02, 0, 0", "0, 0, -0.02", "0, 0, 0.2", "0, 0.3, 0"):
            scene = [*ENDS, "-constraint_low_move", "0, 0, 0", "-constraint_high_move", move]
            ours = record_of(scene)
            self.assertEqual(ours["status"], 0)
            self.assertEqual(len(ours["steps"]), 1)
            self.assertNotIn("path to", ours["printed"])
            bound = ours["result"]["energy"] + 1e-7 * ours["result"]["energy_scale"]
            for start in (["-initial", "rest"], []):
                newton = record_of([*scene, *start, "-snes_type", "newtonls",
                                    "-snes_linesearch_type", "bt"])
                with self.subTest(move=move, start=start):
                    reached = [k for k, state in enumerate(newton["history"])
                               if state["energy"] <= bound]
                    self.assertTrue(reached)
                    self.assertLessEqual(len(ours["history"]) - 1, reached[0])


class HardEnd(unittest.TestCase):
    def test_has_tried_the_path_and_says_what_is_inverted(self):
        """A leap whose guess is whole and whose end is not."""
        scene = [*BOX, "-material_poisson", "0.3", "-constraints", "low,high",
                 "-constraint_low_where", "z == zmin", "-constraint_high_where", "z == zmax",
                 "-constraint_low_move", "0, 0, 0", "-constraint_high_move", "0, 0, -0.7"]
        record = record_of(scene)
        leap = record_of([*scene, "-initial", "arap"])
        self.assertGreater(leap["result"]["inverted"], 0)
        self.assertIn("path to", record["printed"])
        self.assertIn("the end of the leap, which came first, counts", record["printed"])
        self.assertLessEqual(above_rest(record), above_rest(leap) * (1 + 1e-6))
        self.assertGreater(record["result"]["iterations"], leap["result"]["iterations"])
        self.assertGreater(record["result"]["inverted"], 0)
        verdict = next(line for line in record["printed"].splitlines()
                       if line.startswith("converged in"))
        self.assertIn(f"WARNING: {record['result']['inverted']} elements are inverted", verdict)
        spent = record["result"]["iterations"] - leap["result"]["iterations"]
        self.assertEqual([row["iterations"] - spent for row in record["result"]["error_table"]],
                         [row["iterations"] for row in leap["result"]["error_table"]])
        # Both are counted; the states of the path that led elsewhere are marked as such.
        self.assertTrue(all(step["rejected"] for step in record["steps"][:-1]))
        self.assertNotIn("rejected", record["steps"][-1])
        self.assertEqual(record["steps"][-1]["iterations"], leap["result"]["iterations"])


class FoldedPath(unittest.TestCase):
    """A cube at nu .3, pressed by three tenths and turned: a path that is taken at once and ends with
    inverted elements. The leap is tried as well, and the lower end counts."""

    def ends(self, degrees, ranks=1):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        scene = [*BOX, "-mesh_resolution", "6", "-material_poisson", "0.3", "-material_young", "1",
                 "-constraints", "held,turned",
                 "-constraint_held_where", "z < 0.1", "-constraint_turned_where", "z > 0.9",
                 "-constraint_turned_move", f"{c - 1}*(x-0.5) - {s}*(y-0.5), "
                 f"{s}*(x-0.5) + {c - 1}*(y-0.5), -0.3"]
        record = record_of(scene, ranks)
        self.assertEqual(record["status"], 0)
        self.assertIn("the path ends with inverted elements: a leap, too", record["printed"])
        leap = record_of([*scene, "-load_steps", "1"], ranks)
        return record, leap

    def test_counts_where_no_leap_is_lower(self):
        record, leap = self.ends(130)
        self.assertLess(above_rest(record), above_rest(leap) * (1 + 1e-9))
        self.assertFalse(any("rejected" in step for step in record["steps"]))
        self.assertIn("the end of the path, which came first, counts", record["printed"])
        self.assertEqual(record["result"]["iterations"], leap["result"]["iterations"]
                         + sum(step["iterations"] for step in record["steps"]))

    def test_gives_way_to_a_lower_leap(self):
        for ranks in (1, 2):
            record, leap = self.ends(160, ranks)
            self.assertAlmostEqual(above_rest(record), above_rest(leap), delta=1e-6)
            self.assertIn("the leap ends below the path, which came first", record["printed"])
            self.assertEqual(record["steps"][-1]["iterations"], leap["result"]["iterations"])
            self.assertTrue(all(step["rejected"] for step in record["steps"][:-1]))


if __name__ == "__main__":
    unittest.main()
