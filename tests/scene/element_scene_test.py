#!/usr/bin/python3
"""Whole runs of plane and quadratic scenes: every path, space and number of ranks, what the record
and the fields say of them, second-order meshes of Gmsh, refinement."""
import os
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

from trefoil_program import ROOT, record_of, run

TIGHT = ["-snes_trefoil_energy_tolerance", "1e-13"]
SQUARE = ["-options_file", os.path.join(ROOT, "examples", "square.yaml"), "-mesh_resolution", "12",
          "-output_file", "square.xdmf"]
BOX = ["-mesh_generate", "box", "-mesh_resolution", "2", "-constraints", "low,high",
       "-constraint_low_where", "z == zmin", "-constraint_high_where", "z == zmax",
       "-constraint_high_move", "0.2, 0, 0.7", "-material_poisson", "0.45"]
SLIDING = ["-mesh_generate", "square", "-mesh_resolution", "4", "-constraints", "floor,wall,lid",
           "-constraint_floor_where", "y == ymin", "-constraint_floor_move", "free, 0",
           "-constraint_wall_where", "x == xmin", "-constraint_wall_move", "0, free",
           "-constraint_lid_where", "y == ymax", "-constraint_lid_move", "free, 0.5"]
QUADRATIC = ["-order", "2"]
DEFORMATION = ["-snes_trefoil_space", "deformation"]
SCENES = {"tri3": SQUARE, "tri6": SQUARE + QUADRATIC, "tet10": BOX + QUADRATIC,
          "tet4": BOX, "tri3 in components": SLIDING, "tri6 in components": SLIDING + QUADRATIC}


def energy(record):
    return record["result"]["energy"]


class EveryPath(unittest.TestCase):
    def test_ranks_assemblies_and_spaces(self):
        for name, scene in SCENES.items():
            expected = record_of(scene + TIGHT)
            self.assertEqual(expected["status"], 0, expected["printed"])
            self.assertEqual(expected["mesh"]["element"], name.split()[0])
            for options, ranks in ((["-assembly", "plain"], 1), (["-assembly", "hook"], 2), ([], 2),
                                   ([], 3)):
                with self.subTest(scene=name, options=options, ranks=ranks):
                    record = record_of(scene + TIGHT + options, ranks)
                    self.assertEqual(record["status"], 0, record["printed"])
                    self.assertEqual(record["result"]["iterations"],
                                     expected["result"]["iterations"])
                    self.assertLess(abs(energy(record) / energy(expected) - 1), 1e-9)
            points = record_of(scene + TIGHT + DEFORMATION)
            for options, ranks in ((["-assembly", "plain"], 1), ([], 2)):
                with self.subTest(scene=name, options=options, ranks=ranks, space="deformation"):
                    record = record_of(scene + TIGHT + DEFORMATION + options, ranks)
                    self.assertEqual(record["status"], 0, record["printed"])
                    self.assertEqual(record["result"]["iterations"],
                                     points["result"]["iterations"])
                    self.assertLess(abs(energy(record) / energy(points) - 1), 1e-9)
            self.assertLess(abs(energy(points) / energy(expected) - 1), 1e-9)


class ClosedForm(unittest.TestCase):
    def test_plane_strain_between_sliding_plates(self):
        """F = diag(s, 1.5, 1) with no lateral stress, in elements of either order."""
        young, poisson, long = 1e6, 0.45, 1.5
        mu = young / (2 * (1 + poisson))
        lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson)) + mu
        alpha = 1 + mu / lame
        # P_11 = mu s + lambda (J - alpha) long = 0 with J = s long
        s = lame * alpha * long / (mu + lame * long ** 2)
        expected = (mu / 2 * (s ** 2 + long ** 2 + 1 - 3) + lame / 2 * (s * long - alpha) ** 2)
        for order in "12":
            scene = SLIDING + TIGHT + ["-material_young", str(young), "-order", order,
                                       "-material_poisson", str(poisson)]
            self.assertLess(abs(energy(record_of(scene, 2)) / expected - 1), 1e-10)
            for ranks in (1, 2):
                there = record_of(scene + ["-initial", "expression", "-initial_displacement",
                                           f"{s - 1!r}*x, 0.5*y"], ranks)
                self.assertLess(abs(there["history"][0]["energy"] / expected - 1), 1e-12)
                self.assertEqual(there["result"]["iterations"], 1)


class RecordAndFields(unittest.TestCase):
    def test_counts(self):
        for scene, vertices, nodes, elements, dimension in (
                (SQUARE, 169, 169, 288, 2), (SQUARE + QUADRATIC, 169, 625, 288, 2),
                (BOX + QUADRATIC, 27, 125, 48, 3)):
            mesh = record_of(scene + ["-snes_max_it", "1"])["mesh"]
            self.assertEqual(mesh["vertices"], vertices)
            self.assertEqual(mesh["nodes"], nodes)
            self.assertEqual(mesh["elements"], elements)
            self.assertEqual(mesh["dofs"], dimension * nodes)

    def test_the_square_of_the_example(self):
        mesh = record_of(["-options_file", os.path.join(ROOT, "examples", "square.yaml"),
                          "-output_file", "square.xdmf", "-snes_max_it", "0"])["mesh"]
        self.assertEqual((mesh["vertices"], mesh["elements"]), (10201, 20000))

    def test_xdmf_and_picture(self):
        for scene, shape in ((SQUARE, "Triangle"), (SQUARE + QUADRATIC, "Triangle_6"),
                             (BOX + QUADRATIC + ["-output_file", "square.xdmf"], "Tetrahedron_10")):
            with tempfile.TemporaryDirectory() as folder:
                self.assertEqual(run(scene, 2, folder).returncode, 0)
                path = os.path.join(folder, "square.xdmf")
                topology = xml.etree.ElementTree.parse(path).getroot().find(".//Topology")
                self.assertEqual(topology.get("TopologyType"), shape)
                picture = os.path.join(folder, "square.png")
                subprocess.run(["/usr/bin/python3", os.path.join(ROOT, "examples", "picture.py"),
                                path, "-o", picture, "--field", "energy_density"], check=True)
                self.assertGreater(os.path.getsize(picture), 10000)


def gmsh(path, nodes, type_, cells):
    with open(path, "w", encoding="ascii") as file:
        file.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(nodes)}\n")
        file.writelines(f"{i + 1} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(nodes))
        file.write(f"$EndNodes\n$Elements\n{len(cells)}\n")
        file.writelines(f"{i + 1} {type_} 2 0 1 {' '.join(str(n + 1) for n in cell)}\n"
                        for i, cell in enumerate(cells))
        file.write("$EndElements\n")


class SecondOrderMeshes(unittest.TestCase):
    """Two quadratic triangles with one bent edge, the right one."""
    NODES = [(0., 0., 0.), (1., 0., 0.), (1., 1., 0.), (0., 1., 0.), (.5, 0., 0.), (1.1, .5, 0.),
             (.5, 1., 0.), (0., .5, 0.), (.5, .5, 0.)]
    CELLS = [(0, 1, 2, 4, 5, 8), (0, 2, 3, 8, 6, 7)]
    HELD = ["-constraints", "left,right", "-constraint_left_where", "x == 0",
            "-constraint_right_where", "x > 0.99", "-constraint_right_move", "0.2, 0"]

    def record(self, *options, nodes=None):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bent.msh")
            gmsh(path, nodes or self.NODES, 9, self.CELLS)
            return record_of(["-mesh_file", path, *self.HELD, *options])

    def test_read_as_they_are_or_by_their_corners(self):
        record = self.record()
        self.assertEqual(record["status"], 0, record["printed"])
        self.assertEqual((record["mesh"]["element"], record["mesh"]["nodes"]), ("tri6", 9))
        corners = self.record("-order", "1", "-mesh_refine", "1")
        self.assertEqual((corners["mesh"]["element"], corners["mesh"]["nodes"]), ("tri3", 9))

    def test_refinement(self):
        refused = None
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bent.msh")
            gmsh(path, self.NODES, 9, self.CELLS)
            refused = run(["-mesh_file", path, *self.HELD, "-mesh_refine", "1"])
            self.assertEqual(refused.returncode, 1)
            self.assertIn("-mesh_refine", refused.stdout)
            linear = os.path.join(folder, "linear.msh")
            gmsh(linear, self.NODES[:4], 2, [cell[:3] for cell in self.CELLS])
            for ranks in (1, 2):
                record = record_of(["-mesh_file", linear, *self.HELD, "-order", "2",
                                    "-mesh_refine", "2"], ranks)
                self.assertEqual(record["status"], 0, record["printed"])
                self.assertEqual((record["mesh"]["element"], record["mesh"]["elements"]),
                                 ("tri6", 32))
                self.assertEqual(record["mesh"]["nodes"], 81)

    def test_bent_too_far(self):
        nodes = list(self.NODES)
        nodes[5] = (-1., .5, 0.)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bent.msh")
            gmsh(path, nodes, 9, self.CELLS)
            refused = run(["-mesh_file", path, *self.HELD])
            self.assertEqual(refused.returncode, 1)
            self.assertIn("triangle 1", refused.stdout)
            self.assertIn("Jacobian", refused.stdout)


if __name__ == "__main__":
    unittest.main()
