#!/usr/bin/python3
"""A block that falls and bounces: a scheme that makes energy of nothing is said to, others are not."""
import json
import os
import sys
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import contact_scene_test as scenes  # noqa: E402

FALL = ["-mesh_generate", "box", "-mesh_resolution", "2", "-material_young", "1e5",
        "-material_poisson", "0.3", "-material_density", "1e3", "-load_gravity", "0, 0, -9.81",
        "-time_end", "0.6", "-time_step", "0.02", *scenes.FLOOR, "-obstacle_floor_at",
        "0, 0, -0.2", "-snes_trefoil_record", "run.json"]
WARNING = "of its scale from nothing: -time_integrator bdf2 and backward_euler damp"


class EnergyRise(scenes.ContactTest):
    def fall(self, *options):
        """The verdict and the result of a run; its rise is that of the steps."""
        result = scenes.run([*FALL, *options], folder=self.folder)
        self.assertEqual(result.returncode, 0, result.stdout)
        with open(self.path("run.json"), encoding="utf-8") as file:
            record = json.load(file)
        totals, inner = [], []
        for step in record["steps"]:
            inner.append(step["strain_energy"] + step["kinetic_energy"] + step["contact_energy"])
            totals.append(inner[-1] - step["load_work"])
        rise = max(total - min(totals[:k + 1]) for k, total in enumerate(totals)) / max(inner)
        self.assertAlmostEqual(record["result"]["energy_rise"], rise, delta=1e-12)
        verdict = [line for line in result.stdout.splitlines() if line.startswith("converged in")]
        return verdict[-1], record["result"]

    def test_the_trapezoidal_rule_makes_energy(self):
        verdict, result = self.fall("-time_integrator", "newmark")
        self.assertIn(WARNING, verdict)
        self.assertTrue(result["energy_is_made"])
        self.assertGreater(result["energy_rise"], 0.05)
        self.assertIn("nothing drives the scene", result["warnings"][-1])

    def test_schemes_that_damp_do_not(self):
        for scheme in ("backward_euler", "bdf2"):
            verdict, result = self.fall("-time_integrator", scheme)
            self.assertNotIn("WARNING", verdict)
            self.assertNotIn("energy_is_made", result)
            self.assertLess(result["energy_rise"], 0.05)

    def test_what_is_driven_may_gain_energy(self):
        for driven in (["-obstacle_floor_move", "0, 0, 4*t"], ["-load_gravity", "0, 0, 60*t - 20"]):
            verdict, result = self.fall(*driven)
            self.assertGreater(result["energy_rise"], 0.05)
            self.assertNotIn("WARNING", verdict)


if __name__ == "__main__":
    unittest.main()
