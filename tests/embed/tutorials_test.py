#!/usr/bin/python3
"""PETSc's own tutorials, compiled unchanged: one that converges, and two things that are refused.
Skipped without Debian's libpetsc3.18-dev-examples."""
import os
import subprocess
import sys
import tempfile
import unittest

from hosts import DIRECT, TREFOIL, run, sentence

TUTORIALS = "/usr/share/petsc/3.18/share/petsc/examples/src/snes/tutorials"
ARCH = "-da_refine 1 -rad 100 -young 10 -poisson 0.2 -loading -1 -sl 0 -snes_converged_reason"
MIXED = ("-run_type full -dm_plex_dim 3 -dm_plex_simplex 0 -dm_plex_box_faces 2,2,2 "
         "-def_petscspace_degree 2 -pres_petscspace_degree 1 -elastMat_petscspace_degree 0 "
         "-wall_pres_petscspace_degree 0 -bc_fixed 1 -bc_pressure 2 -wall_pressure 0.4 "
         "-snes_converged_reason -ksp_type fgmres -ksp_rtol 1e-10 -pc_type fieldsplit "
         "-pc_fieldsplit_type schur -pc_fieldsplit_schur_factorization_type upper "
         "-fieldsplit_deformation_ksp_type preonly -fieldsplit_deformation_pc_type lu "
         "-fieldsplit_deformation_pc_factor_mat_solver_type mumps "
         "-fieldsplit_pressure_ksp_rtol 1e-10 -fieldsplit_pressure_pc_type jacobi")


def flags(*words):
    """PETSc's compiler and linker words, by pkg-config."""
    return subprocess.check_output(["pkg-config", *words, "PETSc"], text=True).split()


class Tutorials(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        for name in ("ex16", "ex77"):
            subprocess.run(["mpicc", "-O1", "-w", "-o", cls.program(name), f"{TUTORIALS}/{name}.c",
                            *flags("--cflags"), *flags("--libs"), "-lm"], check=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def program(cls, name):
        return os.path.join(cls.folder.name, name)

    def test_arch_converges_on_one_rank(self):
        printed, status, _ = run([self.program("ex16")], f"{DIRECT} {ARCH} {TREFOIL}")
        self.assertEqual(status, 0)
        self.assertIn("Nonlinear solve converged", printed)

    def test_split_interface_elements_are_named_on_two(self):
        printed, status, _ = run([self.program("ex16")], f"{DIRECT} {ARCH} {TREFOIL}", 2)
        self.assertNotEqual(status, 0)
        self.assertIn("interface between ranks of a DMDA", sentence(printed))

    def test_saddle_point_is_refused(self):
        for ranks in (1, 2):
            printed, status, _ = run([self.program("ex77")], f"{MIXED} {TREFOIL}", ranks)
            self.assertNotEqual(status, 0)
            self.assertIn("saddle point", sentence(printed))
            self.assertIn("-snes_trefoil_fields", sentence(printed))

    def test_follower_load_is_refused_once_the_field_is_named(self):
        printed, status, _ = run([self.program("ex77")],
                                 f"{MIXED} {TREFOIL} -snes_trefoil_fields deformation")
        self.assertNotEqual(status, 0)
        self.assertIn("not symmetric", sentence(printed))
        printed, status, _ = run([self.program("ex77")],
                                 f"{MIXED} {TREFOIL} -snes_trefoil_fields displacment")
        self.assertIn("its fields are: deformation, pressure", sentence(printed))

    def test_unfiltered_on_demand(self):
        printed, status, _ = run([self.program("ex77")],
                                 f"{MIXED} {TREFOIL} -snes_trefoil_strict false", 2)
        self.assertEqual(status, 0)
        self.assertIn("Nonlinear solve converged", printed)


if __name__ == "__main__":
    if not os.path.exists(f"{TUTORIALS}/ex77.c"):
        print("skipped: libpetsc3.18-dev-examples is not installed")
        sys.exit(77)
    unittest.main(verbosity=2)
