#!/usr/bin/python3
"""Several bodies from several files: the same as one file that has them all; groups, messages and
output know each body; what makes no scene of bodies is said in one sentence on any ranks."""
import json
import os
import sys
import tempfile
import unittest

from mesh_test import box, gmsh, medit
from trefoil_program import ROOT, run

sys.path.insert(0, os.path.join(ROOT, "examples", "python"))
import trefoil  # noqa: E402

GAP = 0.05
SOFT = ["-material_young", "1e5", "-material_poisson", "0.3", "-contact_distance", "0.01"]
TRIANGLES = "MeshVersionFormatted 2\nDimension 2\nVertices\n3\n0 0 0\n1 0 0\n0 1 0\nTriangles\n1\n" \
            "1 2 3 0\nEnd\n"


def faces(cells, points, z):
    """The faces of the tetrahedra that lie at this height."""
    return [(2, 0, face) for cell in cells for face in
            ([cell[j] for j in range(4) if j != k] for k in range(4))
            if all(points[node - 1][2] == z for node in face)]


class Bodies(unittest.TestCase):
    """A cube of 2 x 2 x 2 cells and above it one of 1 x 1 x 1, pressed onto it."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.low, self.high = box(2), box(1)
        low, high = ([(4, 9, cell) for cell in cells] for _, cells in (self.low, self.high))
        low += [(2, 7, face) for *_, face in faces(self.low[1], self.low[0], 0)]
        high += [(2, 7, face) for *_, face in faces(self.high[1], self.high[0], 1)]
        self.write("low.msh", gmsh(self.low[0], low, [(3, 9, "all"), (2, 7, "held")]))
        self.write("high.msh", gmsh(self.high[0], high, [(2, 7, "held")]))

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w", encoding="ascii") as file:
            file.write(text)

    def shifted(self):
        """The upper cube's points, where the scene of one file has it."""
        return [(0.1 + 0.8 * x, 0.1 + 0.8 * y, 1 + GAP + 0.8 * z) for x, y, z in self.high[0]]

    def pressed(self, low, high):
        return [*SOFT, "-constraints", "low,high", *low, *high,
                "-constraint_high_move", "0.05, 0, -0.2"]

    def bodies(self):
        return ["-bodies", "low,high", "-body_low_file", "low.msh", "-body_high_file", "high.msh",
                "-body_high_scale", "0.8", "-body_high_translate", f"0.1, 0.1, {1 + GAP}"]

    def in_folder(self, options, ranks=1):
        return run(options, ranks, self.folder)

    def record(self, options, ranks=1):
        result = self.in_folder([*options, "-snes_trefoil_record", "run.json"], ranks)
        self.assertEqual(result.returncode, 0, result.stdout)
        with open(os.path.join(self.folder, "run.json"), encoding="utf-8") as file:
            return json.load(file)

    def refused(self, options, *words):
        sentences = set()
        for ranks in (1, 3):
            result = self.in_folder(options, ranks)
            said = [line for line in result.stdout.splitlines() if line.startswith("trefoil: ")]
            self.assertEqual((result.returncode, len(said)), (1, 1), result.stdout)
            sentences.add(said[0])
        self.assertEqual(len(sentences), 1, sentences)
        for word in words:
            self.assertIn(word, said[0])

    def test_as_one_file_on_any_ranks(self):
        points, cells = self.low
        whole = medit(points + self.shifted(),
                      cells + [[len(points) + node for node in cell] for cell in self.high[1]],
                      [0] * (len(cells) + len(self.high[1])))
        self.write("whole.mesh", whole)
        one = self.record(["-mesh_file", "whole.mesh", "-output_file", "whole.xdmf", *self.pressed(
            ["-constraint_low_where", "z == zmin"], ["-constraint_high_where", "z == zmax"])])
        expected = trefoil.read_steps(os.path.join(self.folder, "whole.xdmf"))[-1]
        by_name = self.pressed(["-constraint_low_group", "low/held"],
                               ["-constraint_high_group", "high/surface 7"])
        for ranks in (1, 2, 3):
            record = self.record([*self.bodies(), *by_name, "-output_file", "two.xdmf"], ranks)
            self.assertAlmostEqual(record["result"]["energy"] / one["result"]["energy"], 1,
                                   delta=1e-9)
            step = trefoil.read_steps(os.path.join(self.folder, "two.xdmf"))[-1]
            self.assertLess(abs(step.points - expected.points).max(), 1e-15)
            self.assertTrue((step.cells == expected.cells).all())
            self.assertLess(abs(step.fields["displacement"]
                                - expected.fields["displacement"]).max(), 1e-7)

    def test_a_list_of_files(self):
        self.write("above.mesh", medit(self.shifted(), self.high[1], [4] * len(self.high[1])))
        listed = self.in_folder(["-mesh_files", "low.msh,above.mesh", "--check", "-constraints", "a",
                                 "-constraint_a_group", "low/held", "-constraint_a_move", "0, 0, 0",
                                 "-time_end", "1", "-time_step", "1", "-material_density", "1",
                                 "-regions", "top", "-region_top_group", "above",
                                 "-region_top_material_young", "2e5"], 2)
        self.assertEqual(listed.returncode, 0, listed.stdout)
        for said in ("mesh: 2 bodies (low and above), 35 vertices, 54 tetrahedra, 2 unconnected",
                     "group: volume 'low', 48 cells", "group: volume 9 'low/all', 48 cells",
                     "group: surface 7 'low/held', 8 facets", "group: volume 4 'above/4', 6 cells",
                     "top: 6 cells, volume 0.512"):
            self.assertIn(said, listed.stdout)

    def test_names_that_one_body_has_need_no_body(self):
        held = ["-constraints", "low,high", "-constraint_low_group", "all",
                "-constraint_high_group", "high"]
        result = self.in_folder([*self.bodies(), *held])
        self.assertIn("the constraints hold every vertex", result.stdout)
        self.refused([*self.bodies(), "-constraints", "a", "-constraint_a_group", "held"],
                     "several bodies have a group 'held'; name one, as 'low/held' or 'high/held'")
        self.refused([*self.bodies(), "-constraints", "a", "-constraint_a_group", "low/nowhere"],
                     "no group 'low/nowhere'", "surface 7 'low/held'")

    def test_bodies_are_scaled_turned_and_moved(self):
        self.record(["-bodies", "here,there", "-body_here_generate", "box", "-body_here_resolution",
                     "1", "-body_there_file", "high.msh", "-body_there_scale", "2",
                     "-body_there_rotate", "0, 0, 3, 90", "-body_there_translate", "5, 0, 1",
                     "-constraints", "a", "-constraint_a_where", "z == zmin || x > 2",
                     "-output_file", "placed.xdmf"])
        points = trefoil.read_steps(os.path.join(self.folder, "placed.xdmf"))[-1].points
        expected = [(5 - 2 * y, 2 * x, 1 + 2 * z) for x, y, z in self.high[0]]
        self.assertLess(abs(points[8:] - expected).max(), 1e-14)

    def test_messages_count_in_the_body_s_own_file(self):
        options = [*self.bodies(), *SOFT, "-constraints", "a", "-constraint_a_group", "low/held",
                   "-body_high_translate", "0.1, 0.1, 0.9", "-time_end", "1", "-time_step", "1",
                   "-material_density", "1"]
        self.refused(options, "the rest shape intersects itself", ") of low and ", ") of high ")
        self.write("flat.mesh", medit([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [[1, 2, 3, 4]],
                                      [0]))
        self.refused(["-mesh_files", "low.msh,flat.mesh"],
                     "flat.mesh: 1 tetrahedron is degenerate", "the first is tetrahedron 1;")

    def test_groups_outlive_hdf5(self):
        written = self.in_folder([*self.bodies(), "-mesh_write", "both.h5"], 2)
        self.assertEqual(written.returncode, 0, written.stdout)
        by_name = self.pressed(["-constraint_low_group", "low/held"],
                               ["-constraint_high_group", "high/held"])
        energy, again = (self.record([*mesh, *by_name], 2)["result"]["energy"]
                         for mesh in (self.bodies(), ["-mesh_file", "both.h5"]))
        self.assertAlmostEqual(again / energy, 1, delta=1e-9)

    def test_a_checkpoint_knows_where_bodies_are(self):
        by_name = self.pressed(["-constraint_low_group", "low/held"],
                               ["-constraint_high_group", "high/held"])
        self.record([*self.bodies(), *by_name, "-checkpoint", "run.ckpt"], 2)
        moved = [*self.bodies(), *by_name, "-body_high_translate", "0.1, 0.1, 1.06"]
        self.record([*self.bodies(), *by_name, "-restart", "run.ckpt"])
        self.refused([*moved, "-restart", "run.ckpt"], "vertices in other places")

    def test_bad_input(self):
        points, cells = self.high
        second_order = gmsh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (.5, 0, 0), (.5, .5, 0),
                             (0, .5, 0), (0, 0, .5), (0, .5, .5), (.5, 0, .5)],
                            [(11, 1, list(range(1, 11)))])
        self.write("flat.mesh", TRIANGLES)
        self.write("second.msh", second_order)
        self.write("both.h5", "")
        with open(os.path.join(self.folder, "both.h5"), "wb") as file:
            file.write(b"\x89HDF\r\n\x1a\n")
        self.write("scene.yaml", "mesh: {files: []}\n")
        os.mkdir(os.path.join(self.folder, "sub"))
        self.write("sub/low.mesh", medit(points, cells, [0] * len(cells)))
        self.refused(["scene.yaml"], "-mesh_files is given without a value")
        self.refused(["-mesh_files", "low.msh,none.msh"], "none.msh")
        self.refused(["-mesh_files", "low.msh,flat.mesh"], "'low' has tet4 and 'flat' has tri3",
                     "in the plane or in space")
        self.refused(["-mesh_files", "low.msh,second.msh"], "'low' has tet4 and 'second' has tet10",
                     "-order 1")
        self.refused(["-mesh_files", "low.msh,sub/low.mesh"], "two files called 'low'")
        self.refused(["-mesh_files", "low.msh,low.msh"], "names 'low.msh' twice")
        self.refused(["-mesh_files", "low.msh,both.h5"], "both.h5 is HDF5")
        self.refused(["-mesh_files", "low.msh", "-mesh_generate", "box"], "a scene has one mesh")
        self.refused(["-mesh_files", "low.msh", *self.bodies()], "not from both")
        self.refused([*self.bodies(), "-body_high_scale", "0"], "-body_high_scale must be above 0")
        self.refused([*self.bodies(), "-body_high_rotate", "1, 2"], "-body_high_rotate is '1, 2'")
        self.refused([*self.bodies(), "-body_high_rotate", "0, 0, 0, 3"], "has no axis")
        self.refused([*self.bodies(), "-body_high_translate", "up"], "-body_high_translate is 'up'")
        self.refused([*self.bodies(), "-body_high_generate", "box"], "body 'high' needs either")
        self.refused([*self.bodies(), "-body_high_resolution", "2"], "is for a generated body")
        self.refused([*self.bodies(), "-body_higher_scale", "2"], "-body_higher_scale")
        self.refused([*self.bodies(), "-output_csv", "high.msh"], "would write over 'high.msh'")


if __name__ == "__main__":
    unittest.main()
