#!/usr/bin/python3
"""Quadratic elements that keep their volume on the mean: every path and number of ranks, what they
cure, where they are the default, how few iterations they take, the stresses that are written, and what
is refused."""
import json
import os
import tempfile
import unittest

try:
    import meshio
except ImportError:
    meshio = None

from boxes import TIGHT, energy
from trefoil_program import record_of, run

MEAN = ["-order", "2", "-element_pressure", "constant"]
POINTWISE = ["-order", "2", "-element_pressure", "pointwise"]
SQUARE = ["-mesh_generate", "square", "-mesh_resolution", "4", "-constraints", "low,high",
          "-constraint_low_where", "y == ymin", "-constraint_high_where", "y == ymax",
          "-constraint_high_move", "0.2, 0.4"]
BOX = ["-mesh_generate", "box", "-mesh_resolution", "2", "-constraints", "low,high",
       "-constraint_low_where", "z == zmin", "-constraint_high_where", "z == zmax",
       "-constraint_high_move", "0.2, 0, 0.4"]


class EveryPath(unittest.TestCase):
    def test_ranks_and_assemblies(self):
        for scene in (SQUARE, BOX):
            for model in ("stable_neo_hookean", "neo_hookean"):
                options = scene + MEAN + TIGHT + ["-material_model", model, "-material_poisson",
                                                  "0.495"]
                expected = record_of(options)
                self.assertEqual(expected["status"], 0, expected["printed"])
                for more, ranks in ((["-assembly", "plain"], 1), (["-assembly", "hook"], 2),
                                    ([], 2), ([], 3)):
                    with self.subTest(scene=scene[1], model=model, options=more, ranks=ranks):
                        record = record_of(options + more, ranks)
                        self.assertEqual(record["status"], 0, record["printed"])
                        self.assertLess(abs(energy(record) / energy(expected) - 1), 1e-9)

    def test_energy_does_not_grow_with_poisson(self):
        """A block that is sheared at its volume: what grows with nu is locking."""
        def stored(poisson, *options):
            record = record_of(SQUARE + ["-constraint_high_move", "0.3, 0", "-material_model",
                                         "neo_hookean", "-material_young", str(2 * (1 + poisson)),
                                         "-material_poisson", str(poisson), *options])
            self.assertEqual(record["status"], 0, record["printed"])
            return record["result"]["strain_energy"]
        linear, pointwise, mean = (stored(0.4999, *options) / stored(0.45, *options)
                                   for options in ([], POINTWISE, MEAN))
        self.assertLess(mean, pointwise)
        self.assertLess(pointwise, linear)

    @unittest.skipIf(meshio is None, "python3-meshio is not installed")
    def test_stresses_have_the_pressure_of_the_element(self):
        """The virtual work of the reactions in a stretch along z is the integral of P_zz, the stress
        at one pressure an element, also where that is the default: at nu .4999 that of pointwise J
        differs."""
        fields = ["first_piola", "cauchy_stress", "von_mises", "principal_stresses"]
        written = {}
        for pressure in ("auto", "constant"):
            with self.subTest(pressure=pressure), tempfile.TemporaryDirectory() as folder:
                finished = run(BOX + [
                    "-order", "2", "-element_pressure", pressure, "-snes_trefoil_energy_tolerance",
                    "1e-18", "-material_model", "neo_hookean", "-material_poisson", "0.4999",
                    "-output_file", "out.xdmf", "-output_fields", ",".join(fields),
                    "-snes_trefoil_record", "record.json"], folder=folder)
                self.assertEqual(finished.returncode, 0, finished.stdout)
                with open(os.path.join(folder, "record.json"), encoding="utf-8") as file:
                    reactions = json.load(file)["constraints"]
                cells = meshio.read(os.path.join(folder, "out.xdmf")).cell_data
                written[pressure] = cells
                # All cells of a regular mesh of straight cells have the same volume.
                pulled = [each["reaction"][2] for each in reactions if each["name"] == "high"]
                work = cells["first_piola"][0].reshape(-1, 9)[:, 8].mean()
                self.assertLess(abs(work / pulled[0] - 1), 1e-7)
        for field in fields:
            by_default, forced = (written[pressure][field][0] for pressure in ("auto", "constant"))
            self.assertLess(abs(by_default - forced).max(), 1e-9 * abs(forced).max(), field)


class Converged(unittest.TestCase):
    """A pressure whose error the energy hardly feels is right all the same."""

    @unittest.skipIf(meshio is None, "python3-meshio is not installed")
    def test_stretch_of_the_closed_form(self):
        """Uniaxial, to 1.5 its length: of an incompressible body sigma = mu (1.5^2 - 1/1.5)."""
        faces = {"low": "x == xmin", "high": "x == xmax", "side": "y == ymin", "floor": "z == zmin"}
        moves = {"low": "0, free, free", "high": "(xmax-xmin)/2, free, free",
                 "side": "free, 0, free", "floor": "free, free, 0"}
        options = ["-mesh_generate", "box", "-mesh_resolution", "2", "-order", "2",
                   "-material_model", "neo_hookean", "-material_young", "3", "-material_poisson",
                   "0.4999999", "-constraints", ",".join(faces), "-output_file", "out.xdmf",
                   "-output_fields", "cauchy_stress"]
        for name, where in faces.items():
            options += [f"-constraint_{name}_where", where, f"-constraint_{name}_move", moves[name]]
        with tempfile.TemporaryDirectory() as folder:
            finished = run(options, folder=folder)
            self.assertEqual(finished.returncode, 0, finished.stdout)
            cells = meshio.read(os.path.join(folder, "out.xdmf")).cell_data["cauchy_stress"][0]
        stress = 1.5 ** 2 - 1 / 1.5
        cells[:, 0] -= stress  # xx, of six components
        self.assertLess(abs(cells).max(), 1e-4 * stress)


class Default(unittest.TestCase):
    def test_above_a_poisson_ratio_where_it_can_be(self):
        half = ["-regions", "half", "-region_half_where", "z < 0.5"]
        for options, expected in (
                (["-order", "2", "-material_poisson", "0.46"], "constant"),
                (["-order", "2", "-material_poisson", "0.45"], "pointwise"),
                (["-order", "1", "-material_poisson", "0.46"], "pointwise"),
                ([*POINTWISE, "-material_poisson", "0.49"], "pointwise"),
                (["-order", "2", "-material_poisson", "0.3", *half, "-region_half_material_poisson",
                  "0.49"], "constant"),
                (["-order", "2", "-material_poisson", "0.49", *half, "-region_half_material_model",
                  "corotated"], "pointwise"),
                (["-order", "2", "-material_poisson", "0.49", "-snes_trefoil_space",
                  "deformation"], "pointwise")):
            with self.subTest(options=options):
                record = record_of(BOX + ["-material_model", "neo_hookean", *options])
                self.assertEqual(record["status"], 0, record["printed"])
                self.assertEqual(record["mesh"]["element_pressure"], expected)
                self.assertEqual("a constant pressure each" in record["printed"],
                                 expected == "constant")

    def test_only_what_cells_are_made_of_counts(self):
        """Hard parts of another material, and a body's material that its regions leave nothing of."""
        parts = ["-order", "2", "-material_model", "neo_hookean", "-regions", "part",
                 "-region_part_where"]
        for options, expected in (
                (["z < 0.3", "-material_poisson", "0.49", "-region_part_material_model",
                  "st_venant_kirchhoff", "-region_part_material_poisson", "0.3"], "constant"),
                (["z < 2", "-material_poisson", "0.4999", "-region_part_material_poisson", "0.3"],
                 "pointwise")):
            with self.subTest(options=options):
                energies = []
                for more, ranks in (([], 1), (["-assembly", "plain"], 1), ([], 2)):
                    record = record_of(BOX + TIGHT + parts + options + more, ranks)
                    self.assertEqual(record["status"], 0, record["printed"])
                    self.assertEqual(record["mesh"]["element_pressure"], expected)
                    self.assertEqual(record["result"]["warnings"], [])
                    self.assertNotIn("softer body", record["printed"])
                    energies.append(energy(record))
                for other in energies[1:]:
                    self.assertLess(abs(other / energies[0] - 1), 1e-9)

    def test_advice_fits_contact(self):
        """Which quadratic elements have not."""
        for more, words in (([], "-order 2 does not lock"),
                            (["-contact_self"], "contact is for linear elements alone")):
            printed = record_of(BOX + ["-material_poisson", "0.49", *more])["printed"]
            self.assertIn("linear elements lock", printed)
            self.assertIn(words, printed)
            self.assertEqual("-order 2" in printed, not more)

    def test_what_is_worse_is_said(self):
        nearly = BOX + ["-order", "2", "-material_poisson", "0.49"]
        for options, words in (
                (["-material_model", "corotated"], "WARNING: quadratic elements lock a little"),
                (["-snes_trefoil_space", "deformation"], "WARNING: quadratic elements lock a little"),
                (["-element_pressure", "pointwise"], "volume at the points, as -element_pressure"),
                (["-element_pressure", "constant"], "pressure each, as -element_pressure says")):
            with self.subTest(options=options):
                record = record_of(nearly + ["-material_model", "neo_hookean"] + options)
                self.assertEqual(record["status"], 0, record["printed"])
                self.assertIn(words, record["printed"])

    def test_forced_is_what_was_chosen(self):
        options = BOX + TIGHT + ["-order", "2", "-material_poisson", "0.495"]
        chosen, forced, pointwise = (
            energy(record_of(options + more))
            for more in ([], ["-element_pressure", "constant"], ["-element_pressure", "pointwise"]))
        self.assertLess(abs(chosen / forced - 1), 1e-12)
        self.assertGreater(abs(chosen / pointwise - 1), 1e-4)

    def test_steps_of_the_start_that_it_has(self):
        """Fitted rotations with a pressure of the elements', the harmonic start without."""
        options = BOX + ["-order", "2", "-material_poisson", "0.49", "-initial_steps"]
        few, more = (record_of(options + [steps]) for steps in ("3", "6"))
        for record in few, more:
            self.assertEqual(record["status"], 0, record["printed"])
        self.assertEqual(more["result"]["guess_linear_solves"] -
                         few["result"]["guess_linear_solves"], 3 * (6 - 3))
        for ranks in (1, 2):
            finished = run(options + ["3", "-element_pressure", "pointwise"], ranks)
            self.assertEqual(finished.returncode, 1)
            self.assertIn("-initial_steps is for -initial arap; the start is 'harmonic'",
                          finished.stdout)


class SoftStart(unittest.TestCase):
    """The cube of tests/accuracy/incompressible.py."""
    TURNED = ["-mesh_generate", "box", "-mesh_resolution", "6", "-order", "2", "-material_model",
              "neo_hookean", "-material_young", "1", *BOX[4:-2], "-constraint_high_move",
              "-(x-0.5)/2-(y-0.5)*sqrt(3)/2, (x-0.5)*sqrt(3)/2-(y-0.5)/2, 0.5"]

    def record(self, poisson, *options, ranks=1):
        record = record_of([*self.TURNED, "-material_poisson", str(poisson), *options], ranks)
        self.assertEqual(record["status"], 0, record["printed"])
        return record

    def test_few_iterations_to_the_same_minimum(self):
        directly = self.record(0.4999, "-initial", "arap", *TIGHT)
        self.assertNotIn("softer body", directly["printed"])
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                record = self.record(0.4999, *TIGHT, ranks=ranks)
                result = record["result"]
                self.assertIn("softer body", record["printed"])
                self.assertEqual(record["printed"].count("linear solver:"), 1)
                self.assertEqual(sum(result["load_step_iterations"]), result["iterations"])
                first = next(e for e in record["history"] if e["load_step"] == 1)
                self.assertAlmostEqual(result["energy_start"], first["energy"])
                self.assertLess(result["iterations"], 0.6 * directly["result"]["iterations"])
                self.assertLess(abs(energy(record) / energy(directly) - 1), 1e-9)

    def test_failure_is_said(self):
        record = record_of([*self.TURNED, "-material_poisson", "0.4999", "-mesh_resolution", "3",
                            "-snes_max_it", "1"])
        self.assertEqual(record["status"], 3)
        self.assertIn("the softer body has found no equilibrium; without it", record["printed"])

    def test_iterations_do_not_grow_with_poisson(self):
        """7 each; they were 7, 8 and 10 before the pressures were unknowns of a start of their own."""
        for poisson in (0.499, 0.4999, 0.49999):
            record = self.record(poisson)
            self.assertIn("pressures as unknowns", record["printed"])
            self.assertLessEqual(record["result"]["iterations"], 7)

    def test_a_ball_turned_by_small_caps(self):
        """13 iterations, and the same minimum as without; it was 35."""
        ball = ["-mesh_generate", "ball", "-order", "2", "-material_model", "neo_hookean",
                "-material_young", "1", "-material_poisson", "0.4999", "-constraints", "low,high",
                "-constraint_low_where", "z < -0.495", "-constraint_high_where", "z > 0.495",
                "-constraint_high_move", "-(x)/2-y*sqrt(3)/2, x*sqrt(3)/2-y/2, 0.3"]
        record = record_of(ball)
        self.assertEqual(record["status"], 0, record["printed"])
        self.assertLessEqual(record["result"]["iterations"], 16)
        self.assertLess(abs(record["result"]["strain_energy"] / 0.0030902674 - 1), 1e-6)

    def test_only_where_it_pays(self):
        for poisson, options in ((0.49, []), (0.4999, ["-element_pressure", "pointwise"])):
            self.assertNotIn("softer body", self.record(poisson, *options)["printed"])


class Refused(unittest.TestCase):
    def test_in_a_sentence(self):
        for options, words in (
                (["-order", "1", "-element_pressure", "constant"], "add -order 2"),
                (MEAN + ["-snes_trefoil_space", "deformation"], "-snes_trefoil_space element"),
                (MEAN + ["-material_model", "corotated"], "corotated has none"),
                (["-order", "2", "-element_pressure", "mean"], "auto, pointwise, constant")):
            for ranks in (1, 2):
                with self.subTest(options=options, ranks=ranks):
                    finished = run(BOX + options, ranks)
                    self.assertEqual(finished.returncode, 1, finished.stdout)
                    self.assertIn(words, finished.stdout)


if __name__ == "__main__":
    unittest.main()
