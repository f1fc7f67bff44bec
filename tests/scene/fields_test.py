#!/usr/bin/python3
"""The fields of an output: stresses and strains of every material against closed forms, by cell and by
vertex, regions kept apart, reactions, and only what is named."""
import cmath
import math
import os
import tempfile
import unittest

try:
    import meshio
    import numpy as np
except ImportError:
    meshio = None

from boxes import SPRING, THREE_PLANES, TIGHT
from trefoil_program import run

YOUNG, POISSON = 1e5, 0.3
MU = YOUNG / (2 * (1 + POISSON))
LAMBDA = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
STRETCHES, ANGLE = (1.25, 0.9, 1.1), 0.6


def squares(l):
    return sum(s * s for s in l)


def volume(l):
    return l[0] * l[1] * l[2]


def stable(l):
    lame = LAMBDA + MU
    return MU / 2 * (squares(l) - 3) + lame / 2 * (volume(l) - 1 - MU / lame) ** 2


def neo(l):
    log = cmath.log(volume(l))
    return MU / 2 * (squares(l) - 3) - MU * log + LAMBDA / 2 * log ** 2


def mooney(l):
    c1 = c2 = MU / 4
    second = sum((l[i] * l[i - 1]) ** 2 for i in range(3))
    return (c1 * (squares(l) - 3) + c2 * (second - 3) - (2 * c1 + 4 * c2) * (volume(l) - 1)
            + (LAMBDA + 2 * c1) / 2 * (volume(l) - 1) ** 2)


def arap(l):
    return MU * sum((s - 1) ** 2 for s in l) + LAMBDA / 2 * (volume(l) - 1) ** 2


def dirichlet(l):
    return (MU / 4 * (squares(l) + sum(1 / s ** 2 for s in l) - 6)
            + LAMBDA / 2 * (volume(l) - 1) ** 2)


def corotated(l):
    return MU * sum((s - 1) ** 2 for s in l) + LAMBDA / 2 * (sum(l) - 3) ** 2


def venant(l):
    return (MU * sum(((s * s - 1) / 2) ** 2 for s in l)
            + LAMBDA / 2 * sum((s * s - 1) / 2 for s in l) ** 2)


#: psi by the principal stretches.
ENERGIES = {"stable_neo_hookean": stable, "neo_hookean": neo, "mooney_rivlin": mooney, "arap": arap,
            "symmetric_dirichlet": dirichlet, "corotated": corotated,
            "st_venant_kirchhoff": venant}
ALL = ("displacement,von_mises,cauchy_stress,first_piola,principal_stretches,principal_stresses,"
       "green_lagrange,determinant_F,energy_density,region,part,rank,reaction")


def upper(A):
    return A[np.triu_indices(3)]


def closed_form(model, stretches):
    """Every field for F = R diag(stretches), R a turn about z."""
    energy = ENERGIES[model]
    slopes = np.array([energy([s + (1e-30j if i == k else 0) for i, s in enumerate(stretches)]).imag
                       / 1e-30 for k in range(3)])  # d psi / d stretch, by complex steps
    c, s = math.cos(ANGLE), math.sin(ANGLE)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    F, P = R @ np.diag(stretches), R @ np.diag(slopes)
    cauchy = P @ F.T / volume(stretches)
    a, b, c = principal = np.sort(slopes * stretches / volume(stretches))[::-1]
    return F, {"first_piola": P.ravel(), "cauchy_stress": upper(cauchy),
               "principal_stresses": principal, "von_mises":
               math.sqrt(((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2) / 2),
               "principal_stretches": np.sort(stretches)[::-1],
               "green_lagrange": upper((F.T @ F - np.eye(3)) / 2),
               "determinant_F": volume(stretches)}


def solve(options, ranks=1, name="run.xdmf"):
    """Point and cell data of a run, and what it printed."""
    with tempfile.TemporaryDirectory() as folder:
        done = run([*options, "-output_file", name], ranks, folder)
        if done.returncode:
            raise AssertionError(done.stdout)
        mesh = meshio.read(os.path.join(folder, name))
        cells = {key: values[0] for key, values in mesh.cell_data.items()}
        return mesh, mesh.point_data, cells, done.stdout


@unittest.skipIf(meshio is None, "python3-meshio is not installed")
class ClosedForms(unittest.TestCase):
    def check(self, model, order, ranks, plane=False):
        stretches = (*STRETCHES[:2], 1) if plane else STRETCHES
        F, expected = closed_form(model, stretches)
        rows = (F - np.eye(3))[:2 if plane else 3]
        move = ", ".join(f"{row[0]!r}*x + {row[1]!r}*y" + ("" if plane else f" + {row[2]!r}*z")
                         for row in rows.tolist())
        sides = " || ".join(f"{axis} == {axis}{end}" for axis in ("xy" if plane else "xyz")
                            for end in ("min", "max"))
        _, points, cells, _ = solve(
            ["-mesh_generate", "square" if plane else "box", "-mesh_resolution", "3", "-order", order,
             "-constraints", "skin", "-constraint_skin_where", sides, "-constraint_skin_move", move,
             "-material_model", model, "-material_young", str(YOUNG), "-material_poisson",
             str(POISSON), *TIGHT, "-output_fields", ALL], ranks)
        self.assertIn("reaction", points)
        for name, value in expected.items():
            size = np.abs(value).max()
            for where in (cells,) if name == "determinant_F" else (cells, points):
                self.assertLess(np.abs(where[name] - value).max() / size, 1e-6, (model, name))

    def test_every_material(self):
        for model in ENERGIES:
            for order, ranks in (("1", 1), ("2", 2)):
                with self.subTest(model=model, order=order):
                    self.check(model, order, ranks)

    def test_in_the_plane(self):
        for order, ranks in (("1", 2), ("2", 1)):
            self.check("neo_hookean", order, ranks, plane=True)


@unittest.skipIf(meshio is None, "python3-meshio is not installed")
class Fields(unittest.TestCase):
    def test_regions_are_not_averaged(self):
        """Two springs side by side: between them the stiffer one's stress, beside it each its own."""
        stretch = 0.2
        scene = [*THREE_PLANES, *TIGHT, *SPRING, "-constraints", "floor,wall,back,lid",
                 "-constraint_lid_where", "z == zmax", "-constraint_lid_move",
                 f"free, free, {stretch}", "-regions", "stiff", "-region_stiff_where", "x > 0.5",
                 "-region_stiff_material_young", "3e6", "-material_young", "1e6"]
        for ranks in (1, 2, 3):
            mesh, points, cells, _ = solve(scene, ranks)
            expected = np.where(mesh.points[:, 0] > 0.49, 3e6, 1e6) * stretch
            self.assertLess(np.abs(points["von_mises"] / expected - 1).max(), 1e-7)
            self.assertEqual(set(cells["region"]), {0, 1})
            self.assertLess(np.abs(cells["von_mises"] / np.where(cells["region"], 3e6, 1e6)
                                   / stretch - 1).max(), 1e-7)

    def test_reactions_hold_the_body(self):
        scene = ["-mesh_generate", "box", "-mesh_resolution", "3", "-constraints", "low",
                 "-constraint_low_where", "z == zmin", "-load_gravity", "0, 1, -9.81",
                 "-material_density", "1e3", *TIGHT, "-output_fields", "reaction"]
        for ranks in (1, 2):
            mesh, points, cells, printed = solve(scene, ranks)
            self.assertEqual((set(points), set(cells)), ({"reaction"}, set()))
            self.assertLess(math.dist(points["reaction"].sum(axis=0), (0, -1000, 9810)), 1e-3)
            self.assertTrue((points["reaction"][mesh.points[:, 2] > 0.01] == 0).all())
            self.assertIn("low: reaction", printed)

    def test_only_what_is_named(self):
        scene = ["-mesh_generate", "box", "-mesh_resolution", "2", "-constraints", "low",
                 "-constraint_low_where", "z == zmin"]
        for name in ALL.split(","):
            _, points, cells, _ = solve([*scene, "-output_fields", name])
            self.assertEqual({*points, *cells}, {name})
        _, points, cells, _ = solve(scene)
        self.assertEqual(set(points), {"displacement", "von_mises"})
        self.assertEqual(set(cells), {"von_mises", "determinant_F", "energy_density",
                                      "negative_eigenvalues", "rank"})

    def test_parts(self):
        """Two cubes that do not touch have a number each."""
        text = "MeshVersionFormatted 2\nDimension 3\nVertices 8\n"
        for shift in (0, 5):
            text += "".join(f"{x + shift} {y} {z} 0\n" for x, y, z in
                            ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))
        text += "Tetrahedra 2\n1 2 3 4 0\n5 6 7 8 0\nEnd\n"
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "two.mesh")
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
            _, _, cells, _ = solve(["-mesh_file", path, "-constraints", "low",
                                    "-constraint_low_where", "z == 0", "-output_fields",
                                    "part,rank"], 2)
        self.assertEqual(sorted(cells["part"]), [0, 1])

    def test_a_series_has_every_load_step(self):
        scene = ["-mesh_generate", "box", "-mesh_resolution", "2", "-constraints", "low,high",
                 "-constraint_low_where", "z == zmin", "-constraint_high_where", "z == zmax",
                 "-constraint_high_move", "0, 0, 0.4", "-load_steps", "4", "-output_file",
                 "run.xdmf"]
        for ranks in (1, 2):
            with tempfile.TemporaryDirectory() as folder:
                self.assertEqual(run(scene, ranks, folder).returncode, 0)
                with meshio.xdmf.TimeSeriesReader(os.path.join(folder, "run.xdmf")) as series:
                    points, _ = series.read_points_cells()
                    self.assertEqual(series.num_steps, 4)
                    for step in range(4):
                        t, data, _ = series.read_data(step)
                        self.assertAlmostEqual(t, (step + 1) / 4)
                        top = data["displacement"][points[:, 2] > 0.99]
                        self.assertTrue(np.allclose(top, (0, 0, 0.4 * t)))


if __name__ == "__main__":
    unittest.main(verbosity=2)
