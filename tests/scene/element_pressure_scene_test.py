#!/usr/bin/python3
"""Quadratic elements that keep their volume on the mean: every path and number of ranks, what they
cure, the stresses that are written, and what is refused."""
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
                                   for options in ([], ["-order", "2"], MEAN))
        self.assertLess(mean, pointwise)
        self.assertLess(pointwise, linear)

    @unittest.skipIf(meshio is None, "python3-meshio is not installed")
    def test_stresses_have_the_pressure_of_the_element(self):
        """The virtual work of the reactions in a stretch along z is the integral of P_zz, the stress
        at one pressure an element: that of pointwise J differs at nu .4999."""
        with tempfile.TemporaryDirectory() as folder:
            finished = run(BOX + MEAN + TIGHT + [
                "-material_model", "neo_hookean", "-material_poisson", "0.4999", "-output_file",
                "out.xdmf", "-output_fields", "first_piola", "-snes_trefoil_record", "record.json"],
                folder=folder)
            self.assertEqual(finished.returncode, 0, finished.stdout)
            with open(os.path.join(folder, "record.json"), encoding="utf-8") as file:
                reactions = json.load(file)["constraints"]
            cells = meshio.read(os.path.join(folder, "out.xdmf")).cell_data["first_piola"][0]
        # All cells of a regular mesh of straight cells have the same volume.
        pulled = [each["reaction"][2] for each in reactions if each["name"] == "high"]
        self.assertLess(abs(cells.reshape(-1, 9)[:, 8].mean() / pulled[0] - 1), 1e-7)


class Refused(unittest.TestCase):
    def test_in_a_sentence(self):
        for options, words in (
                (["-order", "1", "-element_pressure", "constant"], "add -order 2"),
                (MEAN + ["-snes_trefoil_space", "deformation"], "-snes_trefoil_space element"),
                (MEAN + ["-material_model", "corotated"], "corotated has none"),
                (["-order", "2", "-element_pressure", "mean"], "pointwise, constant")):
            for ranks in (1, 2):
                with self.subTest(options=options, ranks=ranks):
                    finished = run(BOX + options, ranks)
                    self.assertEqual(finished.returncode, 1, finished.stdout)
                    self.assertIn(words, finished.stdout)


if __name__ == "__main__":
    unittest.main()
