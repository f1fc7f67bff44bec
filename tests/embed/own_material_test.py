#!/usr/bin/python3
"""A material of a user's, loaded by an option: examples/own_material, on 1 and 2 ranks."""
import os
import unittest

from hosts import HOSTS, ROOT, run

PROGRAM = [os.environ.get("TREFOIL", os.path.join(ROOT, "build", "trefoil"))]
LIBRARY = os.path.join(HOSTS, "libown_material.so")
LOAD = f"-dll_append {LIBRARY} -material_model mine"
# Pulled to 1.5 between plates on which it slides.
SCENE = ("-mesh_generate box -mesh_resolution 3 -constraints x,y,z,lid -constraint_x_where x==0 "
         "-constraint_x_move 0,free,free -constraint_y_where y==0 -constraint_y_move free,0,free "
         "-constraint_z_where z==0 -constraint_z_move free,free,0 -constraint_lid_where z==1 "
         "-constraint_lid_move free,free,0.5 -material_young 2.5 -material_poisson 0.25 "
         "-snes_trefoil_energy_tolerance 1e-13 -snes_trefoil_record record.json")


def psi(side, length):
    """The energy density for mu = lambda = 1, which E = 5/2 and nu = 1/4 are."""
    change, volume = 2 * side ** 2 + length ** 2 - 3, side ** 2 * length - 1
    return change / 2 + change ** 2 / 20 - volume + 1.6 / 2 * volume ** 2


class OwnMaterial(unittest.TestCase):
    def test_it_is_used(self):
        expected = min(psi(0.5 + 1e-6 * k, 1.5) for k in range(500000))
        for ranks in (1, 2):
            for assembly in ("split", "plain"):
                printed, status, record = run(PROGRAM, f"{SCENE} {LOAD} -assembly {assembly}", ranks)
                self.assertEqual(status, 0, printed)
                self.assertLess(abs(record["result"]["energy"] / expected - 1), 1e-9)

    def test_it_is_known_only_where_it_is_loaded(self):
        printed, status, _ = run(PROGRAM, f"{SCENE} -material_model mine")
        self.assertEqual(status, 1)
        self.assertIn("knows no 'mine'", printed)
        printed, status, _ = run(PROGRAM, f"{SCENE} -dll_append {LIBRARY} -material_model his")
        self.assertEqual(status, 1)
        self.assertIn(", mine", printed)

    def test_a_library_that_is_not_there_is_named(self):
        printed, status, _ = run(PROGRAM, f"{SCENE} -dll_append /nowhere/libmine.so")
        self.assertNotEqual(status, 0)
        self.assertIn("/nowhere/libmine.so", printed)


if __name__ == "__main__":
    unittest.main(verbosity=2)
