#!/usr/bin/python3
"""The balance of reactions and loads at the end of a run: warned of where a solve left it early."""
import math
import unittest

from trefoil_program import record_of

TURNED = ["-mesh_generate", "box", "-mesh_resolution", "4", "-constraints", "low,high",
          "-constraint_low_where", "z == zmin", "-constraint_high_where", "z == zmax",
          "-constraint_high_move", "0.2, 0, 0.4"]
LOADED = ["-mesh_generate", "box", "-mesh_resolution", "4", "-constraints", "low",
          "-constraint_low_where", "z == zmin", "-loads", "pull,weight", "-load_pull_where",
          "z == zmax", "-load_pull_traction", "1e4, 0, 0", "-load_weight_where", "x == xmin",
          "-load_weight_pressure", "2e4"]
RUBBER = ["-order", "2", "-material_model", "stable_neo_hookean", "-material_poisson", "0.49999"]
EARLY = ["-snes_trefoil_take_last", "false", "-snes_trefoil_energy_tolerance"]


class Balance(unittest.TestCase):
    def result(self, options, ranks=1):
        record = record_of(options, ranks)
        self.assertEqual(record["status"], 0, record["printed"])
        forces = [each["reaction"] for each in record["constraints"]]
        forces += [each["force"] for each in record["loads"]]
        left = math.hypot(*map(sum, zip(*forces)))
        largest = max(math.hypot(*force) for force in forces)
        return record, left, largest

    def test_is_what_reactions_and_loads_leave(self):
        for options, tolerance, cause in (
                (LOADED, "1e-2", "the solve has ended early"),
                (TURNED + RUBBER + ["-initial", "arap"], "1e-2",  # whose start is no better
                 "pressure of a nearly incompressible material")):
            for ranks in (1, 2):
                with self.subTest(options=options, ranks=ranks):
                    record, left, largest = self.result(options + EARLY + [tolerance], ranks)
                    result = record["result"]
                    self.assertGreater(left, 0.01 * largest)
                    self.assertAlmostEqual(result["force_imbalance"] * largest / left, 1)
                    self.assertIn(cause, result["balance_warning"])
                    self.assertIn(result["balance_warning"], result["warnings"])
                    self.assertIn("WARNING: " + result["balance_warning"], record["printed"])

    def test_is_there_by_default(self):
        """Also where there is one constraint, whose resultant is what is left."""
        both = ["-mesh_generate", "box", "-mesh_resolution", "4", "-constraints", "ends",
                "-constraint_ends_where", "z == zmin || z == zmax", "-constraint_ends_move",
                "-0.4*z*(y-0.5), 0.4*z*(x-0.5), 0.2*z"]
        for options in (TURNED, LOADED, TURNED + RUBBER, both, both + RUBBER):
            with self.subTest(options=options):
                record, _, _ = self.result(options)
                self.assertLess(record["result"]["force_imbalance"], 0.01)
                self.assertNotIn("balance", record["printed"])

    def test_is_none_of_nothing(self):
        record, _, _ = self.result(TURNED + ["-constraint_high_move", "0, 0, 0"])
        self.assertEqual(record["result"]["force_imbalance"], 0)


if __name__ == "__main__":
    unittest.main()
