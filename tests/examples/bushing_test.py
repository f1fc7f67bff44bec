"""examples/bushing.yaml: its moment by formula, what it holds, and the curve that Python draws of it."""
import os
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.normpath(os.path.join(HERE, "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "examples", "python"))
os.chdir(ROOT)  # from where the examples are run

import numpy as np

import trefoil

SCENE = "examples/bushing.yaml"
SHEAR, LENGTH, INNER, OUTER = 3 / (2 * 1.49), 24, 8, 20


class Bushing(unittest.TestCase):
    def test_turned_a_little_it_has_the_moment_of_the_formula(self):
        angle = 1e-3
        result = trefoil.run(SCENE, 1, load_steps=1, constraint_bolt_move=(
            f"x*(cos({angle}) - 1) - y*sin({angle}), x*sin({angle}) + y*(cos({angle}) - 1), 0"))
        exact = 4 * np.pi * SHEAR * LENGTH / (1 / INNER**2 - 1 / OUTER**2) * angle
        moments = {each["name"]: each["moment"][2] for each in result.record["constraints"]}
        self.assertLess(abs(moments["bolt"] / exact - 1), 0.02)
        self.assertLess(abs(moments["ring"] / exact + 1), 0.02)

    def test_pushed_and_turned_the_ring_holds_what_the_bolt_does(self):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                result = trefoil.run(SCENE, ranks)
                ring, bolt = sorted(result.record["constraints"], key=lambda each: each["name"] == "bolt")
                for key in ("reaction", "moment"):
                    size = np.linalg.norm(bolt[key])
                    self.assertLess(np.linalg.norm(np.add(ring[key], bolt[key])), 1e-3 * size)
                self.assertEqual(result.record["result"]["inverted"], 0)
                self.assertEqual([step.t for step in result.steps], [0.25, 0.5, 0.75, 1.0])
                self.assertEqual(set(result.steps[0].cell_fields["region"]), {0, 1})

    def test_the_curve_from_python(self):
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(os.path.join(ROOT, "examples"), os.path.join(folder, "examples"))
            done = subprocess.run(
                ["/usr/bin/python3", "examples/python/load_displacement.py"], cwd=folder, text=True,
                env={**os.environ, "MPLBACKEND": "Agg"}, capture_output=True, check=False)
            self.assertEqual(done.stderr, "")
            self.assertGreater(os.path.getsize(os.path.join(folder, "load_displacement.png")), 10000)
        rows = [line.split() for line in done.stdout.splitlines() if line.endswith("N/mm")]
        stiffness = [float(row[4]) for row in rows]
        self.assertEqual(len(stiffness), 12)
        self.assertEqual(stiffness, sorted(stiffness))  # it stiffens


if __name__ == "__main__":
    unittest.main()
