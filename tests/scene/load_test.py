#!/usr/bin/python3
"""Gravity, tractions and load steps in whole scenes: closed forms, every assembly path and number of
ranks."""
import unittest

from boxes import BOX, ENDS, SPRING, THREE_PLANES, TIGHT, energy
from trefoil_program import record_of


class Loads(unittest.TestCase):
    young = 1e6

    def scene(self, *options):
        return THREE_PLANES + TIGHT + SPRING + ["-material_young", str(self.young), *options]

    def test_traction_on_a_spring(self):
        """P = young (s - 1): the energy is -traction^2 / (2 young), for a face of area 1."""
        traction = 2e5
        for ranks in (1, 2, 3):
            record = record_of(self.scene("-loads", "top", "-load_top_where", "z == zmax",
                                          "-load_top_traction", f"0, 0, {traction}"), ranks)
            stored = traction ** 2 / (2 * self.young)
            self.assertEqual(record["status"], 0)
            self.assertLess(abs(energy(record) / -stored - 1), 1e-10)
            # The scale is what is stored and the work, which is twice as much.
            self.assertLess(abs(record["result"]["energy_scale"] / (3 * stored) - 1), 1e-10)

    def test_gravity_on_a_column(self):
        """Nodes of a linear column are exact: u = rho g / young (z - z^2 / 2), of each cell the
        energy is that of its mean strain. Mesh of layers of height h: -(rho g)^2/(6 young) (1 - h^2/4)."""
        pull, height = 9.81 * 1e3, 0.25
        for ranks in (1, 2):
            record = record_of(self.scene("-material_density", "1e3", "-load_gravity",
                                          "0, 0, 9.81"), ranks)
            expected = -pull ** 2 / (6 * self.young) * (1 - height ** 2 / 4)
            self.assertEqual(record["status"], 0)
            # Tetrahedra of a cube do not share its weight evenly between its corners.
            self.assertLess(abs(energy(record) / expected - 1), 0.02)
            scale = record["result"]["energy_scale"]
            self.assertLess(abs(scale / (-3 * energy(record)) - 1), 0.02)

    def test_every_element(self):
        """The same spring and column of triangles and quadratic elements, which know the column's
        parabola: -(rho g)^2/(6 young)."""
        for order in ("1", "2"):
            plane = ["-mesh_generate", "square", "-mesh_resolution", "4", "-order", order,
                     "-constraints", "floor,wall", "-constraint_floor_where", "y == ymin",
                     "-constraint_floor_move", "free, 0", "-constraint_wall_where", "x == xmin",
                     "-constraint_wall_move", "0, free", *TIGHT, *SPRING, "-material_young",
                     str(self.young)]
            for scene, zeros, top in ((plane, "0", "y == ymax"),
                                      (self.scene("-order", order), "0, 0", "z == zmax")):
                with self.subTest(order=order, dimension=zeros.count("0") + 1):
                    pulled = record_of(scene + ["-loads", "top", "-load_top_where", top,
                                                "-load_top_traction", zeros + ", 2e5"], 2)
                    self.assertLess(abs(energy(pulled) / (-2e5 ** 2 / (2 * self.young)) - 1), 1e-10)
                    if order == "1":
                        continue
                    column = record_of(scene + ["-material_density", "1e3", "-load_gravity",
                                                zeros + ", 9.81"], 2)
                    expected = -9810 ** 2 / (6 * self.young)
                    self.assertLess(abs(energy(column) / expected - 1), 1e-9)

    def test_each_region_has_its_mass(self):
        heavy = ["-regions", "low", "-region_low_where", "z < 0.5"]
        pull = ["-load_gravity", "0, 0, 9.81"]
        both = record_of(self.scene(*heavy, *pull, "-material_density", "1e3"))
        same = record_of(self.scene(*pull, "-material_density", "1e3"))
        light = record_of(self.scene(*heavy, *pull, "-material_density", "1e3",
                                     "-region_low_material_density", "0"))
        self.assertLess(abs(energy(both) / energy(same) - 1), 1e-12)
        self.assertLess(abs(energy(light)), 0.95 * abs(energy(same)))

    def test_inner_facets_carry_no_load(self):
        """Where every vertex is chosen, every facet of every cell is asked for; the surface is 6.
        All but one corner is lifted by 0.1, and that one follows: the work is that of the load."""
        for ranks in (1, 2, 3):
            lifted = record_of([*BOX, "-constraints", "most", "-constraint_most_where",
                                "x < 0.9 || y < 0.9 || z < 0.9", "-constraint_most_move",
                                "0, 0, 0.1", "-loads", "all", "-load_all_where", "1",
                                "-load_all_traction", "0, 0, 1e3", "-material_young", "1e12",
                                "-material_model", "arap"], ranks)
            self.assertLess(abs(energy(lifted) / -600 - 1), 1e-6)

    def test_loads_on_every_path(self):
        scene = [*BOX, "-constraints", "low", "-constraint_low_where", "z == zmin", *TIGHT,
            "-loads", "side,top", "-load_side_where", "x == xmax",
            "-load_side_traction", "1e5*z, 2e4, 0", "-load_top_where", "z == zmax",
            "-load_top_traction", "0, 0, -1e5", "-load_gravity", "0, 5*x, 0",
            "-material_density", "5e3"]
        serial = record_of(scene)
        self.assertEqual(serial["status"], 0)
        for options, ranks in ((["-assembly", "plain"], 1), (["-assembly", "hook"], 2), ([], 3)):
            other = record_of(scene + options, ranks)
            self.assertEqual(other["result"]["iterations"], serial["result"]["iterations"])
            for key in ("energy", "energy_scale"):
                self.assertLess(abs(other["result"][key] / serial["result"][key] - 1), 1e-8)


class LoadSteps(unittest.TestCase):
    def check_path(self, scene, steps, ranks=1):
        """The same end as at once, and one history of the whole way."""
        at_once, path = record_of(scene, ranks), record_of(
            scene + ["-load_steps", str(steps)], ranks)
        self.assertEqual((at_once["status"], path["status"]), (0, 0))
        self.assertLess(abs(energy(path) / energy(at_once) - 1), 1e-9)
        history = path["history"]
        self.assertEqual([entry["k"] for entry in history], list(range(len(history))))
        self.assertEqual(sorted({entry["load_step"] for entry in history}),
                         list(range(1, steps + 1)))
        self.assertEqual(path["result"]["iterations"], len(history))
        self.assertEqual(path["result"]["line_search_trials"],
                         sum(entry["trials"] for entry in history))
        self.assertEqual(sum(path["result"]["load_step_iterations"]), len(history))
        solves = [entry["linear_solves"] for entry in history]
        self.assertEqual(solves, sorted(solves))
        self.assertLessEqual(solves[-1], path["result"]["linear_solves"])
        # No error of the last step is small before that one begins.
        before = sum(path["result"]["load_step_iterations"][:-1])
        table = path["result"]["error_table"]
        self.assertGreater(len(table), 4)
        self.assertGreater(table[0]["iterations"], before)
        self.assertGreater(table[-1]["linear_solves"], solves[before - 1])
        seconds = [entry["seconds"] for entry in history]
        self.assertEqual(seconds, sorted(seconds))
        self.assertLessEqual(seconds[-1], path["time"]["total"])
        self.assertEqual(path["result"]["energy_start"], history[0]["energy"])
        # Halfway there, and of each step's equilibria the next one is the start.
        middle = [entry for entry in history if entry["load_step"] == 1][-1]
        self.assertLess(abs(middle["energy"]), 0.9 * abs(energy(path)))

    def test_displacements(self):
        scene = ENDS + TIGHT + ["-constraint_high_move", "0.2*t, 0, -0.5*t", "-material_model",
                                "neo_hookean", "-material_poisson", "0.3"]
        self.check_path(scene, 3)
        self.check_path(scene, 2, ranks=2)

    def test_loads(self):
        self.check_path(THREE_PLANES + TIGHT + [
            "-loads", "top", "-load_top_where", "z == zmax", "-load_top_traction", "0, 0, -3e5*t",
            "-load_gravity", "2*t, 0, 0", "-material_density", "1e3", "-material_model", "arap"], 2)

    def test_what_has_no_time_grows_in_proportion(self):
        """The same way, step by step, as with a factor of t in every formula."""
        for scene, factor in (
                (["-constraint_high_move", "0.2{0}, 0, -0.5*z{0}", "-material_model", "arap"], "*t"),
                (["-load_gravity", "2{0}, 0, 0", "-material_density", "1e3",
                  "-loads", "top", "-load_top_where", "z == zmax", "-load_top_traction",
                  "0, 0, -3e5{0}", "-material_model", "arap"], "*t")):
            ways = [record_of([*ENDS, *TIGHT, "-load_steps", "3",
                               *(word.format(each) for word in scene)]) for each in (factor, "")]
            self.assertEqual(*(way["result"]["load_step_iterations"] for way in ways))
            for one, other in zip(*(way["history"] for way in ways)):
                self.assertEqual(one["load_step"], other["load_step"])
                self.assertLessEqual(abs(one["energy"] - other["energy"]),
                                     1e-9 * abs(energy(ways[0])))

    def test_a_rigid_move_turns(self):
        """Half a turn in 4 steps: 45 degrees after the first, as a formula in t has it, and not a
        body that is crushed on the straight way."""
        angle = "pi*t"
        turned = f"0.3*t, (y-0.5)*cos({angle})-(z-0.5)*sin({angle})+0.5-y, " \
                 f"(y-0.5)*sin({angle})+(z-0.5)*cos({angle})+0.5-z"
        at_once = "0.3, 1-2*y, 1-2*z"
        scene = ["-mesh_generate", "box", "-mesh_resolution", "4", "-constraints", "low,high",
                 "-constraint_low_where", "x == xmin", "-constraint_high_where", "x == xmax",
                 "-load_steps", "4", *TIGHT]
        for ranks in (1, 2):
            written, rigid = (record_of([*scene, "-constraint_high_move", move], ranks)
                              for move in (turned, at_once))
            self.assertEqual((written["status"], rigid["status"]), (0, 0))
            self.assertEqual(written["result"]["load_step_iterations"],
                             rigid["result"]["load_step_iterations"])
            self.assertLess(abs(energy(written) / energy(rigid) - 1), 1e-9)
            for one, other in zip(written["history"], rigid["history"]):
                self.assertLess(abs(one["energy"] / other["energy"] - 1), 1e-7)

    def test_a_step_that_does_not_converge_ends_the_way(self):
        record = record_of(ENDS + ["-constraint_high_move", "0.2*t, 0, -0.5*t", "-load_steps", "3",
                                   "-snes_max_it", "1"])
        self.assertEqual(record["status"], 3)
        self.assertFalse(record["result"]["converged"])
        self.assertTrue(all(entry.get("load_step", 1) == 1 for entry in record["history"]))


if __name__ == "__main__":
    unittest.main(verbosity=2)
