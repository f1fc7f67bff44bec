#!/usr/bin/python3
"""TREFOIL_SIMD holds kernels and filter to one instruction set; an unknown name is an error."""
import os
import unittest

import trefoil_program

BOX = ("-mesh_generate box -mesh_resolution 3 -constraints h,l -constraint_h_where x==xmin "
       "-constraint_h_move 0,0,0 -constraint_l_where x==xmax -constraint_l_move 0.5,0,0")


def with_variable(value, function, *arguments):
    os.environ["TREFOIL_SIMD"] = value
    try:
        return function(*arguments)
    finally:
        del os.environ["TREFOIL_SIMD"]


class InstructionSets(unittest.TestCase):
    def test_an_unknown_name_is_an_error(self):
        for ranks in (1, 2):
            for name in ("AVX2", "sse9"):
                result = with_variable(name, trefoil_program.run, BOX, ranks)
                self.assertEqual(result.returncode, 1, result.stdout)
                self.assertEqual(result.stdout.count("TREFOIL_SIMD"), 1, result.stdout)
                self.assertIn(f"TREFOIL_SIMD is '{name}'", result.stdout)
                self.assertIn("it may be ", result.stdout)

    def test_all_find_the_same_equilibrium(self):
        best = trefoil_program.record_of(BOX)
        baseline = with_variable("baseline", trefoil_program.record_of, BOX)
        for record in (best, baseline):
            self.assertEqual(record["status"], 0)
        self.assertEqual(best["result"]["iterations"], baseline["result"]["iterations"])
        self.assertLess(abs(best["result"]["energy"] / baseline["result"]["energy"] - 1), 1e-12)


if __name__ == "__main__":
    unittest.main(verbosity=2)
