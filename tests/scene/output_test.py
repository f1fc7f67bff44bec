"""What is written: in the order of the mesh that was read, on any number of ranks, and readable by
others."""
import os
import random
import subprocess
import sys
import tempfile
import unittest

import h5py
import meshio
import numpy as np

from mesh_test import box, gmsh
from trefoil_program import ROOT, run

PULLED = ["-constraints", "low,top", "-constraint_low_where", "z == zmin", "-constraint_top_where",
          "z == zmax", "-constraint_top_move", "0, 0, 0.3"]
PLANE = ["-mesh_generate", "square", "-mesh_resolution", "3", "-constraints", "low,top",
         "-constraint_low_where", "y == ymin", "-constraint_top_where", "y == ymax",
         "-constraint_top_move", "0, 0.3"]


def shuffled(n=2, unused=False):
    """The unit cube in no order at all: points, and tetrahedra by numbers from 1. The first vertex
    may be one that no tetrahedron has."""
    chance = random.Random(4)
    points, cells = box(n)
    order = list(range(len(points)))
    chance.shuffle(order)
    place = {old: new for new, old in enumerate(order)}
    shift = 2 if unused else 1
    points = [(9.0, 9.0, 9.0)] * unused + [points[old] for old in order]
    cells = [[place[vertex - 1] + shift for vertex in cell] for cell in cells]
    chance.shuffle(cells)
    return points, cells


def read(path):
    """Points, cells and fields of an XDMF output of one state, straight from its HDF5 file."""
    with h5py.File(path[:-4] + "h5", "r") as data:
        fields = {name: rows[()] for group in ("vertex_fields", "cell_fields")
                  for name, rows in data[group].items()}
        return data["points"][()], data["cells"][()], fields


def convert(*words):
    """`meshio convert`, also where the package of the command is missing."""
    command = [sys.executable, "-c", "import sys; from meshio._cli import main; main(sys.argv[1:])"]
    subprocess.run([*command, "convert", *words], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.STDOUT)


class Output(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def mesh(self, points, cells):
        with open(self.path("body.msh"), "w", encoding="ascii") as file:
            file.write(gmsh(points, [(4, 1, cell) for cell in cells]))
        return ["-mesh_file", self.path("body.msh"), *PULLED]

    def run_to(self, name, options, ranks=1):
        path = self.path(name)
        done = run([*options, "-output_file", path], ranks, self.folder)
        self.assertEqual(done.returncode, 0, done.stdout)
        return path

    def test_rows_are_those_of_the_mesh_file(self):
        points, cells = shuffled()
        options = self.mesh(points, cells)
        moved = {}
        for ranks in (1, 2, 3):
            rest, nodes, fields = read(self.run_to("out.xdmf", options, ranks))
            np.testing.assert_array_equal(rest, points)
            np.testing.assert_array_equal(nodes + 1, cells)
            self.assertNotIn("original_vertex", fields)
            moved[ranks] = fields["displacement"]
            np.testing.assert_allclose(moved[ranks], moved[1], atol=1e-9)
            for name in ("determinant_F", "rank"):
                self.assertEqual(len(fields[name]), len(cells))
            self.assertEqual(set(fields["rank"]), set(range(ranks)))
        ends = rest[:, 2] == 1
        np.testing.assert_allclose(moved[1][ends], [[0, 0, 0.3]] * ends.sum(), atol=1e-15)

    def test_where_rows_are_others_their_numbers_in_the_file_are_told(self):
        for unused, more in ((True, []), (False, ["-order", "2"]), (False, ["-mesh_refine", "1"]),
                             (True, ["-mesh_refine", "1", "-order", "2"])):
            points, cells = shuffled(unused=unused)
            points = np.array(points)
            options = self.mesh(points.tolist(), cells) + more
            previous = None
            for ranks in (1, 2, 3):
                rest, nodes, fields = read(self.run_to("out.xdmf", options, ranks))
                original = fields["original_vertex"].astype(int)
                old = original >= 0
                np.testing.assert_array_equal(rest[old], points[original[old]])
                # The file's come first, in their order, and all that a tetrahedron has.
                np.testing.assert_array_equal(original[:27], np.arange(27) + unused)
                self.assertTrue((original[27:] == -1).all())
                if "-mesh_refine" in more and "-order" not in more:
                    self.assertEqual(len(nodes), 8 * len(cells))
                elif previous is not None:
                    np.testing.assert_array_equal(nodes, previous)
                previous = nodes
                if more == ["-order", "2"]:
                    np.testing.assert_array_equal(nodes[:, :4] + 1, cells)

    def test_vtu_is_what_xdmf_is(self):
        for name, options in (("tetra", self.mesh(*shuffled())), ("triangle", PLANE),
                              ("tetra10", self.mesh(*shuffled()) + ["-order", "2"]),
                              ("triangle6", PLANE + ["-order", "2"])):
            expected = meshio.read(self.run_to("out.xdmf", options))
            for ranks in (1, 2):
                grid = meshio.read(self.run_to("out.vtu", options, ranks))
                np.testing.assert_array_equal(grid.points, expected.points)
                self.assertEqual([block.type for block in grid.cells], [name])
                np.testing.assert_array_equal(grid.cells[0].data, expected.cells[0].data)
                self.assertEqual(set(grid.point_data), set(expected.point_data))
                self.assertEqual(set(grid.cell_data), set(expected.cell_data))
                for field, rows in expected.point_data.items():
                    np.testing.assert_allclose(grid.point_data[field], rows, atol=1e-9)
        self.assertEqual([name for name in os.listdir(self.folder) if ".part" in name], [])

    def test_meshio_converts(self):
        points, cells = shuffled()
        options = self.mesh(points, cells)
        for source in ("out.xdmf", "out.vtu"):
            path = self.run_to(source, options, 2)
            for ending, more in ((".msh", ["--output-format", "gmsh"]), (".mesh", []),
                                 (".vtk", [])):
                target = self.path("converted" + ending)
                convert(path, target, *more)
                mesh = meshio.read(target)
                np.testing.assert_allclose(mesh.points, points, atol=1e-12)
                np.testing.assert_array_equal(mesh.cells[0].data + 1, cells)
                if ending == ".vtk":
                    self.assertIn("displacement", mesh.point_data)
                else:  # what can be read back is the same body
                    again = run(["-mesh_file", target, *PULLED], folder=self.folder)
                    self.assertIn("27 vertices, 48 tetrahedra", again.stdout)
        plane = self.run_to("plane.xdmf", PLANE)
        convert(plane, self.path("plane.obj"))
        self.assertEqual(len(meshio.read(self.path("plane.obj")).cells[0].data), 18)

    def test_the_example_converts_the_deformed_body(self):
        points, cells = shuffled(3)
        path = self.run_to("out.xdmf", self.mesh(points, cells), 2)
        _, nodes, fields = read(path)
        moved = np.array(points) + fields["displacement"]
        script = os.path.join(ROOT, "examples", "convert.py")
        for ending in (".msh", ".mesh", ".vtk", ".obj", ".stl"):
            target = self.path("moved" + ending)
            subprocess.run([sys.executable, script, path, target], check=True,
                           stdout=subprocess.DEVNULL)
            mesh = meshio.read(target)
            if ending in (".obj", ".stl"):
                self.assertEqual(len(mesh.cells[0].data), 6 * 2 * 9)
                self.assertAlmostEqual(mesh.points[:, 2].max(), 1.3, places=5)
                a, b, c = (mesh.points[mesh.cells[0].data[:, k]] for k in range(3))
                volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
                tets = [moved[nodes[:, k]] for k in range(4)]
                edges = np.stack([tets[k] - tets[0] for k in (1, 2, 3)], axis=1)
                self.assertAlmostEqual(volume, np.linalg.det(edges).sum() / 6, places=5)
            else:
                np.testing.assert_allclose(mesh.points, moved, atol=1e-6)
                np.testing.assert_array_equal(mesh.cells[0].data + 1, cells)
        done = subprocess.run([sys.executable, script, path, self.path("a.xyz")], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertNotIn("Traceback", done.stdout)

    def test_other_endings_are_refused_before_the_solve(self):
        for name, words in (("out.vtk", "meshio convert out.xdmf out.vtk"),
                            ("out.msh", "--output-format gmsh"), ("out", ".xdmf or .vtu"),
                            ("nowhere/out.vtu", "there is no directory")):
            for ranks in (1, 2):
                done = run([*PLANE, "-output_file", name], ranks, self.folder)
                self.assertEqual(done.returncode, 1)
                self.assertNotIn("iterations", done.stdout)
                sentences = [line for line in done.stdout.splitlines() if "trefoil: " in line]
                self.assertEqual(len(sentences), 1)
                self.assertIn(words, sentences[0])
        self.assertEqual(os.listdir(self.folder), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
