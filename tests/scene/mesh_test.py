"""Meshes as meshers write them: cells written twice, groups of every kind, parts that only touch,
other formats. What is taken otherwise than it stands in the file is said."""
import os
import re
import tempfile
import unittest

from trefoil_program import record_of, run

KUHN = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]
ENDS = ["-constraints", "low,top", "-constraint_low_where", "z == zmin", "-constraint_top_where",
        "z == zmax", "-constraint_top_move", "0, 0, 0.3"]
LOADED = ["-constraints", "low", "-constraint_low_where", "z == zmin", "-loads", "top",
          "-load_top_where", "z == zmax", "-load_top_traction", "0, 0, 1e4"]
PLANE_ENDS = ["-constraints", "low,top", "-constraint_low_where", "y == ymin",
              "-constraint_top_where", "y == ymax", "-constraint_top_move", "0, 0.3"]
STIFF = ["-regions", "r", "-region_r_material_young", "1e7", "-region_r_group"]


def box(n, shift=0.0):
    """Points of the unit cube, n cells along an edge, and its tetrahedra by numbers from 1."""
    number = lambda x, y, z: 1 + x + (n + 1) * (y + (n + 1) * z)
    axis = range(n + 1)
    points = [(x / n, y / n, z / n + shift) for z in axis for y in axis for x in axis]
    cells = []
    for z in range(n):
        for y in range(n):
            for x in range(n):
                for order in KUHN:
                    corner, cell = [x, y, z], [number(x, y, z)]
                    for along in order:
                        corner[along] += 1
                        cell.append(number(*corner))
                    if order in KUHN[3:]:
                        cell[1], cell[2] = cell[2], cell[1]
                    cells.append(cell)
    return points, cells


def gmsh(points, elements, names=()):
    """MSH 2.2. Elements: type, physical group, nodes. Names: dimension, number, name."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names)),
             *(f'{dimension} {number} "{name}"' for dimension, number, name in names),
             "$EndPhysicalNames", "$Nodes", str(len(points)),
             *(f"{k} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(points, 1)), "$EndNodes",
             "$Elements", str(len(elements)),
             *(f"{k} {kind} 2 {group} 1 {' '.join(map(str, nodes))}"
               for k, (kind, group, nodes) in enumerate(elements, 1)), "$EndElements", ""]
    return "\n".join(lines)


def medit(points, cells, references):
    return "\n".join(["MeshVersionFormatted 2", "Dimension 3", f"Vertices {len(points)}",
                      *(f"{x!r} {y!r} {z!r} 0" for x, y, z in points), f"Tetrahedra {len(cells)}",
                      *(f"{' '.join(map(str, cell))} {reference}"
                        for cell, reference in zip(cells, references)), "End", ""])


class Meshes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.points, self.cells = box(2)

    def file(self, text, name="body.msh"):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        return ["-mesh_file", path]

    def same_energy(self, options, expected, ranks=1):
        record = record_of(options, ranks)
        self.assertLess(abs(record["result"]["energy"] / expected - 1), 1e-7, record["printed"])
        return record

    def energy(self, options):
        return record_of(options)["result"]["energy"]

    def refused(self, options, *words):
        for ranks in (1, 2):
            done = run(options, ranks)
            self.assertEqual(done.returncode, 1, done.stdout)
            sentence = re.search("^trefoil: .*", done.stdout, re.M).group()
            for word in words:
                self.assertIn(word, sentence)

    def test_cells_written_twice_count_once(self):
        once = self.file(gmsh(self.points, [(4, 1, cell) for cell in self.cells]), "once.msh")
        pulled, loaded = self.energy(once + ENDS), self.energy(once + LOADED)
        upper = self.cells[24:]
        turned = [[cell[k] for k in (1, 2, 0, 3)] for cell in self.cells[-2:]]
        for name, copies in (("group", upper), ("two", self.cells[-2:]), ("turned", turned)):
            elements = [(4, 1, cell) for cell in self.cells] + [(4, 2, cell) for cell in copies]
            twice = self.file(gmsh(self.points, elements, [(3, 1, "all"), (3, 2, "upper")]),
                              name + ".msh")
            for ranks in (1, 2):
                record = self.same_energy(twice + ENDS, pulled, ranks)
                self.assertEqual(record["mesh"]["elements"], 48)
                self.assertIn(f"took {len(copies)} tetrahedra once", record["printed"])
            self.same_energy(twice + LOADED, loaded)
        # A copy is in the groups of both.
        everywhere, above = self.energy(twice + ENDS + STIFF + ["all"]), None
        self.assertLess(abs(everywhere / pulled / 10 - 1), 1e-3)  # ten times as stiff
        group = ["-mesh_file", os.path.join(self.folder, "group.msh")]
        above = self.energy(group + ENDS + STIFF + ["upper"])
        where = STIFF[:-1] + ["-region_r_where", "z > 0.5"]
        self.same_energy(once + ENDS + where, above)

    def test_plane_cells_written_twice_count_once_either_way_round(self):
        points = [(x, y, 0.0) for y in (0, 1, 2) for x in (0, 1, 2)]
        cells = []
        for a in (1, 2, 4, 5):
            cells += [[a, a + 1, a + 4], [a, a + 4, a + 3]]
        once = self.file(gmsh(points, [(2, 1, cell) for cell in cells]), "once.msh")
        expected = self.energy(once + PLANE_ENDS)
        twice = self.file(gmsh(points, [(2, 1, cell) for cell in cells]
                               + [(2, 2, cell[::-1]) for cell in cells[:3]]))
        self.same_energy(twice + PLANE_ENDS, expected, 2)
        self.same_energy(twice + PLANE_ENDS + ["-order", "2"],
                         self.energy(once + PLANE_ENDS + ["-order", "2"]))

    def test_the_same_cell_both_ways_round_is_refused_by_name(self):
        cell = self.cells[7]
        elements = [(4, 1, c) for c in self.cells] + [(4, 2, [cell[k] for k in (1, 0, 2, 3)])]
        self.refused(self.file(gmsh(self.points, elements)) + ENDS, "tetrahedron 49",
                     "tetrahedron 8", "turned round")

    def test_an_entity_of_several_groups_is_in_all(self):
        text = (gmsh([], []).split("$PhysicalNames")[0].replace("2.2", "4.1") +
                '$PhysicalNames\n2\n3 1 "body"\n3 7 "soft part"\n$EndPhysicalNames\n'
                "$Entities\n0 0 0 1\n1 0 0 0 1 1 1 2 7 1 0\n$EndEntities\n"
                f"$Nodes\n1 27 1 27\n3 1 0 27\n{chr(10).join(map(str, range(1, 28)))}\n"
                + "\n".join(f"{x!r} {y!r} {z!r}" for x, y, z in self.points) + "\n$EndNodes\n"
                "$Elements\n1 48 1 48\n3 1 4 48\n"
                + "\n".join(f"{k} {' '.join(map(str, cell))}"
                            for k, cell in enumerate(self.cells, 1)) + "\n$EndElements\n")
        whole = self.file(text)
        expected = 10 * self.energy(whole + ENDS)
        for group in ("soft part", "body", "7", "1"):
            record = self.same_energy(whole + ENDS + STIFF + [group], expected)
        self.assertTrue(record["result"]["converged"])
        entities = "$EndEntities\n$PartitionedEntities\n2\n0\n0 0 0 1\n" \
                   "9 3 1 1 2 0 0 0 1 1 1 1 7 0\n$EndPartitionedEntities\n"
        partitioned = text.replace("$EndEntities\n", entities).replace("3 1 4 48", "3 9 4 48")
        parts = self.file(partitioned, "parts.msh")
        for ranks in (1, 2):
            self.same_energy(parts + ENDS + STIFF + ["soft part"], expected, ranks)

    def test_references_of_medit_choose_regions(self):
        middle = [sum(self.points[v - 1][2] for v in cell) / 4 for cell in self.cells]
        references = [3 if z > 0.5 else 0 for z in middle]
        body = self.file(medit(self.points, self.cells, references), "body.mesh")
        expected = self.energy(body + ENDS + STIFF[:-1] + ["-region_r_where", "z > 0.5"])
        for ranks, refine in ((1, 0), (2, 0)):
            self.same_energy(body + ENDS + STIFF + ["3", "-mesh_refine", str(refine)], expected,
                             ranks)
        self.refused(body + ENDS + STIFF + ["4"], "-region_r_group", "'4'", "volume 0", "volume 3")

    def test_parts_that_only_touch_are_counted(self):
        above, _ = box(2, 1.0)
        cells = self.cells + [[vertex + 27 for vertex in cell] for cell in self.cells]
        unglued = self.file(gmsh(self.points + above, [(4, 1, cell) for cell in cells]))
        for ranks in (1, 2, 3):
            record = record_of(unglued + ENDS, ranks)
            self.assertEqual(record["mesh"]["parts"], 2)
            line = re.search("^mesh: .*vertices.*", record["printed"], re.M).group()
            self.assertIn("2 unconnected parts (9 vertices coincide)", line)
        whole = self.file(gmsh(self.points, [(4, 1, cell) for cell in self.cells]))
        record = record_of(whole + ENDS)
        self.assertEqual(record["mesh"]["parts"], 1)
        self.assertNotIn("part", record["printed"])

    def test_a_slit_in_one_part_is_seen(self):
        # The two halves share the vertices of one edge of the face between them, and no others.
        above, _ = box(2, 1.0)
        shared = {28: 19, 29: 20, 30: 21}
        cells = self.cells + [[shared.get(v + 27, v + 27) for v in cell] for cell in self.cells]
        slit = self.file(gmsh(self.points + above, [(4, 1, cell) for cell in cells]))
        line = re.search("^mesh: .*", run(slit + ENDS).stdout.split("uses\n")[-1], re.M).group()
        self.assertIn("(6 vertices coincide)", line)
        self.assertNotIn("parts", line)

    def test_meshes_the_other_way_round_are_turned(self):
        right = self.file(gmsh(self.points, [(4, 1, cell) for cell in self.cells]))
        expected = self.energy(right + ENDS)
        turned = self.file(gmsh(self.points, [(4, 1, [cell[k] for k in (1, 0, 2, 3)])
                                                  for cell in self.cells]), "t.msh")
        for ranks in (1, 2):
            record = self.same_energy(turned + ENDS, expected, ranks)
            self.assertIn("turned all 48 tetrahedra round", record["printed"])

    def test_holes_of_repair_are_said(self):
        points, cells = box(3)
        bad = cells[80]
        bad[0], bad[1] = bad[1], bad[0]
        hole = self.file(gmsh(points, [(4, 1, cell) for cell in cells])) + ENDS
        self.refused(hole, "tetrahedron 81")
        for ranks in (1, 2):
            record = record_of(hole + ["-mesh_repair", "drop"], ranks)
            self.assertIn("dropped 1 tetrahedron without positive volume, which leaves holes: 4 "
                          "triangles inside of the body are surface now", record["printed"])

    def test_quadrilaterals_beside_triangles_are_refused(self):
        points = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0),
                  (2.0, 0.0, 0.0), (2.0, 1.0, 0.0)]
        elements = [(3, 1, (2, 5, 6, 3)), (2, 1, (1, 2, 3)), (2, 1, (1, 3, 4))]
        self.refused(self.file(gmsh(points, elements)) + PLANE_ENDS, "quadrilateral")
        plane = "\n".join(["MeshVersionFormatted 2", "Dimension 2", "Vertices 6",
                           *(f"{x} {y} 0" for x, y, _ in points), "Triangles 2", "1 2 3 0",
                           "1 3 4 0", "Quadrilaterals 1", "2 5 6 3 0", "End", ""])
        self.refused(self.file(plane, "plane.mesh") + PLANE_ENDS, "Quadrilaterals")

    def test_other_formats_are_named_with_the_way_to_convert_them(self):
        self.refused(self.file("BEGIN BULK\nGRID,1,,0.,0.,0.\nENDDATA\n", "plate.bdf") + ENDS,
                     "plate.bdf", "Nastran", "meshio convert plate.bdf plate.msh", "gmsh", "-save")
        self.refused(self.file("$ Created by hand\n1 1 1\n", "comment.bdf") + ENDS, "Nastran")
        self.refused(self.file("# vtk DataFile Version 3.0\n", "a.vtk") + ENDS, "meshio convert")

    def test_wrong_order_of_second_order_nodes_is_refused(self):
        points = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
        edges = [(0, 1), (1, 2), (2, 0), (0, 3), (2, 3), (1, 3)]  # as Gmsh has them
        for order, words in ((edges, None), (edges[:4] + edges[:3:-1], ["node 9", "Gmsh"])):
            nodes = points + [tuple((points[a][k] + points[b][k]) / 2 for k in range(3))
                              for a, b in order]
            body = self.file(gmsh(nodes, [(11, 1, range(1, 11))]))
            if words:
                done = run(body + ENDS)
                self.assertEqual(done.returncode, 1, done.stdout)
                for word in words:
                    self.assertIn(word, done.stdout)
            else:
                self.assertTrue(record_of(body + ENDS)["result"]["converged"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
