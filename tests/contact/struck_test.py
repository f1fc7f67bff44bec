#!/usr/bin/python3
"""What is prescribed runs into bodies that are free to give way: steps in time keep their length,
bodies are struck as fast as they must be, and nothing passes through anything. What contact is too
weak for, or holds only once it touches, is said in words that help."""
import json
import os
import sys
import unittest

import exact
import mesh_files
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import contact_scene_test as scenes  # noqa: E402

STEP = 0.02
RUBBER = ["-material_young", "1e5", "-material_poisson", "0.3", "-material_density", "1e3",
          "-time_step", str(STEP)]
CONE = """v 0.5 0.5 -0.02
v 0 0 -0.6
v 1 0 -0.6
v 1 1 -0.6
v 0 1 -0.6
f 1 2 3
f 1 3 4
f 1 4 5
f 1 5 2
"""


class Struck(scenes.ContactTest):
    def strike(self, options, end, ranks=1):
        """The record of a run none of whose steps had to be halved."""
        result = scenes.run([*RUBBER, "-time_end", str(end), *options, "-output_file", "run.xdmf",
                             "-snes_trefoil_record", "run.json"], ranks, self.folder)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertGreater(self.states("run.xdmf"), 1)
        with open(self.path("run.json"), encoding="utf-8") as file:
            record = json.load(file)
        steps = record["steps"][1:]
        self.assertEqual([step["dt"] for step in steps], [STEP] * round(end / STEP))
        self.assertEqual(sum(step["iterations"] for step in steps), record["result"]["iterations"])
        return record

    def test_a_floor_that_hits_a_free_block(self):
        """A cube of 1 t, in which waves need 0.1 s from end to end."""
        for speed in (1, 5, 20):
            with self.subTest(speed=speed):
                record = self.strike(
                    ["-mesh_generate", "box", "-mesh_resolution", "2", *scenes.FLOOR,
                     "-obstacle_floor_at", "0, 0, -0.01", "-obstacle_floor_move",
                     f"0, 0, {speed}*t"], 0.1)
                for step, state in zip(mesh_files.steps_of(self.path("run.xdmf")),
                                       record["steps"]):
                    surface = step.points[np.unique(exact.facets_of(step.cells))]
                    self.assertGreater(surface[:, 2].min(), -0.01 + speed * state["t"])
                # All of it moves as fast as the floor, or is still to be, or bounces off.
                momentum = record["result"]["momentum"]
                self.assertTrue(0.5 < momentum[2] / (1e3 * speed) < 2, momentum)
                self.assertLess(abs(momentum[0]), 1e-9 * momentum[2])

    def test_on_any_ranks(self):
        options = ["-mesh_generate", "box", "-mesh_resolution", "2", *scenes.FLOOR,
                   "-obstacle_floor_at", "0, 0, -0.01", "-obstacle_floor_move", "0, 0, 5*t",
                   "-obstacle_floor_friction", "0.3", "-contact_friction_iterations", "3"]
        one, two = (self.strike(options, 0.1, ranks)["result"] for ranks in (1, 2))
        for key in ("energy", "kinetic_energy", "contact_energy"):
            self.assertAlmostEqual(one[key] / two[key], 1, delta=1e-9, msg=key)

    def test_a_cone_that_rises_into_a_held_block(self):
        with open(self.path("cone.obj"), "w", encoding="utf-8") as file:
            file.write(CONE)
        rows = [line.split() for line in CONE.splitlines()]
        points = np.array([row[1:] for row in rows if row[0] == "v"], float)
        facets = np.array([row[1:] for row in rows if row[0] == "f"], int) - 1
        record = self.strike(
            ["-mesh_generate", "box", "-mesh_resolution", "3", *scenes.TOP, "-obstacles", "cone",
             "-obstacle_cone_file", "cone.obj", "-obstacle_cone_move", "0, 0, 0.8*t"], 0.4)
        self.assertLess(record["steps"][-1]["reaction"]["top"][2], -1e3)
        for step, state in zip(mesh_files.steps_of(self.path("run.xdmf")), record["steps"]):
            count, body = len(step.points), exact.facets_of(step.cells)
            all_facets = np.vstack([body, facets + count])
            all_points = np.vstack([step.points, points + [0, 0, 0.8 * state["t"]]])
            self.assertEqual(
                exact.intersections(all_points, exact.edges_of(all_facets), all_facets), [])

    def test_a_held_body_that_hits_a_free_one(self):
        scenes.boxes_file(self.path("boxes.mesh"), 0.02)
        record = self.strike(
            ["-mesh_file", "boxes.mesh", "-contact_self", "-constraints", "low",
             "-constraint_low_where", "z <= 1", "-constraint_low_move", "0, 0, 4*t"], 0.1)
        last = list(mesh_files.steps_of(self.path("run.xdmf")))[-1]
        self.assertAlmostEqual(last.points[:8, 2].max(), 1.4, delta=1e-12)
        self.assertGreater(last.points[8:, 2].min(), 1.4)
        self.assertGreater(record["result"]["contact_pairs"], 0)

    def test_an_obstacle_that_comes_round_a_curve(self):
        """Parts of a way that is not straight are looked at once more."""
        with open(self.path("cone.obj"), "w", encoding="utf-8") as file:
            file.write(CONE)
        self.strike(["-mesh_generate", "box", "-mesh_resolution", "2", "-obstacles", "cone",
                     "-obstacle_cone_file", "cone.obj", "-obstacle_cone_move",
                     "0.05*sin(60*t), 0.05*(1 - cos(60*t)), 2*t"], 0.1)

    def test_a_barrier_that_is_too_weak_fails_in_words_of_the_scene(self):
        fall = ["-mesh_generate", "box", "-mesh_resolution", "2", *scenes.FLOOR,
                "-obstacle_floor_at", "0, 0, -0.01", "-load_gravity", "0, 0, -9.81", *RUBBER,
                "-time_end", "0.1", "-time_step_min", "0.01", "-output_file", "run.xdmf"]
        for weak in (["-contact_stiffness", "1e-20"], ["-contact_distance", "1e-14"]):
            for ranks in (1, 2):
                result = scenes.run([*fall, *weak], ranks, self.folder)
                self.assertEqual(result.returncode, 3, result.stdout)
                for words in ("is halved: contact is too weak", "and obstacle 'floor' are only",
                              "a larger -contact_stiffness or -contact_distance, or shorter steps"):
                    self.assertIn(words, result.stdout)
                self.assertNotIn("TrefoilSNES", result.stdout)
                self.assertGreater(self.states("run.xdmf"), 1)
        result = scenes.run([*scenes.PRESSED, "-contact_stiffness", "1e-20", "-load_steps", "2"],
                            folder=self.folder)
        self.assertEqual(result.returncode, 3, result.stdout)
        self.assertIn("contact is too weak for what presses: ", result.stdout)


class HeldByContact(scenes.ContactTest):
    """A block that a pressure presses onto a floor, guided at one edge only."""
    PRESSED = ["-mesh_generate", "box", "-mesh_resolution", "2", "-material_young", "2.1e5",
               "-material_poisson", "0.3", *scenes.FLOOR, "-obstacle_floor_at", "0, 0, -0.001",
               "-obstacle_floor_friction", "0.3", "-constraints", "edge", "-constraint_edge_where",
               "x == xmin && y == ymin", "-constraint_edge_move", "0, 0, free", "-load_steps", "3",
               "-load_press_where", "z == zmax", "-load_press_pressure", "200*t"]

    def test_what_the_message_advises_helps(self):
        self.refused([*self.PRESSED, "-loads", "press"], "(2 of 6 rigid-body modes free)",
                     "what only contact is to hold needs a weak spring", "-load_NAME_spring")
        result = scenes.run([*self.PRESSED, "-loads", "press,weak", "-load_weak_where",
                             "z == zmax", "-load_weak_spring", "1", "-snes_trefoil_record",
                             "run.json"], folder=self.folder)
        self.assertEqual(result.returncode, 0, result.stdout)
        with open(self.path("run.json"), encoding="utf-8") as file:
            record = json.load(file)
        press, weak = (load["force"][2] for load in record["loads"])
        self.assertAlmostEqual(press, -200, delta=1e-6)
        self.assertLess(abs(weak), 1e-4 * abs(press))

    def test_without_contact_nothing_is_said_of_it(self):
        result = scenes.run(["-mesh_generate", "box", "-material_young", "1e5",
                             "-material_poisson", "0.3"], folder=self.folder)
        self.assertEqual(result.returncode, 1)
        self.assertNotIn("contact", result.stdout)


if __name__ == "__main__":
    unittest.main()
