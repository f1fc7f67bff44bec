#!/usr/bin/python3
"""Scenes with contact: no accepted iterate and no state intersects itself or an obstacle, which
exact.py says independently; friction sticks and slips; ranks agree; what cannot be is refused."""
import csv
import json
import os
import re
import sys
import tempfile
import unittest

import exact
import mesh_files

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(os.path.dirname(os.path.dirname(HERE)), "examples")
sys.path[:0] = [EXAMPLES, os.path.join(os.path.dirname(HERE), "scene")]
import overhand_knot  # noqa: E402
from trefoil_program import run  # noqa: E402

BOX = ["-mesh_generate", "box", "-mesh_resolution", "3", "-material_young", "1e5",
       "-material_poisson", "0.3"]
FLOOR = ["-obstacles", "floor", "-obstacle_floor_plane", "0, 0, 1", "-obstacle_floor_at",
         "0, 0, -0.1"]
TOP = ["-constraints", "top", "-constraint_top_where", "z == zmax"]
PRESSED = [*BOX, *FLOOR, *TOP, "-constraint_top_move", "0, 0, -0.3"]
KNOT = ["-mesh_generate", "knot", "-material_young", "1e6", "-material_poisson", "0.4",
        "-constraints", "left,right",
        "-constraint_left_where", "x < xmin + 0.12*(xmax-xmin)",
        "-constraint_left_move", "-0.3*(xmax-xmin), 0, 0",
        "-constraint_right_where", "x > xmax - 0.12*(xmax-xmin)",
        "-constraint_right_move", "0.3*(xmax-xmin), 0, 0"]
CONE = """v 0.2 0.2 1.6
v 0.8 0.2 1.6
v 0.8 0.8 1.6
v 0.2 0.8 1.6
v 0.5 0.5 1.05
f 5 2 1
f 5 3 2
f 5 4 3
f 5 1 4
f 1 2 3 4
"""


def boxes_file(path, gap):
    """Two unit cubes of six tetrahedra each, one above the other; a Medit file."""
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    split = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]
    points = [(x, y, z) for x, y, z in corners]
    points += [(0.1 + 0.8 * x, 0.15 + 0.8 * y, z + 1 + gap) for x, y, z in corners]
    cells = [tuple(8 * body + c for c in cell) for body in (0, 1) for cell in split]
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n")
        file.writelines(f"{x} {y} {z} 0\n" for x, y, z in points)
        file.write(f"Tetrahedra\n{len(cells)}\n")
        file.writelines(" ".join(str(c + 1) for c in cell) + " 0\n" for cell in cells)
        file.write("End\n")


class ContactTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def solve(self, options, ranks=1, status=0):
        """The record of a run, whose states and iterates are all free of intersections; what it
        printed is `self.printed`."""
        result = run([*options, "-output_file", "run.xdmf", "-contact_iterates", "iterates.xdmf",
                      "-snes_trefoil_record", "run.json"], ranks, self.folder)
        self.assertEqual(result.returncode, status, result.stdout)
        self.printed = result.stdout
        with open(self.path("run.json"), encoding="utf-8") as file:
            record = json.load(file)
        self.assertGreater(self.states("run.xdmf"), 0)
        self.assertGreaterEqual(self.states("iterates.xdmf"), record["result"]["iterations"] // 2)
        return record

    def states(self, name):
        count = 0
        for step in mesh_files.steps_of(self.path(name)):
            self.assertEqual(exact.intersections_of(step), [], f"{name}, {step.name}")
            count += 1
        return count

    def on_any_ranks(self, options):
        """Records of 1, 2 and 4 ranks, whose results agree to 1e-9. At the default tolerance they may
        differ by what the solver leaves, which is of first order in all but the energy."""
        tight = [*options, "-solver", "direct", "-snes_trefoil_energy_tolerance", "1e-12"]
        records = [self.solve(tight, ranks) for ranks in (1, 2, 4)]
        keys = ("energy", "strain_energy", "contact_energy", "min_gap")
        steps = records[0]["steps"]
        largest = {key: max(abs(step[key] or 0) for step in steps) for key in keys}
        for record in records[1:]:
            self.assertEqual(len(record["steps"]), len(steps))
            for one, other in zip(steps, record["steps"]):
                self.assertEqual(other["contact_pairs"], one["contact_pairs"])
                for key in keys:
                    self.assertAlmostEqual(other[key] or 0, one[key] or 0,
                                           delta=1e-9 * largest[key], msg=key)
        return records

    def refused(self, options, *words):
        for ranks in (1, 2, 3):
            result = run(options, ranks, self.folder)
            self.assertEqual(result.returncode, 1, result.stdout)
            self.assertEqual(result.stdout.count("trefoil: "), 1, result.stdout)
            for word in words:
                self.assertIn(word, result.stdout)

    def assert_balance(self, force, other):
        """Two forces hold each other, up to the solver's tolerance."""
        for a, b in zip(force, other):
            self.assertAlmostEqual(a, -b, delta=1e-3 * max(map(abs, other)) + 1e-9)


PULLED = [*BOX, *FLOOR, *TOP, "-obstacle_floor_friction", "0.4", "-load_steps", "12",
          "-constraint_top_move", "0.4*max(0, t - 0.5), 0, -0.2*min(1, 2*t)"]


class HalfSpace(ContactTest):
    def test_a_block_pressed_onto_a_floor_on_any_ranks(self):
        records = self.on_any_ranks(PRESSED)
        results = [record["result"] for record in records]
        for record, result in zip(records, results):
            reaction = record["steps"][-1]["reaction"]["top"]
            self.assert_balance(result["contact_forces"]["floor"], reaction)
            self.assertAlmostEqual(result["energy"] / results[0]["energy"], 1, delta=1e-12)
        self.assertGreater(result["truncated"], 0)
        self.assertGreater(result["contact_energy"], 0)
        self.assertLess(0, result["min_gap"])
        self.assertLess(result["min_gap"], result["contact_distance"])
        for step in mesh_files.steps_of(self.path("iterates.xdmf")):
            self.assertGreater(step.points[:, 2].min(), -0.1)

    def test_friction_holds_up_to_its_cone(self):
        """Pressed, then pulled sideways: sticks at first, slips with mu times the normal force."""
        steps = self.solve(PULLED)["steps"]
        forces = [step["reaction"]["top"] for step in steps]
        ratios = [force[0] / -force[2] if force[2] < -1 else 0 for force in forces]
        self.assertLess(max(ratios), 0.4 * 1.005)
        self.assertGreater(ratios[-1], 0.4 * 0.98)
        sticking = ratios[steps.index(next(s for s in steps if s["t"] > 0.58))]
        self.assertLess(sticking, 0.3)
        # No more solves than it takes: one where nothing slides yet, or slides as before.
        solves = [step["friction_iterations"] for step in steps]
        self.assertIn(1, solves)
        self.assertGreater(max(solves), 1)
        self.assertNotIn("WARNING", self.printed)
        for step in steps:
            self.assert_balance(step["contact_forces"]["floor"], step["reaction"]["top"])
        self.assertIn("floor: contact force", self.printed)

    def test_a_run_says_how_far_friction_lags(self):
        """What it says is more than any reaction is off, and it warns of much."""
        records = {solves: self.solve([*PULLED, "-contact_friction_iterations", str(solves)])
                   for solves in (-1, 1, 3)}
        reactions = {solves: [step["reaction"]["top"] for step in record["steps"]]
                     for solves, record in records.items()}
        largest = max(abs(force[2]) for force in reactions[-1])
        lag = {solves: record["result"]["friction_lag"] for solves, record in records.items()}
        for solves in (1, 3):
            off = max(abs(a - b) for one, other in zip(reactions[solves], reactions[-1])
                      for a, b in zip(one, other)) / largest
            self.assertLess(1e-4 * lag[solves], off)
            self.assertLess(off, lag[solves])
        self.assertGreater(lag[1], 0.05)
        self.assertLess(lag[3], 0.05)
        self.assertLess(lag[-1], 1e-3)
        for solves, record in records.items():
            self.assertEqual(record["result"].get("friction_is_late", False), solves == 1)
            self.assertEqual(len(record["result"]["warnings"]), solves == 1)
        self.assertNotIn("WARNING", self.printed)
        self.solve([*PULLED, "-contact_friction_iterations", "1"])
        self.assertIn("WARNING: friction lags", self.printed)
        self.assertIn("take -contact_friction_iterations 3, or -1", self.printed)

    def test_advice_on_friction_that_lags_is_not_what_was_done(self):
        options = [*BOX, *FLOOR, *TOP, "-obstacle_floor_friction", "0.4", "-load_steps", "2",
                   "-constraint_top_move", "0, 0.9*t, -0.25*t", "-contact_friction_iterations", "3"]
        result = self.solve(options)["result"]
        advice = "take -contact_friction_iterations -1, until they fit, or shorter load steps"
        self.assertEqual(result["friction_advice"], advice)
        self.assertTrue(result["warnings"][0].endswith(advice), result["warnings"])
        self.assertIn(f"%: {advice}", self.printed)

    def test_in_the_plane(self):
        self.solve(["-mesh_generate", "square", "-mesh_resolution", "4", "-constraints", "top",
                    "-constraint_top_where", "y == ymax", "-constraint_top_move", "0, -0.3",
                    "-obstacles", "floor", "-obstacle_floor_plane", "0.2, 1",
                    "-obstacle_floor_at", "0, -0.1"])


class Bodies(ContactTest):
    def test_a_knot_meets_itself(self):
        record = self.solve([*KNOT, "-contact_self"])
        self.assertGreater(record["result"]["contact_pairs"], 10)
        # Without contact the same knot goes through itself.
        result = run([*KNOT, "-output_file", "free.xdmf"], folder=self.folder)
        self.assertEqual(result.returncode, 0, result.stdout)
        found = [exact.intersections_of(step)
                 for step in mesh_files.steps_of(self.path("free.xdmf"))]
        self.assertTrue(any(found))

    def test_a_rope_is_pulled_tight_on_its_knot(self):
        """Without contact the knot comes undone: the rope passes through itself."""
        overhand_knot.write(self.path("overhand_knot.mesh"), across=2, along=60)
        with open(os.path.join(EXAMPLES, "knot_tight.yaml"), encoding="utf-8") as file:
            scene = file.read()
        contact = "contact:     {self: true}\n"
        self.assertIn(contact, scene)
        for name, text in (("tight.yaml", scene), ("free.yaml", scene.replace(contact, ""))):
            with open(self.path(name), "w", encoding="utf-8") as file:
                file.write(text)
        record = self.solve(["tight.yaml"])
        self.assertGreater(record["result"]["contact_pairs"], 20)
        result = run(["free.yaml", "-output_file", "free.xdmf", "-load_steps", "4"],
                     folder=self.folder)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertTrue(any(exact.intersections_of(step)
                            for step in mesh_files.steps_of(self.path("free.xdmf"))))

    def test_a_knot_meets_itself_in_steps_with_and_without_filter(self):
        """The pattern of H changes in steps that make no N; the one from before does not fit then."""
        record = self.solve([*KNOT, "-contact_self", "-snes_trefoil_filter", "on_demand"])
        self.assertGreater(record["result"]["contact_pairs"], 10)
        self.assertLessEqual({0, 0.5}, {entry["weight"] for entry in record["history"]})

    def test_a_body_on_another_on_any_ranks(self):
        boxes_file(self.path("boxes.mesh"), 0.05)
        options = ["-mesh_file", "boxes.mesh", "-mesh_refine", "1", "-contact_distance", "0.01",
                   "-contact_friction", "0.2", "-constraints", "low,high",
                   "-constraint_low_where", "z == zmin", "-constraint_high_where", "z == zmax",
                   "-constraint_high_move", "0.1, 0, -0.2"]
        result = self.on_any_ranks([*options, "-load_steps", "2"])[-1]["result"]
        self.assertGreater(result["contact_pairs"], 10)

    def test_a_body_lands_and_slides_on_another_on_any_ranks(self):
        boxes_file(self.path("boxes.mesh"), 0.05)
        steps = self.on_any_ranks([
            "-mesh_file", "boxes.mesh", "-mesh_refine", "1", "-material_young", "1e5",
            "-material_poisson", "0.3", "-material_density", "1e3", "-contact_distance", "0.01",
            "-contact_friction", "0.2", "-contact_slip_velocity", "0.01", "-constraints", "low",
            "-constraint_low_where", "z == zmin", "-initial_velocity", "0.3*(z > 1), 0, -(z > 1)",
            "-time_end", "0.16", "-time_step", "0.02"])[-1]["steps"]
        self.assertEqual(steps[0]["contact_pairs"], 0)
        self.assertGreater(steps[-1]["contact_pairs"], 10)

    def test_an_obstacle_from_a_file(self):
        with open(self.path("cone.obj"), "w", encoding="utf-8") as file:
            file.write(CONE)
        scene = [*BOX, "-constraints", "low", "-constraint_low_where", "z == zmin",
                 "-obstacles", "cone,wall", "-obstacle_cone_file", "cone.obj",
                 "-obstacle_cone_friction", "0.3", "-obstacle_cone_move", "0.01, 0, -0.08",
                 "-obstacle_wall_plane", "0, 0, 1", "-obstacle_wall_at", "0, 0, -1",
                 "-output_csv", "forces.csv"]
        steps = self.solve(scene, ranks=2)["steps"]
        for step in steps:
            self.assert_balance(step["contact_forces"]["cone"], step["reaction"]["low"])
            self.assertEqual(step["contact_forces"]["wall"], [0, 0, 0])
        self.assertLess(step["contact_forces"]["cone"][2], 0)
        with open(self.path("forces.csv"), encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        for i, axis in enumerate("xyz"):
            self.assertEqual([float(row[f"cone_contact_force_{axis}"]) for row in rows],
                             [step["contact_forces"]["cone"][i] for step in steps])


class InTime(ContactTest):
    """A block falls by a hundredth of its size onto an incline of tan = 0.5 and stays, or slides."""

    def slide(self, mu):
        options = ["-mesh_generate", "box", "-mesh_resolution", "1", "-material_young", "1e7",
                   "-material_poisson", "0.3", "-material_density", "1e3",
                   "-load_gravity", "9.81*0.4472135955, 0, -9.81*0.894427191",
                   "-time_end", "0.5", "-time_step", "0.025", "-obstacles", "ramp",
                   "-obstacle_ramp_plane", "0, 0, 1", "-obstacle_ramp_at", "0, 0, -0.002",
                   "-obstacle_ramp_friction", str(mu), "-contact_friction_iterations", "3",
                   "-contact_slip_velocity", "1e-4", "-probe_corner", "0, 0, 0", "-probes", "corner"]
        steps = self.solve(options)["steps"]
        return [step["probes"]["corner"][0] for step in steps]

    def test_newmark_is_warned_of(self):
        for integrator, words in (("newmark", 1), ("bdf2", 0)):
            record = self.solve([*BOX, *FLOOR, "-material_density", "1e3", "-time_end", "0.02", "-time_step",
                                 "0.01", "-time_integrator", integrator, "-load_gravity", "0, 0, -9.81"])
            self.assertEqual(sum("newmark" in text for text in record["result"]["warnings"]), words)
            self.assertEqual(self.printed.count("WARNING: newmark"), words)

    def test_friction_above_the_slope_holds(self):
        x = self.slide(0.55)
        self.assertLess(abs(x[-1] - x[10]), 1e-3)

    def test_friction_below_the_slope_slides(self):
        x = self.slide(0.25)
        a = 9.81 * 0.894427191 * (0.5 - 0.25)
        # Second differences of the last steps are the acceleration.
        last = (x[-1] - 2 * x[-5] + x[-9]) / (4 * 0.025) ** 2
        self.assertAlmostEqual(last / a, 1, delta=0.02)


class OnASlope(ContactTest):
    """A stiff block settles on the level, which then becomes a slope of tan = 0.5: it holds by
    creeping at less than the slip velocity, or slides. PolyFEM's block with mu = 0.5 and this slip
    velocity has moved by 4.63e-4 after 2.5 s."""
    SLIP, STEP, SETTLED, STEPS = 1e-5, 0.025, 10, 100
    ALONG, DOWN = 9.81 / 5 ** 0.5, 9.81 * 2 / 5 ** 0.5

    def slide(self, mu, share="t > 0.2625"):
        """Places of a corner along the slope from the step on that makes it one."""
        result = run([
            "-mesh_generate", "box", "-mesh_resolution", "1", "-material_young", "1e9",
            "-material_poisson", "0.3", "-material_density", "1e3",
            "-load_gravity", f"{self.ALONG}*({share}), 0, -{self.DOWN}",
            "-time_end", str(self.STEP * (self.SETTLED + self.STEPS)),
            "-time_step", str(self.STEP), "-obstacles", "ramp", "-obstacle_ramp_plane", "0, 0, 1",
            "-obstacle_ramp_at", "0, 0, -0.002", "-obstacle_ramp_friction", str(mu),
            "-contact_slip_velocity", repr(self.SLIP / 3 ** 0.5),
            "-probe_corner", "0, 0, 0", "-probes", "corner", "-output_file", "run.xdmf",
            "-output_every", "10", "-snes_trefoil_record", "run.json"], folder=self.folder)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertGreater(self.states("run.xdmf"), 10)
        with open(self.path("run.json"), encoding="utf-8") as file:
            steps = json.load(file)["steps"]
        return [step["probes"]["corner"][0] for step in steps][self.SETTLED:]

    def test_a_little_less_friction_than_the_slope_slides_as_a_rigid_block(self):
        x = self.slide(0.49)
        a = self.ALONG - 0.49 * self.DOWN
        expected = a * self.STEP ** 2 * self.STEPS * (self.STEPS + 1) / 2  # backward Euler
        self.assertAlmostEqual((x[-1] - x[0]) / expected, 1, delta=1e-3)

    def test_a_little_more_creeps_as_the_mollifier_says(self):
        x = self.slide(0.505)
        self.assertAlmostEqual((x[-1] - x[-2]) / self.STEP / self.SLIP,
                               1 - (1 - 0.5 / 0.505) ** 0.5, delta=0.01)

    def test_as_much_creeps_below_the_slip_velocity_where_the_slope_comes_slowly(self):
        """At the limit nothing resists but a slip along the slope: whatever slips across it too, by a
        share s, takes s^2/2 of the force away, and what the block has gained it keeps. Slopes that
        come fast so end faster than the slip velocity: the bottom spreads at 4e-6 m/s and
        v = cbrt(g sin(theta) dt (4e-6 m/s)^2 / 2) = 1e-4 m/s."""
        x = self.slide(0.5, "(1 - cos(3.141592653589793*min(1, max(0, t - 0.2625))))/2")
        self.assertLess(abs(x[-1] - x[0]), 4e-5)
        last = [(b - a) / self.STEP for a, b in zip(x[-40:], x[-39:])]
        self.assertLess(max(last), self.SLIP)
        self.assertGreater(min(last), 0.97 * self.SLIP)

    def test_as_much_holds_on_a_slope_that_comes_fast(self):
        x = self.slide(0.5, "min(1, max(0, 2*t - 0.525))")
        self.assertLess(abs(x[-1] - x[0]), 4.63e-4)


class Refused(ContactTest):
    def test_what_starts_in_a_half_space(self):
        self.refused([*BOX, *TOP, *FLOOR[:4], "-obstacle_floor_at", "0, 0, 0.1"],
                     "16 pairs, the first: vertex (1) lies in obstacle 'floor' near (0, 0, 0)")

    def test_what_meets_at_rest(self):
        boxes_file(self.path("boxes.mesh"), -0.05)
        self.refused(["-mesh_file", "boxes.mesh", "-contact_self", "-constraints", "all",
                      "-constraint_all_where", "z == zmin || z == zmax"],
                     "the rest shape intersects", "edge (", "triangle (", "near (")
        self.refused([*BOX, *TOP, "-obstacles", "floor", "-obstacle_floor_plane", "0, 0, 1",
                      "-obstacle_floor_at", "0, 0, 0.5"], "lies in obstacle 'floor'")

    def test_what_touches_at_rest(self):
        boxes_file(self.path("boxes.mesh"), 1e-9)
        self.refused(["-mesh_file", "boxes.mesh", "-contact_self", "-constraints", "all",
                      "-constraint_all_where", "z == zmin || z == zmax"], "too near for contact")

    def obstacle(self, points, facets):
        with open(self.path("thing.obj"), "w", encoding="utf-8") as file:
            file.writelines("v %g %g %g\n" % point for point in points)
            file.writelines("f %d %d %d\n" % facet for facet in facets)
        return ["-obstacles", "thing", "-obstacle_thing_file", "thing.obj"]

    def test_an_obstacle_within_a_body(self):
        points = [(.4, .4, .4), (.6, .4, .4), (.5, .6, .4), (.5, .5, .6)]
        facets = [(1, 3, 2), (1, 2, 4), (2, 3, 4), (3, 1, 4)]
        self.refused([*BOX, *TOP, *self.obstacle(points, facets)],
                     "obstacle 'thing' lies within a body at the start")

    def test_an_obstacle_is_where_its_move_has_it_at_the_start(self):
        """Not where its file has it: neither of these is what its file says."""
        points = [(.4, .4, .4), (.6, .4, .4), (.5, .6, .4), (.5, .5, .6)]
        facets = [(1, 3, 2), (1, 2, 4), (2, 3, 4), (3, 1, 4)]
        within = [*BOX, *TOP, *self.obstacle(points, facets), "-obstacle_thing_move"]
        self.assertEqual(run([*within, "5 - t, 0, 0", "-check"], 2, self.folder).returncode, 0)
        away = [*BOX, *TOP, *self.obstacle([(x + 5, y, z) for x, y, z in points], facets)]
        self.refused([*away, "-obstacle_thing_move", "-5 + 0*t, 0, 0"],
                     "obstacle 'thing' lies within a body at the start")

    def test_in_time_a_move_is_where_it_says_from_the_start(self):
        """A plane far below that its move, though constant, has within the body."""
        timed = [*BOX, "-material_density", "1", "-time_end", "1", "-time_step", "0.5", "-obstacles", "floor",
                 "-obstacle_floor_plane", "0, 0, 1", "-obstacle_floor_at", "0, 0, -2"]
        self.refused([*timed, "-obstacle_floor_move", "0, 0, 2.5"], "floor")
        self.assertEqual(run([*timed, "-obstacle_floor_move", "0, 0, 1.5"], 1, self.folder).returncode, 0)

    def test_a_body_within_another(self):
        boxes = ["-bodies", "low,high", "-body_low_generate", "box", "-body_high_generate", "box",
                 "-body_high_scale", "0.3", "-contact_self", "-material_density", "1",
                 "-time_end", "1", "-time_step", "1", "-body_high_translate"]
        self.refused([*boxes, "0.32, 0.33, 0.34"], "a body lies within another one at rest")
        self.assertEqual(run([*boxes, "1.1, 0, 0", "-check"], 2).returncode, 0)

    def test_a_triangle_without_area(self):
        points = [(0, 0, -1), (2, 0, -1), (0, 2, -1), (1, 0, -1)]
        self.refused([*BOX, *TOP, *self.obstacle(points, [(1, 2, 3), (1, 2, 4)])],
                     "triangle 2 of 'thing.obj' has no area")

    def test_what_is_prescribed_into_an_obstacle(self):
        low = ["-constraints", "low", "-constraint_low_where", "z == zmin", "-constraint_low_move"]
        for ranks in (1, 2):
            result = run([*BOX, *FLOOR, *low, "0, 0, -t", "-material_density", "1e3", "-time_end",
                          "0.2", "-time_step", "0.1", "-time_step_min", "0.02"], ranks, self.folder)
            self.assertEqual(result.returncode, 1, result.stdout)
            self.assertIn("what is prescribed cannot move so far: vertex (1) and obstacle 'floor' "
                          "near (0, 0, -0.09", result.stdout)

    def test_an_obstacle_that_moves_into_what_is_held(self):
        """One sentence on any ranks, and the same status, whether or not anything was solved."""
        options = [*BOX, "-constraints", "low", "-constraint_low_where", "z == zmin",
                   "-obstacles", "floor", "-obstacle_floor_plane", "0, 0, 1",
                   "-obstacle_floor_at", "0, 0, -0.1", "-obstacle_floor_move"]
        in_time = ["-material_density", "1e3", "-time_end", "1", "-time_step", "0.1",
                   "-time_step_min", "0.02"]
        meets = "cannot move so far: vertex (1) and obstacle 'floor' near (0, 0, 0) would meet"
        for move, more, status in (("0, 0, 0.5*t", [], 1), ("0, 0, 0.5*t", in_time, 3),
                                   ("0, 0, 0.5*t", ["-load_steps", "1"], 1),
                                   ("0, 0, 0.5*t", ["-load_steps", "4"], 1),
                                   ("0, 0, 500*t", in_time, 1)):
            said = set()
            for ranks in (1, 2, 3):
                result = run([*options, move, *more], ranks, self.folder)
                self.assertEqual(result.returncode, status, result.stdout)
                said.update(line for line in result.stdout.splitlines()
                            if line.startswith(("NOT CONVERGED", "trefoil: ")) and meets in line)
            self.assertEqual(len(said), 1, (more, said))
            sentence = said.pop()
            self.assertEqual("nothing was solved" in sentence, status == 1, more)
            self.assertIn("neither can give way: both are prescribed", sentence)

    def test_what_is_prescribed_into_what_is_prescribed(self):
        """At once, with no step that is halved: where the two surfaces meet nothing can make room."""
        boxes_file(self.path("boxes.mesh"), 0.05)
        faces = ["-mesh_file", "boxes.mesh", "-mesh_refine", "1", "-contact_self", "-constraints",
                 "top,bottom", "-constraint_top_where", "abs(z - 1) < 0.01",
                 "-constraint_bottom_where", "abs(z - 1.05) < 0.01", "-constraint_bottom_move"]
        in_time = ["-material_density", "1e3", "-time_end", "1", "-time_step", "0.25"]
        for more in ([], in_time):
            result = run([*faces, "0, 0, -0.3*t", *more], 1, self.folder)
            self.assertEqual(result.returncode, 1, result.stdout)
            self.assertNotIn("halved", result.stdout)
            meeting = re.search(r"\) and .* near \((.*)\) would meet at t = (.*), and neither",
                                result.stdout)
            self.assertAlmostEqual(float(meeting[2]), 0.05 / 0.3, delta=2e-3)
            self.assertAlmostEqual(float(meeting[1].split(",")[2]), 1, delta=2e-3)

    def test_a_straight_way_that_is_not_free_where_the_true_one_is(self):
        """The block leaves the room under a cone sideways, and then rises."""
        with open(self.path("cone.obj"), "w", encoding="utf-8") as file:
            file.write(CONE)
        result = run([*BOX, *TOP, "-obstacles", "cone", "-obstacle_cone_file", "cone.obj",
                      "-load_steps", "auto", "-load_steps_first", "1", "-constraint_top_move",
                      "4*min(0.5, t), 0, 0.8*max(0, t - 0.5)"], folder=self.folder)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertIn("halved: the way from t = 0 is not free: after ", result.stdout)

    def test_a_way_that_is_not_free(self):
        """Of a vertex that is free nobody says that it is prescribed."""
        self.refused([*BOX, *TOP, *FLOOR, "-load_steps", "1", "-obstacle_floor_move", "0, 0, 0.9*t"],
                     "the way from t = 0 is not free: after 0.1",
                     "of it vertex (1) and obstacle 'floor' near (0, 0, 0) would come too near")

    def test_an_obstacle_of_the_plane_that_leaves_it(self):
        square = ["-mesh_generate", "square", "-constraints", "top", "-constraint_top_where",
                  "y == ymax", "-obstacles", "line", "-obstacle_line_file", "line.obj"]
        with open(self.path("line.obj"), "w", encoding="utf-8") as file:
            file.write("v -1 -0.05 0\nv 2 -0.05 0\nv 0.5 -0.04 0.25\nl 1 3 2\n")
        self.refused(square, "vertex 3 of 'line.obj' has z = 0.25;")

    def test_options(self):
        self.refused([*PRESSED, "-order", "2"], "linear elements")
        self.refused([*PRESSED, "-assembly", "hook"], "-assembly hook")
        self.refused([*BOX, *TOP, "-obstacles", "wall"], "obstacle 'wall' needs either")
        self.refused([*PRESSED, "-contact_distance", "2"], "-contact_distance is 2")
        self.refused([*PRESSED, "-contact_ccd", "2"], "-contact_ccd is 2")
        self.refused([*PRESSED, "-contact_friction", "-1"], "-contact_friction is -1")
        self.refused([*PRESSED, "-contact_friction", "0.3", "-contact_slip_velocity", "0"],
                     "-contact_slip_velocity is 0")
        self.refused([*PRESSED, "-contact_friction_iterations", "-2"],
                     "-contact_friction_iterations is -2")
        self.refused([*PRESSED, "-obstacle_floor_plane", "0, 0, 0"], "is no direction")
        self.refused([*PRESSED, "-obstacle_floor_plane", "0, 0, 1 + t"], "_plane is '0, 0, 1 + t'")
        self.refused([*PRESSED, "-obstacle_floor_at", "0, 0, -0.1 - x"], "moves by its `move`")
        self.refused([*PRESSED, "-obstacle_floor_move", "0, 0, 0.1*x"], "moves as a whole")
        self.refused([*BOX, *FLOOR], "let the body move rigidly")
        self.refused([*BOX, *TOP, "-obstacles", "ball", "-obstacle_ball_file", "none.obj"],
                     "cannot read 'none.obj'")
        self.refused([*PRESSED, "-contact_stiffness", "soft"], "-contact_stiffness is soft")
        self.refused([*PRESSED, "-contact_distanc", "1e-3"], "-contact_distance")
        self.refused([*BOX, *TOP, "-obstacles", "ball", "-obstacle_ball_file", "ball.ply"],
                     "give an .obj or an .stl")


if __name__ == "__main__":
    unittest.main()
