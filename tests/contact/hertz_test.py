#!/usr/bin/python3
"""Hertz's contact on two coarse meshes: the force is near the closed form, and nears it. The finer
meshes of tests/benchmarks/README.md are within 1 %."""
import os
import sys
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "benchmarks"))
import hertz  # noqa: E402


class Hertz(unittest.TestCase):
    def test_the_force_converges_to_the_closed_form(self):
        coarse, fine = (hertz.measure(n) for n in (4, 8))  # 3 and 6 elements in a radius of contact
        errors = [abs(ratio - 1) for _, ratio, _ in (coarse, fine)]
        self.assertLess(errors[0], 0.07)
        self.assertLess(errors[1], 0.02)
        self.assertLess(errors[1], errors[0] / 2)
        self.assertGreater(fine[2]["result"]["contact_pairs"], 2 * coarse[2]["result"]["contact_pairs"])


if __name__ == "__main__":
    unittest.main()
