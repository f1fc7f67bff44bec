#!/usr/bin/python3
"""Small strains: every material is linear elasticity there, solved here by numpy on the same mesh,
to strains at which nothing of F but I is left in its digits."""
import itertools
import json
import os
import tempfile
import unittest

import h5py
import numpy

from trefoil_program import record_of, run

MODELS = ("stable_neo_hookean", "neo_hookean", "mooney_rivlin", "arap", "symmetric_dirichlet",
          "corotated", "st_venant_kirchhoff")
YOUNG, POISSON = 1.0, 0.3
STRAINS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
BOX = ["-mesh_generate", "box", "-mesh_resolution", "3", "-material_young", str(YOUNG),
       "-material_poisson", str(POISSON), "-constraints", "wall", "-constraint_wall_where",
       "x == xmin", "-constraint_wall_move", "0, 0, 0"]

SQUARE = ["-mesh_generate", "square", "-constraint_wall_move", "0, 0"]


def sheared(load):
    """A cube clamped at one side, the other sheared by a traction."""
    return BOX + ["-loads", "pull", "-load_pull_where", "x == xmax", "-load_pull_traction",
                  f"0.3*{load}, 0, {load}"]


def result_of(options, ranks=1):
    """The record, the displacements, and the mesh: points and cells."""
    with tempfile.TemporaryDirectory() as folder:
        finished = run([*options, "-output_file", "out.xdmf", "-snes_trefoil_record",
                        "record.json"], ranks, folder)
        assert finished.returncode == 0, finished.stdout
        with open(os.path.join(folder, "record.json"), encoding="utf-8") as file:
            record = json.load(file)
        with h5py.File(os.path.join(folder, "out.h5")) as file:
            return (record, numpy.array(file["vertex_fields/displacement"]),
                    numpy.array(file["points"]), numpy.array(file["cells"]))


def linear_elasticity(points, cells, traction):
    """Displacements of linear tetrahedra, held at x = 0, under a traction at x = 1."""
    mu = YOUNG / (2 * (1 + POISSON))
    lame = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    one = numpy.eye(3)
    hooke = (lame * numpy.einsum("ij,kl->ijkl", one, one)
             + mu * (numpy.einsum("ik,jl->ijkl", one, one) + numpy.einsum("il,jk->ijkl", one, one)))
    size = points.size
    stiffness, force = numpy.zeros((size, size)), numpy.zeros(size)
    for cell in cells:
        edges = points[cell[1:]] - points[cell[0]]
        inner = numpy.linalg.inv(edges).T
        gradients = numpy.vstack([-inner.sum(axis=0), inner])
        block = abs(numpy.linalg.det(edges)) / 6 * numpy.einsum("aj,ijkl,bl->aibk", gradients, hooke,
                                                                gradients)
        dofs = (3 * cell[:, None] + numpy.arange(3)).ravel()
        stiffness[numpy.ix_(dofs, dofs)] += block.reshape(12, 12)
        for face in itertools.combinations(cell, 3):
            corners = points[list(face)]
            if numpy.all(corners[:, 0] > 1 - 1e-12):
                area = numpy.linalg.norm(numpy.cross(corners[1] - corners[0],
                                                     corners[2] - corners[0])) / 2
                for vertex in face:
                    force[3 * vertex:3 * vertex + 3] += area / 3 * numpy.asarray(traction)
    free = numpy.repeat(points[:, 0] > 1e-12, 3)
    u = numpy.zeros(size)
    u[free] = numpy.linalg.solve(stiffness[numpy.ix_(free, free)], force[free])
    return u.reshape(-1, 3), force @ u


class SmallStrains(unittest.TestCase):
    def test_every_model_is_linear_elasticity(self):
        per_strain = 20  # of the difference relative to the strain: the nonlinear part
        for model in MODELS:
            for load in STRAINS:
                with self.subTest(model=model, load=load):
                    record, u, points, cells = result_of(sheared(load) + ["-material_model", model])
                    linear, work = linear_elasticity(points, cells, (0.3, 0, 1))
                    result = record["result"]
                    tolerance = 1e-9 + per_strain * load
                    self.assertLess(abs(u / load - linear).max() / abs(linear).max(), tolerance)
                    self.assertLess(abs(result["load_work"] / load ** 2 / work - 1), tolerance)
                    self.assertLess(abs(2 * result["strain_energy"] / load ** 2 / work - 1),
                                    tolerance)
                    self.assertLessEqual(result["iterations"], 3)
                    self.assertTrue(result["converged"])

    def test_energy_is_its_parts(self):
        """The key `energy` keeps psi(I): strain energy, less the work of the loads, and that."""
        for model, load in (("stable_neo_hookean", 0.05), ("neo_hookean", 0.05),
                            ("stable_neo_hookean", 1e-9)):
            result = record_of(sheared(load) + ["-material_model", model])["result"]
            parts = result["strain_energy"] - result["load_work"] + result["energy_rest"]
            self.assertLess(abs(result["energy"] - parts), 1e-15 * (1 + abs(result["energy"])))
            self.assertGreater(result["strain_energy"], 0)
            self.assertEqual(result["energy_rest"] > 0, model == "stable_neo_hookean")

    def test_both_are_printed(self):
        record = record_of(sheared(1e-9))
        for value, words in ((record["result"]["strain_energy"], "strain energy"),
                             (record["result"]["load_work"], "work of the loads")):
            self.assertIn(f"{words} {value:.10g}", record["printed"])

    def test_other_elements_searches_and_ranks(self):
        """Displacement over load does not depend on the load."""
        def flexibility(options, load, ranks):
            scene = sheared(load) + options
            if options[:2] == SQUARE[:2]:
                scene += ["-load_pull_traction", f"0.3*{load}, {load}"]
            record = record_of(scene, ranks)
            self.assertEqual(record["status"], 0, record["printed"])
            self.assertLessEqual(record["result"]["iterations"], 3)
            return record["result"]["load_work"] / load ** 2
        cases = ((["-order", "2", "-material_model", "neo_hookean"], 1),
                 (["-order", "2", "-material_model", "symmetric_dirichlet"], 1),
                 (SQUARE + ["-material_model", "mooney_rivlin"], 1),
                 (SQUARE + ["-order", "2", "-material_model", "arap"], 1),
                 (["-assembly", "plain", "-material_model", "neo_hookean"], 1),
                 (["-assembly", "hook", "-material_model", "corotated"], 1),
                 (["-snes_trefoil_search", "armijo", "-material_model", "symmetric_dirichlet"], 1),
                 (["-snes_trefoil_filter", "newton", "-material_model", "neo_hookean"], 1),
                 (["-material_model", "neo_hookean", "-material_poisson", "0.49"], 1),
                 (["-material_model", "stable_neo_hookean"], 2),
                 (["-material_model", "symmetric_dirichlet"], 3))
        for options, ranks in cases:
            with self.subTest(options=options):
                one, other = (flexibility(options, load, ranks) for load in (1e-12, 1e-9))
                self.assertLess(abs(one / other - 1), 5e-8)

    def test_a_steel_cube_under_its_own_weight(self):
        steel = ["-material_young", "2.1e11", "-material_density", "7850", "-load_gravity",
                 "0, 0, -9.81"]
        energies = []
        for model in MODELS:
            record = record_of(BOX + steel + ["-material_model", model])
            self.assertEqual(record["status"], 0, record["printed"])
            self.assertLessEqual(record["result"]["iterations"], 3)
            energies.append(record["result"]["strain_energy"])
        for energy in energies:
            self.assertLess(abs(energy / energies[0] - 1), 1e-5)

    def test_small_displacements_that_are_prescribed(self):
        for model in MODELS:
            with self.subTest(model=model):
                scaled = []
                for move in (1e-12, 1e-9):
                    record = record_of(BOX + ["-constraints", "wall,lid", "-constraint_lid_where",
                                              "x == xmax", "-constraint_lid_move",
                                              f"{move}, 0, 2*{move}", "-material_model", model])
                    self.assertEqual(record["status"], 0, record["printed"])
                    self.assertLessEqual(record["result"]["iterations"], 3)
                    scaled.append(record["result"]["strain_energy"] / move ** 2)
                self.assertLess(abs(scaled[0] / scaled[1] - 1), 5e-8)


class NoStrain(unittest.TestCase):
    """Bodies that are moved as a whole: the energy is rounding, and the run knows it."""

    def test_rigid_motions(self):
        moves = {"far": "1e3, -2e3, 5e2", "turned": "(-x - y), x - y, 0",
                 "turned far": "1e2 - x - y, x - y, 0", "nowhere": "0, 0, 0"}
        for (name, move), model in itertools.product(moves.items(), MODELS):
            with self.subTest(move=name, model=model):
                record = record_of(BOX + ["-constraint_wall_move", move, "-material_model", model])
                self.assertEqual(record["status"], 0, record["printed"])
                self.assertLess(record["result"]["strain_energy"], 1e-20)


if __name__ == "__main__":
    unittest.main(verbosity=2)
