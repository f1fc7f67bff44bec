"""examples/python/trefoil.py: scenes run from Python, what they leave, and what is raised."""
import os
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(HERE, "..", "..", "examples")
sys.path.insert(0, os.path.join(EXAMPLES, "python"))

import numpy as np

import body_series
import trefoil

BLOCK = {"mesh": {"generate": "box", "resolution": 2},
         "material": {"model": "arap", "young": np.float64(1e3), "poisson": 0.3},
         "constraints": {"floor": {"where": "z == zmin", "move": "0, 0, 0"},
                         "top": {"where": "z == zmax", "move": "0, 0, 0.2"}}}
TEXT = """
mesh: {generate: box, resolution: 2}
material: {model: arap, young: 1e3, poisson: 0.3}
constraints: floor,top
constraint:
  floor: {where: "z == zmin", move: "0, 0, 0"}
  top: {where: "z == zmax", move: "0, 0, 0.2"}
"""


class Run(unittest.TestCase):
    def test_a_dictionary_a_text_and_a_path_are_the_same_scene(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "block.yaml")
            with open(path, "w", encoding="utf-8") as file:
                file.write(TEXT)
            results = [trefoil.run(scene, 1) for scene in (BLOCK, TEXT, path)]
        for result in results:
            self.assertTrue(result.converged)
            self.assertEqual(result.record["result"]["energy"], results[0].record["result"]["energy"])

    def test_fields_are_those_of_the_file(self):
        result = trefoil.run(BLOCK, ranks=2)
        displacement = result.fields["displacement"]
        self.assertEqual(displacement.shape, result.points.shape)
        self.assertEqual(result.points[result.cells].shape[1:], (4, 3))
        top = result.points[:, 2] == result.points[:, 2].max()
        np.testing.assert_allclose(displacement[top], [[0, 0, 0.2]] * top.sum(), atol=1e-15)
        self.assertTrue(result.fields.on_vertices("displacement"))
        self.assertFalse(result.fields.on_vertices("determinant_F"))
        self.assertEqual(len(result.fields["determinant_F"]), len(result.cells))
        self.assertEqual(result.record["solver"]["ranks"], 2)

    def test_options_win_over_the_scene(self):
        result = trefoil.run(BLOCK, 1, material_young=2e3, order=2, snes_trefoil_verify_minimum=False)
        self.assertEqual(result.record["solver"]["options"]["material_young"], "2000.0")
        self.assertEqual(result.cells.shape[1], 10)

    def test_what_is_refused_is_raised_as_one_sentence(self):
        with self.assertRaises(trefoil.TrefoilError) as refused:
            trefoil.run({"mesh": {"generate": "bax"}}, 2)
        self.assertRegex(str(refused.exception), r"^-mesh_generate knows no 'bax'")
        self.assertNotIn("\n", str(refused.exception))
        self.assertRaisesRegex(FileNotFoundError, "there is no scene nowhere.yaml", trefoil.run, "nowhere.yaml")

    def test_no_equilibrium_is_raised_with_the_state(self):
        with self.assertRaises(trefoil.NotConverged) as ended:
            trefoil.run(BLOCK, 1, initial="rest", snes_max_it=1)
        self.assertFalse(ended.exception.result.converged)
        self.assertEqual(ended.exception.result.fields["displacement"].shape[1], 3)

    def test_files_stay_where_they_are_asked_for_and_nowhere_else(self):
        with tempfile.TemporaryDirectory() as folder:
            before = os.getcwd()
            os.chdir(folder)
            try:
                trefoil.run(BLOCK, 1)
                self.assertEqual(os.listdir(folder), [])
                trefoil.run(BLOCK, 1, folder="kept")
            finally:
                os.chdir(before)
            self.assertEqual(sorted(os.listdir(os.path.join(folder, "kept"))),
                             ["fields.h5", "fields.xdmf", "record.json", "scene.yaml"])


class Series(unittest.TestCase):
    def test_steps_of_a_series(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bar.xdmf")
            body_series.bent_bar(path, 4, 2)
            steps = trefoil.read_steps(path)
            self.assertEqual([step.t for step in steps], [0.25, 0.5, 0.75, 1.0])
            for step in steps:
                np.testing.assert_allclose(step.fields["reaction"], step.t * step.points)
            self.assertEqual(steps[0].fields["cauchy_stress"].shape, (len(steps[0].cells), 6))

    def test_a_field_on_vertices_and_on_cells(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "bar.xdmf")
            body_series.bent_bar(path, 1, 1)
            step = trefoil.read_steps(path)[0]
            self.assertEqual(len(step.vertex_fields["von_mises"]), len(step.points))
            self.assertEqual(len(step.cell_fields["von_mises"]), len(step.cells))
            self.assertTrue(step.fields.on_vertices("von_mises"))
            self.assertEqual(len(step.fields["von_mises"]), len(step.points))
            self.assertFalse(step.fields.on_vertices("region"))

    def test_files_that_are_no_result(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "empty.xdmf")
            with open(path, "w", encoding="utf-8") as file:
                file.write("<Xdmf><Domain/></Xdmf>")
            self.assertRaisesRegex(ValueError, "no Domain with a Grid", trefoil.read_steps, path)


if __name__ == "__main__":
    unittest.main()
