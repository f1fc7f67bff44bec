#!/usr/bin/python3
"""Obstacles in the output: each in a file of its own, where it is at every state; in pictures, films
and the page. A scene without has none. What stands in the way of the files is said before the solve."""
import os
import subprocess
import sys
import tempfile
import unittest

import matplotlib.image
import numpy as np

import contact_scene_test
import exact
import mesh_files
from contact_scene_test import BOX, CONE, FLOOR, PRESSED, TOP, run

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
EXAMPLES = os.path.join(ROOT, "examples")
sys.path.insert(0, os.path.join(EXAMPLES, "python"))
import trefoil  # noqa: E402


class Obstacles(contact_scene_test.ContactTest):
    def ended(self, options, ranks=1, status=0):
        result = run(options, ranks, self.folder)
        self.assertEqual(result.returncode, status, result.stdout)
        return result.stdout

    def draw(self, program, *arguments):
        done = subprocess.run(["/usr/bin/python3", os.path.join(EXAMPLES, program), *arguments],
                              cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def cone(self):
        with open(self.path("cone.obj"), "w", encoding="utf-8") as file:
            file.write(CONE)
        return ["-obstacle_cone_file", "cone.obj", "-obstacle_cone_move", "0, 0, -0.08"]

    def test_where_they_are_at_every_state_on_any_ranks(self):
        options = [*BOX, "-constraints", "low", "-constraint_low_where", "z == zmin",
                   "-obstacles", "cone,side", *self.cone(), "-obstacle_side_plane", "1, 0, 0",
                   "-obstacle_side_at", "-0.5, 0, 0", "-obstacle_side_move", "0.1*t*t, 5*t, 0",
                   "-load_steps", "auto", "-output_every", "2"]
        for ranks in (1, 3):
            self.ended([*options, "-output_file", "run.xdmf"], ranks)
            body = trefoil.read_steps(self.path("run.xdmf"))
            found = trefoil.read_obstacles(self.path("run.xdmf"))
            self.assertEqual(sorted(found), ["cone", "side"])
            for steps in found.values():
                self.assertEqual([step.t for step in steps], [step.t for step in body])
            for cone, side in zip(found["cone"], found["side"]):
                self.assertEqual(cone.cells.shape, (6, 3))
                self.assertEqual(cone.points[4].tolist(), [0.5, 0.5, 1.05])
                moved = cone.fields["displacement"]
                self.assertLess(abs(moved - [0, 0, -0.08 * cone.t]).max(), 1e-15)
                self.assertLess(abs(side.points[:, 0] + 0.5).max(), 1e-14)
                self.assertLess(abs(side.fields["displacement"]
                                    - [0.1 * side.t ** 2, 5 * side.t, 0]).max(), 1e-14)
                # In front of the body's middle, about its size, its front to the body.
                size = np.ptp(side.points, axis=0)[1:]
                self.assertTrue((np.sqrt(3) < size).all() and (size < 2 * np.sqrt(3)).all())
                self.assertLess(abs(side.points.mean(axis=0)[1:] - 0.5).max(), 1e-14)
                a, b, c = side.points[side.cells[0]]
                self.assertGreater(np.cross(b - a, c - a)[0], 0)

    def test_in_the_plane_and_as_vtu(self):
        options = ["-mesh_generate", "square", "-mesh_resolution", "3", "-constraints", "top",
                   "-constraint_top_where", "y == ymax", "-constraint_top_move", "0, -0.15",
                   "-obstacles", "floor", "-obstacle_floor_plane", "0.2, 1",
                   "-obstacle_floor_at", "0, -0.1"]
        self.ended([*options, "-output_file", "flat.xdmf", "-load_steps", "1"])
        floor = trefoil.read_obstacles(self.path("flat.xdmf"))["floor"][-1]
        self.assertEqual(floor.cells.tolist(), [[0, 1]])
        self.assertLess(abs(floor.points @ [0.2, 1, 0] + 0.1).max(), 1e-14)
        self.draw("picture.py", "flat.xdmf", "-o", "flat.png")
        self.ended([*options, "-output_file", "flat.vtu", "-load_steps", "2"], 2)
        for name in ("flat.floor.pvd", "flat.floor_0000.vtu", "flat.pvd"):
            self.assertTrue(os.path.exists(self.path(name)), name)

    def test_a_scene_without_has_none(self):
        self.ended([*BOX, *TOP, "-constraint_top_move", "0, 0, -0.1", "-output_file", "run.xdmf"])
        self.assertEqual(trefoil.read_obstacles(self.path("run.xdmf")), {})
        self.assertEqual(sorted(os.listdir(self.folder)), ["run.h5", "run.xdmf"])

    def test_a_run_that_goes_on(self):
        options = ["-mesh_generate", "box", "-mesh_resolution", "2", "-material_density", "1e3",
                   "-load_gravity", "0, 0, -9.81", *FLOOR, "-obstacle_floor_move", "0, 0, 0.1*t",
                   "-time_step", "0.05", "-output_file", "run.xdmf", "-checkpoint", "run.ckpt"]
        self.ended([*options, "-time_end", "0.1"], 2)
        self.ended([*options, "-time_end", "0.2", "-restart", "run.ckpt"])
        floor = trefoil.read_obstacles(self.path("run.xdmf"))["floor"]
        self.assertEqual(np.round([step.t for step in floor], 9).tolist(), [0, .05, .1, .15, .2])
        self.assertAlmostEqual(floor[-1].fields["displacement"][0, 2], 0.02, delta=1e-14)

    def test_nothing_is_written_over(self):
        os.mkdir(self.path("run.floor.xdmf"))
        self.refused([*PRESSED, "-output_file", "run.xdmf"], "run.floor.xdmf", "a directory")
        self.refused([*PRESSED, "-output_file", "out.xdmf", "-output_csv", "out.floor.h5"],
                     "would write over 'out.floor.h5'")

    def test_pictures_films_and_pages_draw_them(self):
        options = [*PRESSED, "-load_steps", "2", "-snes_trefoil_record", "run.json"]
        self.ended([*options, "-output_file", "run.xdmf"])
        with open(self.path("run.xdmf"), encoding="utf-8") as file:
            text = file.read()
        self.assertIn('<Domain Obstacles="floor">', text)
        with open(self.path("alone.xdmf"), "w", encoding="utf-8") as file:
            file.write(text.replace(' Obstacles="floor"', ""))
        greys = []
        for name in ("run", "alone"):
            self.draw("picture.py", f"{name}.xdmf", "-o", f"{name}.png", "--no-edges", "--dpi", "60")
            image = matplotlib.image.imread(self.path(f"{name}.png"))[..., :3]
            blueish = (image[..., 2] > image[..., 0] + 0.03) & (np.ptp(image, axis=2) < 0.2)
            greys.append(blueish.mean())
            self.draw("animate.py", f"{name}.xdmf", "-o", f"{name}.gif", "--seconds", "0.2")
            self.draw("report.py", "run.json", f"{name}.xdmf", "-o", f"{name}.html")
        self.assertGreater(greys[0], 0.1)
        self.assertLess(greys[1], 0.02)
        with open(self.path("run.html"), encoding="utf-8") as file:
            self.assertIn('"obstacles":true', file.read())
        with open(self.path("alone.html"), encoding="utf-8") as file:
            self.assertIn('"obstacles":false', file.read())


class Stack(unittest.TestCase):
    def test_three_blocks_come_to_rest_and_none_enters_another(self):
        with tempfile.TemporaryDirectory() as folder:
            result = run([os.path.join(EXAMPLES, "stack.yaml"), "-output_csv", "stack.csv"], 2, folder)
            self.assertEqual(result.returncode, 0, result.stdout)
            steps = list(mesh_files.steps_of(os.path.join(folder, "stack.xdmf")))
            for step in steps:
                self.assertEqual(exact.intersections_of(step), [], step.name)
                self.assertGreater(step.points[:, 2].min(), -0.02)
            self.assertGreater(len(steps), 25)
            # The blocks stand on each other, and creep at less than the slip velocity.
            rest = trefoil.read_steps(os.path.join(folder, "stack.xdmf"))
            diagonal = np.linalg.norm(np.ptp(rest[0].points, axis=0))
            self.assertLess(abs(rest[-1].fields["velocity"]).max(), 3e-3 * diagonal)
            low, middle, high = (rest[-1].points + rest[-1].fields["displacement"])[[0, 64, 128], 2]
            self.assertTrue(-0.02 < low < -0.01 and 0.9 < middle < 1 and 1.7 < high < 1.8,
                            (low, middle, high))


if __name__ == "__main__":
    unittest.main()
