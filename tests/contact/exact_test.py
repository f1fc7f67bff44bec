#!/usr/bin/python3
"""The independent checker finds what is there, nothing else, and reads what the program writes."""
import base64
import os
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import h5py
import numpy as np

import exact
import mesh_files

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "scene"))
from trefoil_program import ROOT, run  # noqa: E402

TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)


def two_tetrahedra(depth):
    """The tip of the upper one is `depth` below the lower one's slanted face x + y + z = 1."""
    tip = np.full(3, (1 - depth) / 3)
    upper = tip + np.array([[0, 0, 0], [1, 0.2, 0.1], [0.1, 1, 0.2], [0.2, 0.1, 1]])
    return np.concatenate([TETRAHEDRON, upper]), np.array([[0, 1, 2, 3], [4, 5, 6, 7]])


def write_xdmf(path, points, cells, displacements, shape="Tetrahedron"):
    """As the program does; several displacements are a series with one mesh."""
    data = os.path.basename(path).replace(".xdmf", ".h5")
    with h5py.File(path.replace(".xdmf", ".h5"), "w") as file:
        file["points"], file["cells"] = points, cells
        for k, displacement in enumerate(displacements):
            file[f"{k}/displacement"] = displacement
    item = lambda name: f'<DataItem Format="HDF">{data}:/{name}</DataItem>'
    grids = "".join(
        f'<Grid GridType="Uniform"><Time Value="{k}"/>'
        f'<Topology TopologyType="{shape}">{item("cells")}</Topology>'
        f'<Geometry GeometryType="XYZ">{item("points")}</Geometry>'
        f'<Attribute Name="displacement" Center="Node">{item(f"{k}/displacement")}</Attribute>'
        f"</Grid>" for k in range(len(displacements)))
    with open(path, "w", encoding="utf-8") as file:
        file.write(f'<?xml version="1.0"?><Xdmf Version="3.0"><Domain><Grid GridType="Collection" '
                   f'CollectionType="Temporal">{grids}</Grid></Domain></Xdmf>')


def write_vtu(path, pieces, form):
    """`pieces` of points, displacement, cells; `form` ascii, base64, zlib (in base64) or raw."""
    appended = b""

    def array(name, kind, values, components):
        nonlocal appended
        values = np.ascontiguousarray(values)
        head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" '
        if form == "ascii":
            text = " ".join(repr(x) for x in values.ravel().tolist())
            return f'{head}format="ascii">{text}</DataArray>'
        raw = values.tobytes()
        if form == "raw":
            offset, appended = len(appended), appended + struct.pack("<Q", len(raw)) + raw
            return f'{head}format="appended" offset="{offset}"/>'
        if form == "base64":
            text = base64.b64encode(struct.pack("<Q", len(raw)) + raw)
        else:
            half = -(-len(raw) // 2)
            blocks = [zlib.compress(raw[:half]), zlib.compress(raw[half:])]
            header = struct.pack("<5Q", 2, half, len(raw) - half, *map(len, blocks))
            text = base64.b64encode(header) + base64.b64encode(b"".join(blocks))
        return f'{head}format="binary">{text.decode()}</DataArray>'

    body = ""
    for points, displacement, cells in pieces:
        offsets = cells.shape[1] * np.arange(1, len(cells) + 1, dtype=np.int64)
        kinds = np.full(len(cells), 10, dtype=np.uint8)
        body += (f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}">'
                 f'<Points>{array("Position", "Float64", points, 3)}</Points>'
                 f'<Cells>{array("connectivity", "Int64", cells.ravel(), 1)}'
                 f'{array("offsets", "Int64", offsets, 1)}{array("types", "UInt8", kinds, 1)}'
                 f'</Cells><PointData>{array("displacement", "Float64", displacement, 3)}'
                 f'</PointData></Piece>')
    compressor = ' compressor="vtkZLibDataCompressor"' if form == "zlib" else ""
    head = (f'<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="1.0" byte_order='
            f'"LittleEndian" header_type="UInt64"{compressor}><UnstructuredGrid>{body}'
            f'</UnstructuredGrid>')
    with open(path, "wb") as file:
        file.write(head.encode())
        if form == "raw":
            file.write(b'<AppendedData encoding="raw">_' + appended + b"</AppendedData>")
        file.write(b"</VTKFile>")


def check(path, *options):
    """Exit status and text of the checker as a program."""
    result = subprocess.run([sys.executable, os.path.join(HERE, "exact.py"), path, *options],
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return result.returncode, result.stdout


class Found(unittest.TestCase):
    """Pairs that meet, and only those."""

    def found(self, depth):
        points, cells = two_tetrahedra(depth)
        return exact.intersections_of(mesh_files.Step("", points, cells))

    def test_a_tip_through_a_face(self):
        self.assertEqual(self.found(-1e-15), [])
        for depth in (0, 1e-15, 1e-3):  # touching counts
            self.assertEqual(sorted(edge for edge, _ in self.found(depth)),
                             [(4, 5), (4, 6), (4, 7)], depth)
            self.assertEqual({facet for _, facet in self.found(depth)}, {(1, 2, 3)})

    def test_all_pairs_of_a_crowd(self):
        random = np.random.default_rng(1)
        points = (random.normal(0, 0.1, (30, 4, 3)) + random.uniform(0, 1, (30, 1, 3)))
        cells = np.arange(120).reshape(30, 4)
        step = mesh_files.Step("", points.reshape(-1, 3), cells)
        facets = exact.facets_of(cells)
        edges = exact.edges_of(facets)
        brute = []
        for edge in edges:
            for facet in facets:
                if not set(edge) & set(facet) and exact.segment_meets_triangle(
                        *(exact._exactly(step.points[v]) for v in (*edge, *facet))):
                    brute.append((tuple(edge), tuple(facet)))
        self.assertGreater(len(brute), 10)
        self.assertEqual(exact.intersections_of(step), brute)

    def test_degenerate_positions(self):
        """On a lattice nearly everything touches; the order of the corners does not matter."""
        random = np.random.default_rng(2)
        for scale in (1, 0.5):
            points = scale * random.integers(0, 3, (120, 5, 3)).astype(float)
            for a, b, c, d, e in points:
                certain = exact.intersections([a, b, c, d, e], np.array([[0, 1]]),
                                              np.array([[2, 3, 4]]))
                reordered = exact.intersections([b, a, e, c, d], np.array([[0, 1]]),
                                                np.array([[2, 3, 4]]))
                self.assertEqual(certain, reordered)
                least = min(np.linalg.norm(p - q) for p in (a, b) for q in (c, d, e))
                if least == 0:
                    self.assertEqual(certain, [(0, 0)])

    def test_in_the_plane(self):
        square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
        cells = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
        for shift, count in ((1.5, 0), (1.0, 3), (0.5, 2)):
            points = np.concatenate([square, square + [shift, 0.25, 0]])
            self.assertEqual(len(exact.intersections_of(mesh_files.Step("", points, cells))), count)

    def test_bodies_with_themselves_can_be_left_out(self):
        points, cells = two_tetrahedra(0.1)
        # A chain of tetrahedra from one to the other makes them one body.
        cells = np.concatenate([cells, [[1, 2, 8, 5]]])
        points = np.concatenate([points, [[2, 2, -3]]])
        step = mesh_files.Step("", points, cells)
        self.assertGreater(len(exact.intersections_of(step)), 0)
        self.assertEqual(exact.intersections_of(step, between_bodies=True), [])
        points, cells = two_tetrahedra(0.1)
        step = mesh_files.Step("", points, cells)
        self.assertEqual(len(exact.intersections_of(step, between_bodies=True)), 3)


class Files(unittest.TestCase):
    """What is read is what was written; the exit status says what was found."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.points, self.cells = two_tetrahedra(-0.1)
        self.apart = np.zeros_like(self.points)
        self.down = self.apart.copy()
        self.down[4:] = -0.2

    def path(self, name):
        return os.path.join(self.folder, name)

    def test_series(self):
        path = self.path("run.xdmf")
        write_xdmf(path, self.points, self.cells, [self.apart, self.apart])
        self.assertEqual(check(path), (0, "2 states, 0 with intersections\n"))
        write_xdmf(path, self.points, self.cells, [self.apart, self.down, self.apart])
        status, text = check(path)
        self.assertEqual(status, 1)
        self.assertIn("t = 1: 3 pairs intersect, the first edge (4, 5) and facet (1, 2, 3)", text)
        self.assertIn("3 states, 1 with intersections", text)

    def test_vtu(self):
        for form in ("ascii", "base64", "zlib", "raw"):
            for displacement, status in ((self.apart, 0), (self.down, 1)):
                path = self.path(form + ".vtu")
                write_vtu(path, [(self.points, displacement, self.cells)], form)
                self.assertEqual(check(path)[0], status, form)
                step = next(mesh_files.steps_of(path))
                np.testing.assert_array_equal(step.points, self.points + displacement)
                np.testing.assert_array_equal(step.cells, self.cells)

    def test_pieces_of_ranks_are_put_together(self):
        """Two tetrahedra with a common face, each on a rank of its own: no facets inside."""
        points = np.concatenate([TETRAHEDRON, [[1, 1, 1]]])
        pieces = [(points[corners], 0 * points[corners], np.array([[0, 1, 2, 3]]))
                  for corners in ([0, 1, 2, 3], [4, 1, 2, 3])]
        write_vtu(self.path("ranks.vtu"), pieces, "raw")
        step = next(mesh_files.steps_of(self.path("ranks.vtu")))
        self.assertEqual(len(step.points), 5)
        self.assertEqual(len(exact.facets_of(step.cells)), 6)

    def test_what_cannot_be_read(self):
        self.assertEqual(check(self.path("nothing.xdmf"))[0], 2)
        self.assertEqual(check(self.path("nothing.txt"))[0], 2)
        path = self.path("quadratic.xdmf")
        write_xdmf(path, self.points, np.zeros((1, 10), int), [self.apart], "Tetrahedron_10")
        status, text = check(path)
        self.assertEqual(status, 2)
        self.assertIn("10 nodes", text)

    def test_runs_of_the_program(self):
        """A stretched box stays as it is; a knot pulled without contact goes through itself."""
        box = ["-mesh_generate", "box", "-mesh_resolution", "3", "-constraints", "low,high",
               "-constraint_low_where", "z == zmin", "-constraint_high_where", "z == zmax",
               "-constraint_high_move", "0, 0, 0.5"]
        knot = ["-options_file", os.path.join(ROOT, "examples", "knot.yaml")]
        for scene, status in ((box, 0), (knot, 1)):
            result = run([*scene, "-output_file", "run.xdmf"], folder=self.folder)
            self.assertEqual(result.returncode, 0, result.stdout)
            self.assertEqual(check(self.path("run.xdmf"))[0], status)


if __name__ == "__main__":
    unittest.main()
