#!/usr/bin/python3
"""--check: builds a scene, says what it holds and what its solve would take, and solves nothing."""
import os
import tempfile
import unittest

from boxes import TIGHT
from group_test import write_gmsh
from trefoil_program import record_of, run


class Check(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.mesh = os.path.join(cls.folder.name, "cube.msh")
        cls.scene = os.path.join(cls.folder.name, "scene.yaml")
        write_gmsh(cls.mesh)
        with open(cls.scene, "w", encoding="utf-8") as file:
            file.write(f"""
mesh: {{file: {cls.mesh}}}
material: {{young: 2e5, poisson: 0.25, density: 3}}
regions: {{soft: {{where: "z < 0.5", material: {{young: 1e4, model: neo_hookean}}}}}}
constraints: {{wall: {{group: wall}}}}
loads: {{lid: {{group: lid, traction: "0, 0, -5"}}}}
load: {{gravity: "0, 0, -10"}}
output: {{file: {cls.folder.name}/out.xdmf}}
snes: {{trefoil_record: {cls.folder.name}/run.json}}
""")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_tells_what_the_scene_holds(self):
        for ranks in (1, 2, 3):
            checked = run(["--check", self.scene], ranks)
            self.assertEqual(checked.returncode, 0, checked.stdout)
            for words in ("27 vertices, 48 tetrahedra", "group: surface 7 'wall', 8 facets",
                          "group: point 3 'tip', 1 points", "group: volume 1 'body', 48 cells",
                          "wall: 9 vertices, area 1\n",
                          "lid: 8 facets, area 1, total force (0, 0, -5)\n",
                          "lid: moment about the origin (-2.5, 2.5, 0)\n",
                          "gravity: total force (0, 0, -30)\n",
                          "gravity: moment about the origin (-15, 15, 0)\n",
                          "body: 24 cells, volume 0.5, mass 1.5; stable_neo_hookean, E 200000, "
                          "nu 0.25, mu 80000, lambda 80000, bulk modulus 133333, density 3\n",
                          "soft: 24 cells, volume 0.5, mass 1.5; neo_hookean, E 10000, nu 0.25",
                          "54 unknowns", "solver: Cholesky by " + ("cholmod", "mumps")[ranks > 1],
                          "memory to expect: ", "nothing was solved"):
                self.assertIn(words, checked.stdout)
            self.assertEqual(sorted(os.listdir(self.folder.name)), ["cube.msh", "scene.yaml"])

    def test_refuses_what_a_run_refuses(self):
        for options, words in ((["-constraint_wall_group", "wal"], "has no group 'wal'"),
                               (["-ksp_typ", "cg"], "-ksp_typ"),
                               (["-initial", "expression", "-initial_displacement", "q, 0, 0"],
                                "-initial_displacement"),
                               (["-output_file", "a.xyz"], "a.xyz"),
                               (["-snes_type", "qn"], "qn")):
            refused = run(["--check", self.scene, *options], 2)
            self.assertEqual(refused.returncode, 1, refused.stdout)
            self.assertIn(words, refused.stdout)
            self.assertNotIn("nothing was solved", refused.stdout)

    def test_the_record_says_what_solved(self):
        for ranks, package, options in ((1, "cholmod", []), (2, "mumps", [])):
            record = record_of([self.scene, *TIGHT, *options], ranks)
            self.assertEqual(record["solver"]["linear"], f"Cholesky by {package}")
        record = record_of([self.scene, "-pc_type", "gamg"])
        self.assertEqual(record["solver"]["linear"], "cg with gamg")


if __name__ == "__main__":
    unittest.main(verbosity=2)
