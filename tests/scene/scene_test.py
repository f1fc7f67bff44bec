#!/usr/bin/python3
"""Whole runs: parallel equals serial, units do not matter, solvers and partitioners of the user's
choice, the record and the fields that a run leaves."""
import math
import os
import re
import subprocess
import tempfile
import unittest

from trefoil_program import ROOT, environment, record_of, run

KNOT = ["-options_file", os.path.join(ROOT, "examples", "knot.yaml"), "-output_file", "knot.xdmf"]
STRETCH = ["-constraints", "low,high", "-constraint_low_where", "z < zmin + 0.01",
           "-constraint_high_where", "z > zmax - 0.01"]
BOX = ["-mesh_generate", "box", "-mesh_resolution", "4", *STRETCH,
       "-constraint_high_move", "0, 0, 0.7", "-material_poisson", "0.45"]
CYLINDER = ["-mesh_generate", "cylinder", "-mesh_resolution", "2", *STRETCH,
            "-constraint_high_move", "-0.8*y, 0.8*x - 0.2*y, -0.6", "-material_poisson", "0.4"]
SLIDING = ["-mesh_generate", "box", "-mesh_resolution", "4",
           "-constraints", "floor,wall,back,lid",
           "-constraint_floor_where", "z == zmin", "-constraint_floor_move", "free, free, 0",
           "-constraint_wall_where", "x == xmin", "-constraint_wall_move", "0, free, free",
           "-constraint_back_where", "y == ymin", "-constraint_back_move", "free, 0, free",
           "-constraint_lid_where", "z == zmax", "-constraint_lid_move", "free, free, 0.5"]
TIGHT = ["-snes_trefoil_energy_tolerance", "1e-13"]


def energy(record):
    return record["result"]["energy"]


class ParallelEqualsSerial(unittest.TestCase):
    def check(self, scene):
        serial = record_of(scene + TIGHT)
        self.assertEqual(serial["status"], 0)
        for ranks in (2, 3):
            parallel = record_of(scene + TIGHT, ranks)
            self.assertEqual(parallel["status"], 0)
            self.assertEqual(parallel["solver"]["ranks"], ranks)
            self.assertEqual(parallel["mesh"]["free_dofs"], serial["mesh"]["free_dofs"])
            self.assertLess(abs(energy(parallel) / energy(serial) - 1), 1e-9)
            self.assertEqual(parallel["result"]["iterations"], serial["result"]["iterations"])
            self.assertGreater(parallel["mesh"]["edge_cut"], 0)
            self.assertLess(parallel["mesh"]["imbalance"], 1.2)

    def test_box(self):
        self.check(BOX)

    def test_twisted_and_crushed_cylinder(self):
        self.check(CYLINDER)

    def test_held_in_single_components(self):
        self.check(SLIDING)

    def test_knot(self):
        self.check(KNOT)

    def test_ptscotch(self):
        serial, parallel = record_of(BOX + TIGHT), record_of(
            BOX + TIGHT + ["-mesh_partitioner", "ptscotch"], 3)
        self.assertLess(abs(energy(parallel) / energy(serial) - 1), 1e-9)


class ClosedForm(unittest.TestCase):
    def test_uniaxial_stretch_between_sliding_plates(self):
        """Homogeneous stretch of a unit cube: F = diag(s, s, 1.5) with no lateral stress."""
        young, poisson = 1e6, 0.45
        record = record_of(SLIDING + TIGHT + ["-material_young", str(young),
                                              "-material_poisson", str(poisson)], 2)
        mu = young / (2 * (1 + poisson))
        lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson)) + mu
        alpha, long = 1 + mu / lame, 1.5
        # P_11 = mu s + lambda (J - alpha) s long = 0  gives  J = s^2 long = alpha - mu/(lambda long)
        volume = alpha - mu / (lame * long)
        expected = (mu / 2 * (2 * volume / long + long ** 2 - 3)
                    + lame / 2 * (volume - alpha) ** 2)
        self.assertLess(abs(energy(record) / expected - 1), 1e-10)


class UnitsDoNotMatter(unittest.TestCase):
    def scaled_box(self, folder, length):
        """A box of 3x3x3 cells in another unit of length, as a Medit file."""
        corners, path = range(4), os.path.join(folder, "box.mesh")
        vertices = [(x, y, z) for x in corners for y in corners for z in corners]
        number = {v: i + 1 for i, v in enumerate(vertices)}
        tetrahedra = []
        for x, y, z in ((a, b, c) for a in range(3) for b in range(3) for c in range(3)):
            for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
                point, tetrahedron = [x, y, z], [number[(x, y, z)]]
                for axis in order:
                    point[axis] += 1
                    tetrahedron.append(number[tuple(point)])
                even = order in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
                tetrahedra.append(tetrahedron if even else
                                  [tetrahedron[i] for i in (1, 0, 2, 3)])
        with open(path, "w", encoding="ascii") as file:
            file.write(f"MeshVersionFormatted 1\nDimension 3\nVertices\n{len(vertices)}\n")
            file.writelines(f"{length * x / 3!r} {length * y / 3!r} {length * z / 3!r} 0\n"
                            for x, y, z in vertices)
            file.write(f"Tetrahedra\n{len(tetrahedra)}\n")
            file.writelines(" ".join(map(str, t)) + " 0\n" for t in tetrahedra)
            file.write("End\n")
        return path

    def test_same_iterations_in_any_unit(self):
        expected = None
        for length in (1e-3, 1.0, 1e3):
            for young in (1.0, 1e6, 1e12):
                with tempfile.TemporaryDirectory() as folder:
                    record = record_of(
                        ["-mesh_file", self.scaled_box(folder, length), "-material_young",
                         str(young), "-material_poisson", "0.49", "-constraints", "low,high",
                         "-constraint_low_where", "z < zmin + 0.01*(zmax - zmin)",
                         "-constraint_high_where", "z > zmax - 0.01*(zmax - zmin)",
                         "-constraint_high_move", "0, 0, 1.5*(zmax - zmin)"])
                counts = (record["status"], record["result"]["iterations"],
                          record["result"]["line_search_trials"])
                scaled = energy(record) / (young * length ** 3)
                if expected is None:
                    expected = counts, scaled
                self.assertEqual(counts, expected[0], (length, young))
                self.assertLess(abs(scaled / expected[1] - 1), 1e-9)


class UsersSolvers(unittest.TestCase):
    def test_all_reach_the_same_energy(self):
        reference = energy(record_of(BOX + TIGHT))
        for options in ("-pc_type gamg", "-pc_type hypre", "-ksp_type cg -pc_type bjacobi",
                        "-pc_type lu -ksp_type preonly", "-snes_type newtonls -snes_linesearch_type "
                        "trefoil -snes_stol 0 -snes_max_it 200", "-snes_trefoil_filter clamp",
                        "-snes_trefoil_filter absolute",
                        "-snes_trefoil_filter constant -snes_trefoil_weight 0.7"):
            for ranks in (1, 2):
                if "-pc_type lu" in options and ranks == 2:
                    options += " -pc_factor_mat_solver_type mumps"
                with self.subTest(options=options, ranks=ranks):
                    record = record_of(BOX + TIGHT + options.split(), ranks)
                    self.assertEqual(record["status"], 0, record["printed"])
                    self.assertLess(abs(energy(record) / reference - 1), 1e-9)

    def test_every_assembly_is_the_same(self):
        """In batches, element by element, and through the watch on the Mat."""
        for scene in (KNOT, CYLINDER, SLIDING):
            expected = record_of(scene)
            for assembly in ("plain", "hook"):
                for ranks in (1, 2):
                    with self.subTest(scene=scene[1], assembly=assembly, ranks=ranks):
                        record = record_of(scene + ["-assembly", assembly], ranks)
                        self.assertEqual(record["status"], 0, record["printed"])
                        self.assertEqual(record["result"]["iterations"],
                                         expected["result"]["iterations"])
                        self.assertLess(abs(energy(record) / energy(expected) - 1), 1e-12)
                        self.assertEqual(record["history"][0]["indefinite"],
                                         expected["history"][0]["indefinite"])

    def test_plain_newton_says_indefinite_and_does_not_ascend(self):
        for ranks in (1, 2):
            record = record_of(BOX + ["-snes_trefoil_filter", "newton"], ranks)
            self.assertEqual(record["status"], 3)
            self.assertIn("indefinite", record["result"]["reason"])
            self.assertLessEqual(energy(record), record["result"]["energy_start"])

    def test_plain_newton_where_nothing_is_indefinite(self):
        options = BOX + ["-constraint_high_move", "0, 0, 1e-4", "-initial", "rest",
                         "-material_poisson", "0.2"]
        for ranks in (1, 2):
            record = record_of(options + ["-snes_trefoil_filter", "newton"], ranks)
            self.assertEqual(record["status"], 0, record["printed"])

    def test_petsc_tolerances(self):
        record = record_of(BOX + ["-snes_trefoil_energy_tolerance", "0", "-snes_rtol", "1e-4"])
        self.assertEqual(record["status"], 0)
        self.assertIn("FNORM_RELATIVE", record["result"]["reason"])
        record = record_of(BOX + ["-snes_max_it", "2"])
        self.assertEqual(record["status"], 3)
        self.assertFalse(record["result"]["converged"])
        self.assertEqual(record["result"]["iterations"], 2)

    def test_log_view_and_view(self):
        printed = run(BOX + ["-log_view", "-snes_view"]).stdout
        for word in ("TrefoilFilter", "TrefoilAssembly", "TrefoilSearch",
                     "snes_trefoil_filter: adaptive"):
            self.assertTrue(word in printed, word)

    def test_help_names_every_option(self):
        words = ("-mesh_file", "-material_young", "-output_file", "-snes_trefoil_filter",
                 "-snes_trefoil_energy_tolerance", "-snes_linesearch_shrink", "-pc_type")
        for scene, words in (([], words), (BOX, (*words, "-constraint_NAME_where"))):
            helped = run([*scene, "-help"])
            self.assertEqual(helped.returncode, 0)
            self.assertNotIn("converged in", helped.stdout)
            for word in words:
                self.assertIn(word, helped.stdout)
            # The defaults are those of a solve, which says what it does.
            self.assertIn("-snes_trefoil_search <now subspace", helped.stdout)


class Record(unittest.TestCase):
    def test_keys_and_sums(self):
        record = record_of(KNOT, 2)
        result, time, history = record["result"], record["time"], record["history"]
        self.assertEqual(set(time), {"total", "read", "setup", "guess", "assembly", "filter",
                                     "linear_solve", "line_search", "output", "other"})
        self.assertAlmostEqual(sum(time.values()) - time["total"], time["total"],
                               delta=1e-6 * time["total"])
        self.assertTrue(all(seconds >= 0 for seconds in time.values()), time)
        self.assertEqual(record["schema"], 1)
        self.assertEqual(record["mesh"]["elements"], 4752)
        self.assertEqual(record["mesh"]["dofs"], 3 * record["mesh"]["vertices"])
        self.assertEqual(record["solver"]["options"]["material_poisson"], "0.45")
        for key in ("peak_bytes", "mesh_bytes", "matrix_bytes", "factor_bytes"):
            self.assertGreater(record["memory"][key], 0, key)
        self.assertEqual(len(history), result["iterations"])
        self.assertEqual([entry["k"] for entry in history], list(range(len(history))))
        self.assertEqual(sum(entry["trials"] for entry in history), result["line_search_trials"])
        self.assertEqual((history[-1]["step"], history[-1]["trials"], history[-1]["rho"]),
                         (0, 0, None))
        energies = [entry["energy"] for entry in history]
        self.assertEqual(energies, sorted(energies, reverse=True))
        self.assertEqual(energies[0], result["energy_start"])
        self.assertEqual(energies[-1], result["energy"])
        seconds = [entry["seconds"] for entry in history]
        self.assertEqual(seconds, sorted(seconds))
        # At rest psi(I) V = mu^2/(2 lambda) V; the scale is free of that offset.
        self.assertLess(result["energy_rest"], result["energy"])
        self.assertTrue(math.isclose(result["energy"] - result["energy_rest"],
                                     result["energy_scale"], rel_tol=0.05))


class Output(unittest.TestCase):
    def test_fields_and_pictures(self):
        try:
            import meshio
        except ImportError:
            self.skipTest("python3-meshio is not installed")
        with tempfile.TemporaryDirectory() as folder:
            finished = run(KNOT + ["-snes_trefoil_record", "knot.json"], 2, folder)
            self.assertEqual(finished.returncode, 0, finished.stdout)
            self.assertEqual(sorted(os.listdir(folder)), ["knot.h5", "knot.json", "knot.xdmf"])
            mesh = meshio.read(os.path.join(folder, "knot.xdmf"))
            self.assertEqual(mesh.points.shape[1], 3)
            displacement = mesh.point_data["displacement"]
            self.assertEqual(displacement.shape, mesh.points.shape)
            right = mesh.points[:, 0] > mesh.points[:, 0].max() - 0.8
            self.assertTrue(abs(displacement[right, 0] - 4).max() < 1e-12)
            cells = {name: values[0] for name, values in mesh.cell_data.items()}
            self.assertEqual(set(cells), {"von_mises", "determinant_F", "energy_density",
                                          "negative_eigenvalues", "rank"})
            self.assertTrue((cells["determinant_F"] > 0).all())
            self.assertEqual(set(cells["rank"]), {0, 1})
            self.assertTrue(cells["negative_eigenvalues"].max() > 0)
            for script, source in (("picture.py", "knot.xdmf"),
                                   ("plot_convergence.py", "knot.json")):
                picture = os.path.join(folder, script + ".png")
                subprocess.run(["/usr/bin/python3", os.path.join(ROOT, "examples", script),
                                os.path.join(folder, source), "-o", picture], check=True)
                self.assertGreater(os.path.getsize(picture), 10000)

    def test_progress_lines(self):
        printed = run(BOX).stdout
        self.assertRegex(printed, r"mesh: generated box, 125 vertices, 384 tetrahedra")
        self.assertEqual(len(re.findall(r"^ +\d+ +-?\d\.\d{14}e", printed, re.M)),
                         int(re.search(r"converged in (\d+) iterations", printed)[1]))


if __name__ == "__main__":
    os.environ.update(environment())
    unittest.main(verbosity=2)
