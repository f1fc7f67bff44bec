#!/usr/bin/python3
"""Groups of the mesh file in constraints and loads: the same as the formula that finds them, in Gmsh's
and Medit's files, refined, quadratic, on several ranks; and what is no group for the purpose."""
import itertools
import os
import tempfile
import unittest

from boxes import TIGHT, energy
from trefoil_program import record_of, refusal_of

N = 3  # vertices along an edge
NAMES = {"wall": (2, 7), "lid": (2, 8), "middle": (2, 9), "edge": (1, 7), "tip": (0, 3), "body": (3, 1)}


def cube():
    """Vertices and tetrahedra of a cube of 2 x 2 x 2 cells."""
    vertices = [(x / 2, y / 2, z / 2) for z in range(N) for y in range(N) for x in range(N)]
    cells = []
    for x, y, z in itertools.product(range(N - 1), repeat=3):
        for order in itertools.permutations(range(3)):
            place, cell = [x, y, z], [x + N * y + N * N * z]
            for axis in order:
                place[axis] += 1
                cell.append(place[0] + N * place[1] + N * N * place[2])
            even = order in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
            cells.append(cell if even else [cell[i] for i in (1, 0, 2, 3)])
    return vertices, cells


def parts():
    """Entities of each group, by its name."""
    vertices, cells = cube()
    faces = {tuple(sorted(face)) for cell in cells for face in itertools.combinations(cell, 3)}
    edges = {tuple(sorted(edge)) for cell in cells for edge in itertools.combinations(cell, 2)}

    def on(entities, condition):
        return sorted(e for e in entities if all(condition(*vertices[v]) for v in e))
    return {"wall": on(faces, lambda x, y, z: x == 0), "lid": on(faces, lambda x, y, z: z == 1),
            "middle": on(faces, lambda x, y, z: z == 0.5),
            "edge": on(edges, lambda x, y, z: x == 0 and y == 0),
            "tip": [(len(vertices) - 1,)], "body": [tuple(cell) for cell in cells]}


def write_gmsh(path, flat=()):
    """The cube, with cells beside it that a repair drops."""
    vertices, _ = cube()
    types = {1: 15, 2: 1, 3: 2, 4: 4}
    elements = [(types[len(entity)], NAMES[name][1], entity)
                for name, entities in parts().items() for entity in entities]
    elements += [(4, NAMES["body"][1], cell) for cell in flat]
    with open(path, "w", encoding="ascii") as file:
        file.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{len(NAMES)}\n")
        for name, (dimension, number) in NAMES.items():
            file.write(f'{dimension} {number} "{name}"\n')
        file.write(f"$EndPhysicalNames\n$Nodes\n{len(vertices)}\n")
        for i, vertex in enumerate(vertices):
            file.write(f"{i + 1} {' '.join(map(repr, vertex))}\n")
        file.write(f"$EndNodes\n$Elements\n{len(elements)}\n")
        for i, (type_, number, entity) in enumerate(elements):
            file.write(f"{i + 1} {type_} 2 {number} {number} "
                       f"{' '.join(str(v + 1) for v in entity)}\n")
        file.write("$EndElements\n")


def write_medit(path):
    vertices, _ = cube()
    sections = {"Triangles": ("wall", "lid"), "Edges": ("edge",), "Tetrahedra": ("body",)}
    every = parts()
    with open(path, "w", encoding="ascii") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices {len(vertices)}\n")
        file.writelines(f"{x} {y} {z} 0\n" for x, y, z in vertices)
        for section, names in sections.items():
            rows = [(entity, NAMES[name][1]) for name in names for entity in every[name]]
            file.write(f"{section} {len(rows)}\n")
            file.writelines(f"{' '.join(str(v + 1) for v in entity)} {number}\n"
                            for entity, number in rows)
        file.write("End\n")


class Groups(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.gmsh = os.path.join(cls.folder.name, "cube.msh")
        cls.medit = os.path.join(cls.folder.name, "cube.mesh")
        write_gmsh(cls.gmsh)
        write_medit(cls.medit)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def scene(self, mesh, wall, lid, *options):
        """Held at one side and pulled at the top, each by group or by formula."""
        return ["-mesh_file", mesh, "-constraints", "wall", *wall, "-loads", "lid", *lid,
                "-load_lid_traction", "0, 0, -5e4", *TIGHT, *options]

    BY_FORMULA = (["-constraint_wall_where", "x == 0"], ["-load_lid_where", "z == 1"])

    def test_the_same_as_by_formula(self):
        for options in ([], ["-mesh_refine", "1"], ["-order", "2"]):
            expected = record_of(self.scene(self.gmsh, *self.BY_FORMULA, *options))
            for mesh, wall, lid in ((self.gmsh, "wall", "lid"), (self.gmsh, "7", "surface 8"),
                                    (self.medit, "7", "8")):
                for ranks in (1, 2, 3):
                    with self.subTest(options=options, wall=wall, mesh=mesh[-5:], ranks=ranks):
                        record = record_of(self.scene(
                            mesh, ["-constraint_wall_group", wall], ["-load_lid_group", lid],
                            *options), ranks)
                        self.assertEqual(record["status"], 0, record["printed"])
                        self.assertLess(abs(energy(record) / energy(expected) - 1), 1e-9)
                        for key in ("vertices", "area"):
                            self.assertAlmostEqual(record["constraints"][0][key],
                                                   expected["constraints"][0][key])
                        self.assertEqual(record["loads"][0]["facets"],
                                         expected["loads"][0]["facets"])

    def test_after_a_repair(self):
        """A cell without volume, between the wall and the body, is dropped."""
        flat = os.path.join(self.folder.name, "flat.msh")
        write_gmsh(flat, [(0, 3, 9, 12)])
        for ranks in (1, 2):
            whole, repaired = (record_of(self.scene(
                mesh, ["-constraint_wall_group", "wall"], ["-load_lid_group", "lid"], *options), ranks)
                for mesh, options in ((self.gmsh, []), (flat, ["-mesh_repair", "drop"])))
            self.assertLess(abs(energy(repaired) / energy(whole) - 1), 1e-9)
            self.assertEqual(repaired["loads"][0]["facets"], 8)

    def test_pressure_pushes_inwards(self):
        for mesh, names in ((self.gmsh, ("wall", "lid")), (self.medit, ("7", "8"))):
            for ranks in (1, 2):
                record = record_of(["-mesh_file", mesh, "-constraints", "low", "-constraint_low_where",
                                    "z == 0", "-loads", "a,b", "-load_a_group", names[0],
                                    "-load_b_group", names[1], "-load_a_pressure", "2e3",
                                    "-load_b_pressure", "3e3"], ranks)
                for load, force in zip(record["loads"], ([2e3, 0, 0], [0, 0, -3e3])):
                    for value, expected in zip(load["force"], force):
                        self.assertAlmostEqual(value, expected, delta=1e-9 * 3e3)

    def test_curves_and_points(self):
        """A body that hangs at an edge and a point."""
        by_group, by_formula = (record_of(
            ["-mesh_file", self.gmsh, "-constraints", "edge,tip", *held, "-load_gravity",
             "0, 0, -9.81", "-material_density", "1e3", *TIGHT], ranks) for held, ranks in (
                 (["-constraint_edge_group", "edge", "-constraint_tip_group", "tip"], 2),
                 (["-constraint_edge_where", "x == 0 && y == 0", "-constraint_tip_where",
                   "x + y + z == 3"], 1)))
        self.assertLess(abs(energy(by_group) / energy(by_formula) - 1), 1e-9)
        self.assertEqual([c["vertices"] for c in by_group["constraints"]], [3, 1])

    def test_of_both_what_both_take(self):
        by_both, by_formula = (record_of(self.scene(self.gmsh, wall, lid), 2) for wall, lid in (
            (["-constraint_wall_group", "wall", "-constraint_wall_where", "z < 0.6"],
             ["-load_lid_group", "lid", "-load_lid_where", "x >= 0.5"]),
            (["-constraint_wall_where", "x == 0 && z < 0.6"],
             ["-load_lid_where", "z == 1 && x >= 0.5"])))
        self.assertLess(abs(energy(by_both) / energy(by_formula) - 1), 1e-9)
        self.assertEqual(by_both["loads"][0]["facets"], 4)

    def test_in_a_scene_file(self):
        path = os.path.join(self.folder.name, "scene.yaml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(f"mesh: {{file: {self.gmsh}}}\nconstraints: {{wall: {{group: wall}}}}\n"
                       "loads: {lid: {group: lid, traction: \"0, 0, -5e4\"}}\n"
                       "snes: {trefoil_energy_tolerance: 1e-13}\n")
        expected = energy(record_of(self.scene(self.gmsh, *self.BY_FORMULA)))
        self.assertLess(abs(energy(record_of([path])) / expected - 1), 1e-9)

    def test_refused(self):
        for options, words in (
                (["-load_lid_group", "lidd"], ["-load_lid_group", "'lidd'", "surface 7 'wall'",
                                               "surface 8 'lid'"]),
                (["-load_lid_group", "body"], ["-load_lid_group", "body", "volume"]),
                (["-load_lid_group", "edge"], ["-load_lid_group", "edge", "curve"]),
                (["-load_lid_group", "middle"], ["-load_lid_group", "8 of the facets", "inside"]),
                (["-load_lid_group", "lid", "-load_lid_where", "z < 0.5"],
                 ["'lid'", "no facet", "z < 0.5"]),
                (["-load_lid_group", "lid", "-constraint_wall_group", "wal"],
                 ["-constraint_wall_group", "'wal'", "wall", "edge", "tip"])):
            wall = [] if "-constraint_wall_group" in options else self.BY_FORMULA[0]
            for ranks in (1, 2):
                sentence = refusal_of(self.scene(self.gmsh, wall, options), ranks)
                for word in words:
                    self.assertIn(word, sentence)


if __name__ == "__main__":
    unittest.main(verbosity=2)
