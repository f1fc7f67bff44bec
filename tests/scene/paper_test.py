#!/usr/bin/python3
"""The scripts of the paper's figures: poses, what counts of a path, and a small histogram."""
import os
import subprocess
import sys
import tempfile
import unittest

from trefoil_program import PROGRAM, ROOT

FOLDER = os.path.join(ROOT, "examples", "paper")
sys.path.insert(0, FOLDER)
import poses  # noqa: E402  (of the folder above)


def state(k, energy, load_step, **more):
    return {"k": k, "energy": energy, "load_step": load_step, **more}


class IterationsTo(unittest.TestCase):
    RESULT = {"energy_scale": 1, "energy": 2, "iterations": 9}

    def test_counts_a_path_whose_states_before_the_end_are_no_ends(self):
        record = {"result": self.RESULT,
                  "history": [state(0, 0.1, 1), state(1, 0.2, 2), state(2, 7, 3), state(3, 2, 3)]}
        self.assertEqual(poses.iterations_to(record, 2.5), 3)

    def test_passes_over_what_was_rejected(self):
        record = {"result": self.RESULT,
                  "history": [state(0, 0.1, 1, rejected=True), state(1, 5, 1), state(2, 2, 1)]}
        self.assertEqual(poses.iterations_to(record, 2.5), 2)

    def test_is_none_where_it_is_not_reached(self):
        self.assertIsNone(poses.iterations_to({"result": self.RESULT,
                                               "history": [state(0, 3, 1)]}, 1))


class Rotation(unittest.TestCase):
    def test_turns(self):
        """A point at (3, 2), about (1, 1)."""
        move = poses.rotation(("x", "1"), ("y", "1"), 90)
        values = {name: eval(formula, {}, {"x": 3, "y": 2})  # of our own making
                  for name, formula in move.items()}
        self.assertAlmostEqual(3 + values["x"], 0)
        self.assertAlmostEqual(2 + values["y"], 3)

    def test_half_a_turn_is_exact(self):
        self.assertNotIn("e-", " ".join(poses.rotation(("x", "0"), ("y", "0"), 180).values()))


class Histogram(unittest.TestCase):
    def test_of_a_box(self):
        with tempfile.TemporaryDirectory() as folder:
            script = os.path.join(FOLDER, "histograms.py")
            result = subprocess.run([sys.executable, script, "--quarter", "box", "--program",
                                     PROGRAM, "-o", folder], stdout=subprocess.PIPE,
                                    stderr=subprocess.STDOUT, text=True, check=False)
            self.assertEqual(result.returncode, 0, result.stdout)
            for name in ("figure13.png", "figure14.png", "table.md"):
                self.assertGreater(os.path.getsize(os.path.join(folder, name)), 100)


if __name__ == "__main__":
    unittest.main()
