"""examples/bracket.yaml against CalculiX 2.20 on the same mesh."""
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.normpath(os.path.join(HERE, "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "examples", "python"))
os.chdir(ROOT)  # from where the examples are run

import numpy as np

import trefoil

SCENE = "examples/bracket.yaml"
# Printed by examples/bracket/calculix.py, with seven digits.
TIP = np.array([3.319379e-06, 5.600025e-07, -2.549183e-05])
CORNER = (80, 25, 70)


def at_the_tip(result):
    nearest = np.linalg.norm(result.points - CORNER, axis=1).argmin()
    return result.fields["displacement"][nearest]


class Bracket(unittest.TestCase):
    def test_tip_is_where_calculix_has_it(self):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                tip = at_the_tip(trefoil.run(SCENE, ranks))
                self.assertLess(np.abs(tip - TIP).max(), 1e-5 * np.linalg.norm(TIP))

    def test_figures_are_those_that_calculix_prints(self):
        if not shutil.which("ccx") or not importlib.util.find_spec("meshio"):
            self.skipTest("needs calculix-ccx and python3-meshio")
        done = subprocess.run(["/usr/bin/python3", "examples/bracket/calculix.py", "gravity"],
                              capture_output=True, text=True, check=True)
        printed = [float(word) for word in re.findall(r"-?\d\.\d+E[+-]\d+", done.stdout)]
        time, tip = printed[0], printed[1:4]
        self.assertEqual(time, 1)
        np.testing.assert_allclose(tip, TIP, rtol=1e-6)


if __name__ == "__main__":
    unittest.main()
