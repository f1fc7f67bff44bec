#!/usr/bin/python3
"""Meshes in HDF5, which all ranks read together: the same as the file they were made of, with its
groups, its order and its curved cells; damaged and foreign ones are refused."""
import itertools
import os
import random
import shutil
import tempfile
import unittest

import h5py
import numpy as np

from boxes import TIGHT, energy
from group_test import write_gmsh
from trefoil_program import peaks_of, record_of, run

HELD = ["-constraints", "wall,edge,tip", "-constraint_wall_group", "wall", "-constraint_edge_group",
        "edge", "-constraint_tip_group", "tip", "-loads", "lid", "-load_lid_group", "surface 8",
        "-load_lid_traction", "0, 0, -5e4", "-regions", "r", "-region_r_group", "body",
        "-region_r_material_young", "2e6", *TIGHT]
BY_FORMULA = ["-constraints", "wall", "-constraint_wall_where", "x == xmin", "-loads", "lid",
              "-load_lid_where", "x == xmax", "-load_lid_traction", "0, 0, -5e3", *TIGHT]


def write_cube(path, across):
    """A cube of 6 across^3 tetrahedra, in Medit's format."""
    n = across + 1
    index = np.arange(n ** 3).reshape(n, n, n)
    corner = index[:-1, :-1, :-1].ravel()
    steps = (1, n, n * n)
    cells = []
    for turn, order in enumerate(itertools.permutations(steps)):
        walk = [corner, corner + order[0], corner + order[0] + order[1], corner + sum(steps)]
        odd = turn in (1, 2, 5)
        cells.append(np.stack([walk[0], walk[2 if odd else 1], walk[1 if odd else 2], walk[3]], 1))
    cells = np.concatenate(cells) + 1
    points = np.indices((n, n, n)).reshape(3, -1).T / across
    with open(path, "w", encoding="ascii") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices {len(points)}\n")
        np.savetxt(file, np.column_stack([points, np.zeros(len(points))]), "%.17g %.17g %.17g %d")
        file.write(f"Tetrahedra {len(cells)}\n")
        np.savetxt(file, np.column_stack([cells, np.zeros(len(cells), int)]), "%d")
        file.write("End\n")


class Hdf5Mesh(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.gmsh = os.path.join(cls.folder.name, "cube.msh")
        write_gmsh(cls.gmsh)
        cls.whole = cls.written(["-mesh_file", cls.gmsh], "whole.h5")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def written(cls, options, name, ranks=1):
        path = os.path.join(cls.folder.name, name)
        done = run([*options, "-mesh_write", path], ranks)
        if done.returncode:
            raise AssertionError(done.stdout)
        return path

    def refused(self, path, *words, options=(), ranks=(1, 2)):
        for count in ranks:
            done = run(["-mesh_file", path, *BY_FORMULA, *options], count)
            self.assertEqual(done.returncode, 1, done.stdout)
            for word in words:
                self.assertIn(word, done.stdout)

    def test_the_same_as_the_file(self):
        for options in ([], ["-order", "2"], ["-mesh_refine", "1"]):
            expected = record_of(["-mesh_file", self.gmsh, *HELD, *options])
            for writers in (1, 2):
                path = self.written(["-mesh_file", self.gmsh, *options], "copy.h5", writers)
                for ranks in (1, 2, 3):
                    with self.subTest(options=options, writers=writers, ranks=ranks):
                        record = record_of(["-mesh_file", path, *HELD], ranks)
                        self.assertEqual(record["status"], 0, record["printed"])
                        self.assertLess(abs(energy(record) / energy(expected) - 1), 1e-9)
                        for kind in ("constraints", "loads", "regions"):
                            for one, other in zip(record[kind], expected[kind]):
                                for key in ("vertices", "facets", "cells", "area", "volume"):
                                    self.assertAlmostEqual(one.get(key, 0), other.get(key, 0))

    def test_the_first_rank_holds_no_more_than_others(self):
        def first_over_mean(mesh):
            own = [peak - least for peak, least in zip(peaks_of([*mesh, *copy], ranks), base)]
            return own[0] / (sum(own) / ranks)
        # What comes after the mesh, the matrices above all, is even anyway.
        copy, ranks = ["-mesh_write", os.path.join(self.folder.name, "copy.h5")], 4
        base = peaks_of(["-mesh_generate", "box", "-mesh_resolution", "2", *copy], ranks)
        medit = os.path.join(self.folder.name, "large.mesh")
        write_cube(medit, 30)
        path = self.written(["-mesh_file", medit], "large.h5")
        self.assertLess(first_over_mean(["-mesh_file", path]), 1.5)
        # Which is no matter of course: of other formats the first rank reads all.
        self.assertGreater(first_over_mean(["-mesh_file", medit]), 1.5)

    def test_it_is_divided_the_same_each_time(self):
        medit = os.path.join(self.folder.name, "often.mesh")
        write_cube(medit, 20)
        path = self.written(["-mesh_file", medit], "often.h5")
        cuts = {run(["-mesh_file", path, "-constraints", "wall", "-constraint_wall_where", "x == xmin",
                     "--check"], 4).stdout.split("edge cut ")[1].split(",")[0] for _ in range(3)}
        self.assertEqual(len(cuts), 1)

    def test_refined_where_it_is_read(self):
        expected = record_of(["-mesh_file", self.gmsh, *HELD, "-mesh_refine", "1"])
        for ranks in (1, 2):
            record = record_of(["-mesh_file", self.whole, *HELD, "-mesh_refine", "1"], ranks)
            self.assertLess(abs(energy(record) / energy(expected) - 1), 1e-9)

    def test_the_order_of_the_file(self):
        def fields(mesh, ranks):
            output = os.path.join(self.folder.name, "out.xdmf")
            self.assertEqual(run(["-mesh_file", mesh, *HELD, "-output_file", output],
                                 ranks).returncode, 0)
            with h5py.File(output[:-4] + "h5", "r") as data:
                return [data[name][()] for name in ("points", "cells", "vertex_fields/displacement")]
        expected = fields(self.gmsh, 1)
        for ranks in (1, 2, 3):
            points, cells, moved = fields(self.whole, ranks)
            np.testing.assert_array_equal(points, expected[0])
            np.testing.assert_array_equal(cells, expected[1])
            np.testing.assert_allclose(moved, expected[2], atol=1e-7)

    def test_curved_and_plane_cells(self):
        for body in (["-mesh_generate", "ball", "-order", "2"], ["-mesh_generate", "square"]):
            plane = "square" in body
            ends = [word.replace("0, 0, -5e3", "0, -5e3") for word in BY_FORMULA] if plane else BY_FORMULA
            if not plane:
                ends = [word.replace("x == xmin", "x < 0").replace("x == xmax", "x > 0.2") for word in ends]
            path = self.written([*body, "-mesh_resolution", "4"], "body.h5")
            expected = record_of([*body, "-mesh_resolution", "4", *ends])
            for ranks in (1, 3):
                record = record_of(["-mesh_file", path, *ends], ranks)
                self.assertLess(abs(energy(record) / energy(expected) - 1), 1e-9)

    def test_what_is_refused(self):
        folder = self.folder.name
        with open(self.whole, "rb") as file:
            whole = file.read()
        truncated = os.path.join(folder, "truncated.h5")
        with open(truncated, "wb") as file:
            file.write(whole[:len(whole) // 2])
        self.refused(truncated, "truncated.h5", "truncated or damaged")
        foreign = os.path.join(folder, "foreign.h5")
        with h5py.File(foreign, "w") as data:
            data["points"] = np.zeros((4, 3))
        self.refused(foreign, "no mesh that Trefoil has written")
        for name, place, value, words in (
                ("/topology/cells", 5, 10 ** 6, "/topology/cells"),
                ("/geometry/vertices", (1, 1), np.nan, "not finite"),
                ("/trefoil/header", 2, 10 ** 9, "more cells"), ("/trefoil/header", 3, 5, "/topology/cells"),
                ("/trefoil/header", 0, 7, "format 7"), ("/trefoil/cell_set", 3, 99, "cell_set"),
                ("/trefoil/entities_2", 0, 10 ** 6, "entities_2"),
                ("/trefoil/groups", 1, 9, "groups")):
            damaged = shutil.copy(self.whole, os.path.join(folder, "damaged.h5"))
            with h5py.File(damaged, "r+") as data:
                numbers = data[name][()]
                numbers[place] = value
                data[name][...] = numbers
                if name != "/trefoil/header" or place > 0:
                    data["/trefoil/header"][0] = 1  # a format whose lists have no checks
            with self.subTest(name=name):
                self.refused(damaged, "damaged.h5", words)
        self.refused_if_changed()
        self.refused(self.whole, "-order", "-mesh_write", options=["-order", "2"])
        self.refused(self.whole, "-mesh_normalize", options=["-mesh_normalize"])
        done = run(["-mesh_file", self.gmsh, "-mesh_write", self.gmsh])
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("write over", done.stdout)

    def refused_if_changed(self):
        """Whatever list is another than was written, even where it could be a mesh."""
        with h5py.File(self.whole) as data:
            lists = [f"/{name}/{member}" for name in ("trefoil", "geometry") for member in data[name]]
        for name in [*lists, "/topology/cells"]:
            changed = shutil.copy(self.whole, os.path.join(self.folder.name, "changed.h5"))
            with h5py.File(changed, "r+") as data:
                numbers = data[name][()]
                if name == "/trefoil/header":
                    numbers.flat[-1] += 1
                elif name == "/geometry/vertices":
                    numbers.flat[7] += 1e-9
                else:  # entries of other places, where there are two that differ
                    other = next((k for k, number in enumerate(numbers.flat)
                                  if number != numbers.flat[0]), 0)
                    if other == 0:
                        continue
                    numbers.flat[[0, other]] = numbers.flat[[other, 0]]
                data[name][...] = numbers
            with self.subTest(name=name):
                self.refused(changed, "changed.h5 is damaged in " + name)

    def test_damage_at_random(self):
        """Whatever is damaged, it is refused in one sentence, or solved."""
        chance = random.Random(int(os.environ.get("TREFOIL_FUZZ_SEED", "1")))
        with open(self.whole, "rb") as file:
            whole = bytearray(file.read())
        path = os.path.join(self.folder.name, "fuzz.h5")
        for _ in range(int(os.environ.get("TREFOIL_FUZZ_RUNS", "60"))):
            damaged = bytearray(whole)
            for _ in range(chance.randint(1, 8)):
                damaged[chance.randrange(8, len(damaged))] = chance.randrange(256)
            with open(path, "wb") as file:
                file.write(damaged)
            done = run(["-mesh_file", path, *HELD, "--check"])
            self.assertIn(done.returncode, (0, 1), done.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
