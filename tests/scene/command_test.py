#!/usr/bin/python3
"""The command line: help, version, scene files as arguments, parts that are named once."""
import os
import re
import tempfile
import unittest

from trefoil_program import record_of, run

LISTED = """
mesh: {generate: box, resolution: 2}
material: {young: 1e5, poisson: 0.3, density: 2}
regions: soft
region: {soft: {where: "z < 0.5", material: {young: 5e4}}}
constraints: low,side
constraint:
  low: {where: "z == zmin"}
  side: {where: "x == xmin && z > 0", move: "-x*0, free, free"}
loads: top
load:
  top: {where: "z == zmax", traction: "0, 0, -1e3"}
  gravity: "0, 0, -9.81"
"""
NESTED = """
mesh: {generate: box, resolution: 2}
material: {young: 1e5, poisson: 0.3, density: 2}
regions: {soft: {where: "z < 0.5", material: {young: 5e4}}}
constraints:
  low: {where: "z == zmin"}
  side:
    where: "x == xmin
            && z > 0"
    move: ["-x*0", free, free]
loads: {top: {where: "z == zmax", traction: "0, 0, -1e3"}}
load: {gravity: "0, 0, -9.81"}
"""
LINES = """
# PETSc's own format
-mesh_generate box
-mesh_resolution 2
-material_young 1e5
-material_poisson 0.3
-material_density 2
-regions soft
-region_soft_where "z < 0.5"
-region_soft_material_young 5e4
-constraints low,side
-constraint_low_where 'z == zmin'   # the ground
-constraint_side_where "x == xmin && z > 0"
-constraint_side_move "0, free, free"
-loads top
-load_top_where "z == zmax"
-load_top_traction "0, 0, -1e3"
-load_gravity "0, 0, -9.81"
"""
ANCHORS = """
$$steel: &steel {young: 1e5, poisson: 0.3, density: 2}
mesh: {generate: box, resolution: 2}
material: {<<: *steel}
regions: {soft: {where: "z < 0.5", material: {<<: *steel, young: 5e4}}}
constraints: {low: {where: "z == zmin"}, side: {where: "x == xmin && z > 0", move: "0, free, free"}}
loads: {top: {where: "z == zmax", traction: "0, 0, -1e3"}}
load: {gravity: "0, 0, -9.81"}
"""
# As LINES and NESTED, but in two files, of which the second adds parts and changes one.
FIRST = """
mesh: {generate: box, resolution: 2}
material: {young: 1e5, poisson: 0.3, density: 2}
constraints: {low: {where: "z == zmin"}}
loads: {top: {where: "z == zmax", traction: "0, 0, 7"}}
"""
SECOND = """
regions: {soft: {where: "z < 0.5", material: {young: 5e4}}}
constraints: {side: {where: "x == xmin && z > 0", move: "0, free, free"}}
load: {gravity: "0, 0, -9.81", top: {traction: "0, 0, -1e3"}}
"""


class Words(unittest.TestCase):
    def test_help(self):
        helped = run("--help")
        self.assertEqual(helped.returncode, 0)
        lines = helped.stdout.splitlines()
        self.assertLessEqual(len(lines), 40)
        self.assertLessEqual(max(map(len, lines)), 100)
        self.assertEqual(sum(line.startswith("  trefoil") or line.startswith("  mpirun")
                             for line in lines), 3)
        for words in ("-h", "-mesh_file a.mesh --help"):
            self.assertEqual(run(words).stdout, helped.stdout)
        self.assertEqual(run("--help", 2).stdout, helped.stdout)
        nothing = run("")
        self.assertEqual((nothing.returncode, nothing.stdout), (1, helped.stdout))

    def test_all_options_once(self):
        for words in ("--help all", "-help"):
            helped = run(words)
            self.assertEqual(helped.returncode, 0)
            for name in ("mesh_file", "material_young", "constraint_NAME_where", "output_file",
                         "snes_trefoil_filter", "snes_trefoil_record", "snes_trefoil_space",
                         "snes_trefoil_monitor", "initial_steps", "load_NAME_traction"):
                found = re.findall(rf"^ +-{name}[ :]", helped.stdout, re.M)
                self.assertEqual(len(found), 1, name)

    def test_what_the_short_help_names_exists(self):
        names = re.findall(r"^  (-\w+)", run("--help").stdout, re.M)
        everything = run("--help all").stdout
        self.assertGreater(len(names), 15)
        for name in names:
            self.assertIn(name, everything)

    def test_version(self):
        for ranks in (1, 2):
            version = run("--version", ranks)
            self.assertEqual(version.returncode, 0)
            self.assertRegex(version.stdout, r"Trefoil \d+\.\d+")
            self.assertRegex(version.stdout, r"Petsc Release Version \d+\.\d+")
            self.assertIn(f"{ranks} rank", version.stdout)


class SceneFiles(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def file(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def energy(self, *words, ranks=1):
        record = record_of(words, ranks)
        self.assertEqual(record["status"], 0, record["printed"])
        return record["result"]["energy"]

    def test_every_form_is_the_same_scene(self):
        listed = self.file("listed.yaml", LISTED)
        expected = self.energy("-options_file", listed)
        nested, lines = self.file("nested.yaml", NESTED), self.file("lines.petsc", LINES)
        forms = [[listed], [nested], [lines], ["-options_file", nested], ["-options_file", lines],
                 ["-options_file_yaml", self.file("nested", NESTED)],
                 ["-options_file", self.file("other", NESTED) + ":yaml"],
                 [self.file("begins", "---\n" + NESTED)],
                 [self.file("anchors.yaml", ANCHORS)],
                 [self.file("first.yaml", FIRST), self.file("second.yaml", SECOND)]]
        for words in forms:
            with self.subTest(words=words):
                self.assertEqual(self.energy(*words), expected)
        self.assertAlmostEqual(self.energy(nested, ranks=2) / expected, 1, delta=1e-9)

    def test_what_comes_later_wins(self):
        nested = self.file("nested.yaml", NESTED)
        stiff = self.energy(nested, "-material_young", "2e5")
        self.assertNotEqual(stiff, self.energy(nested))
        self.assertEqual(stiff, self.energy("-options_file", nested, "-material_young", "2e5"))
        self.assertEqual(self.energy("-material_young", "2e5", "-options_file", nested),
                         self.energy(nested))
        self.assertEqual(self.energy(nested, "-load_top_traction", "0, 0, 2e3"),
                         self.energy(self.file("n2.yaml", NESTED.replace("-1e3", "2e3"))))

    def test_a_value_that_looks_like_an_option(self):
        """On the command line PETSc takes -x for a name; in a file it is a formula."""
        yaml = ("mesh: {generate: box, resolution: 2}\nconstraints:\n  low: {where: \"z == zmin\"}\n"
                "  top: {where: \"z == zmax\", move: \"-x*0.1, 0, 0\"}\n")
        with_minus = self.energy(self.file("minus.yaml", yaml))
        brackets = self.file("brackets.yaml", yaml.replace("-x*0.1", "-(x)*0.1"))
        self.assertEqual(with_minus, self.energy(brackets))


if __name__ == "__main__":
    unittest.main(verbosity=2)
