#!/usr/bin/python3
"""Output of scenes in time: velocities and accelerations against closed forms, and what is left of a
run that is killed."""
import csv
import glob
import os
import random
import resource
import signal
import subprocess
import tempfile
import time
import unittest
import xml.etree.ElementTree as ElementTree

try:
    import h5py
    import meshio
    import numpy as np
except ImportError:
    meshio = None

from trefoil_program import PROGRAM, environment, refusal_of, run

TIGHT = ["-snes_trefoil_energy_tolerance", "1e-26", "-time_velocity_tolerance", "1e-13",
         "-snes_trefoil_monitor", "false", "-snes_max_it", "30"]
BOX = ["-mesh_generate", "box", "-mesh_resolution", "2", "-material_density", "1e3"]
GRAVITY = -9.81


def read_series(path):
    """Rest positions, and for each state its time and the fields of its vertices."""
    with meshio.xdmf.TimeSeriesReader(path) as reader:
        points, _ = reader.read_points_cells()
        states = []
        for k in range(reader.num_steps):
            t, fields, _ = reader.read_data(k)
            states.append((t, fields))
    return points, states


@unittest.skipUnless(meshio, "needs python3-meshio, python3-h5py")
class Velocity(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def series(self, options, ranks=1):
        result = run([*BOX, *TIGHT, *options, "-output_file", "a.xdmf"], ranks, self.folder.name)
        self.assertEqual(result.returncode, 0, result.stdout)
        return read_series(os.path.join(self.folder.name, "a.xdmf"))

    def test_free_fall(self):
        """From rest every scheme has v = g t and a = g, in each state; after one of bdf2's steps by
        backward Euler too."""
        for integrator in ("backward_euler", "bdf2", "newmark"):
            for more, ranks in (([], 2), (["-order", "2"], 1), (["-mesh_generate", "square"], 1)):
                pull = np.array([0, GRAVITY, 0] if "square" in more else [0, 0, GRAVITY])
                _, states = self.series(
                    ["-load_gravity", ", ".join(map(str, pull[:2 if "square" in more else 3])),
                     "-time_end", "0.3", "-time_step", "0.1", "-time_integrator", integrator,
                     "-output_fields", "velocity,acceleration", *more], ranks)
                self.assertEqual(len(states), 4)
                for t, fields in states:
                    self.assertEqual(set(fields), {"velocity", "acceleration"} | (
                        {"original_vertex"} if "-order" in more else set()))
                    self.assertLess(abs(fields["velocity"] - t * pull).max(), 1e-11)
                    self.assertLess(abs(fields["acceleration"] - pull).max(), 1e-9)

    def test_rotation(self):
        """A stiff body that turns: omega x (x - c) where it is, whatever the scheme, to its order."""
        omega, centre = np.array([0, 0, 2.0]), np.full(3, 0.5)
        for integrator, size in (("backward_euler", 0.02), ("bdf2", 1e-3), ("newmark", 1e-3)):
            points, states = self.series(
                ["-material_young", "1e10", "-material_poisson", "0.3", "-initial_velocity",
                 "-2*(y - 0.5), 2*(x - 0.5), 0", "-time_end", "0.1", "-time_step", "0.005",
                 "-time_integrator", integrator])
            exact = np.cross(omega, points - centre)
            self.assertLess(abs(states[0][1]["velocity"] - exact).max(), 1e-14)
            self.assertNotIn("acceleration", states[0][1])  # by default
            t, fields = states[-1]
            self.assertAlmostEqual(t, 0.1)
            exact = np.cross(omega, points + fields["displacement"] - centre)
            self.assertLess(abs(fields["velocity"] - exact).max(), size * abs(exact).max())

    def test_what_is_held_has_the_velocity_of_its_motion(self):
        points, states = self.series(
            ["-constraints", "wall", "-constraint_wall_where", "x == xmin", "-constraint_wall_move",
             "0.5*t*t, 0, 0", "-material_young", "1e5", "-time_end", "0.3", "-time_step", "0.1",
             "-output_fields", "velocity,acceleration"])
        wall = points[:, 0] == points[:, 0].min()
        for t, fields in states:
            self.assertLess(abs(fields["velocity"][wall] - [t, 0, 0]).max(), 1e-12)
            self.assertLess(abs(fields["acceleration"][wall] - [1, 0, 0]).max(), 1e-11)

    def test_vtu_has_it_too(self):
        run([*BOX, *TIGHT, "-load_gravity", f"0, 0, {GRAVITY}", "-time_end", "0.2", "-time_step", "0.1",
             "-output_file", "a.vtu"], folder=self.folder.name)
        for k in range(3):
            mesh = meshio.read(os.path.join(self.folder.name, f"a_{k:04d}.vtu"))
            exact = np.array([0, 0, 0.1 * k * GRAVITY])
            self.assertLess(abs(mesh.point_data["velocity"] - exact).max(), 1e-11)

    def test_energy_inequality_of_backward_euler(self):
        """In every step, with nothing moved: Psi' + |v' - v|_M^2 / 2 <= Psi + |v|_M^2 / 2, Psi with the
        loads. Lumped masses are a quarter of each cell at its corners."""
        self.series(["-material_young", "2e4", "-material_poisson", "0.45", "-load_gravity",
                     f"0, 0, {GRAVITY}", "-constraints", "wall", "-constraint_wall_where", "x == xmin",
                     "-initial_velocity", "0, 2*x*z, 0", "-time_mass", "lumped", "-time_end", "1",
                     "-time_step", "0.05", "-output_csv", "a.csv"])
        with meshio.xdmf.TimeSeriesReader(os.path.join(self.folder.name, "a.xdmf")) as reader:
            points, cells = reader.read_points_cells()
            v = [reader.read_data(k)[1]["velocity"] for k in range(reader.num_steps)]
        corners = points[cells[0].data]
        volumes = abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
        mass = np.bincount(cells[0].data.ravel(), np.repeat(1e3 * volumes / 4, 4))
        with open(os.path.join(self.folder.name, "a.csv"), encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        psi = [float(row["strain_energy"]) - float(row["load_work"]) for row in rows]
        self.assertEqual((len(psi), len(v)), (21, 21))
        for k in range(20):
            before = mass @ (v[k] ** 2).sum(axis=1) / 2
            self.assertAlmostEqual(before, float(rows[k]["kinetic_energy"]), delta=1e-9)
            self.assertLess(psi[k + 1] + mass @ ((v[k + 1] - v[k]) ** 2).sum(axis=1) / 2,
                            psi[k] + before + 1e-9)

    def test_the_last_good_state_is_written(self):
        """A load that comes between two steps, too large: the way ends, and the state before it, which
        `every` would have left out, is in the series."""
        result = run([*BOX, "-constraints", "wall", "-constraint_wall_where", "x == xmin",
                      "-load_gravity", f"0, 0, {GRAVITY}", "-loads", "top", "-load_top_where",
                      "z == zmax", "-load_top_force", "1e9*(t > 0.25), 0, 0", "-material_young",
                      "1e5", "-time_end", "0.5", "-time_step", "0.1", "-time_step_min", "0.1",
                      "-snes_max_it", "4", "-output_every", "3",
                      "-output_file", "a.xdmf", "-output_csv", "a.csv"], folder=self.folder.name)
        self.assertEqual(result.returncode, 3, result.stdout)
        self.assertIn("the step in time from t = 0.2 to 0.3 failed, and -time_step_min 0.1 allows none "
                      "of half its length", result.stdout)
        _, states = read_series(os.path.join(self.folder.name, "a.xdmf"))
        self.assertEqual([round(t, 9) for t, _ in states], [0, 0.2])
        with open(os.path.join(self.folder.name, "a.csv"), encoding="utf-8") as file:
            last = list(csv.DictReader(file))[-1]
        moved = np.linalg.norm(states[-1][1]["displacement"], axis=1).max()
        self.assertAlmostEqual(moved, float(last["largest_displacement"]), delta=1e-12)
        self.assertLess(moved, 1)

    def test_not_without_time(self):
        for name in ("velocity", "acceleration"):
            result = run([*BOX, "-constraints", "a", "-constraint_a_where", "x == xmin",
                          "-output_fields", f"displacement,{name}", "-output_file", "a.xdmf"],
                         folder=self.folder.name)
            self.assertEqual(result.returncode, 1, result.stdout)
            self.assertIn(f"-output_fields names the {name}, which only a scene in time has",
                          result.stdout)
            self.assertEqual(os.listdir(self.folder.name), [])


MIXED = """
mesh:        {generate: box, resolution: 3}
order:       2
material:    {young: 1e5, poisson: 0.4, density: 1e3}
regions:
  heavy:     {where: "z < 0.4", material: {young: 1e6, density: 3e3}}
constraints:
  wall:      {where: "x == xmin", move: "0.1*sin(8*t), 0, 0"}
loads:
  top:       {where: "z == zmax", pressure: "1e3*t", follower: true}
time:        {end: 0.25, step: 0.1, integrator: bdf2}
output:      {file: "my body.xdmf", csv: "my table.csv", every: 7}
"""


@unittest.skipUnless(meshio, "needs python3-meshio, python3-h5py")
class Mixed(unittest.TestCase):
    """Regions, quadratic cells, what moves and what follows, an end between steps, names with blanks."""

    def test_by_any_number_of_ranks(self):
        ends = []
        for ranks in (1, 3):
            with tempfile.TemporaryDirectory() as folder:
                with open(os.path.join(folder, "my scene.yaml"), "w", encoding="utf-8") as file:
                    file.write(MIXED)
                result = run(["my scene.yaml", *TIGHT], ranks, folder)
                self.assertEqual(result.returncode, 0, result.stdout)
                points, states = read_series(os.path.join(folder, "my body.xdmf"))
                self.assertEqual([t for t, _ in states], [0, 0.25])
                with open(os.path.join(folder, "my table.csv"), encoding="utf-8") as file:
                    rows = list(csv.DictReader(file))
                self.assertEqual([round(float(row["dt"]), 12) for row in rows], [0, 0.1, 0.1, 0.05])
                ends.append(states[-1][1])
        for name in ("displacement", "velocity"):
            size = abs(ends[0][name]).max()
            self.assertLess(abs(ends[0][name] - ends[1][name]).max(), 1e-9 * size)
        wall = points[:, 0] == 0
        self.assertLess(abs(ends[0]["displacement"][wall, 0] - 0.1 * np.sin(2)).max(), 1e-14)
        # by differences over the last step, to its one side
        self.assertLess(abs(ends[0]["velocity"][wall, 0] - 0.8 * np.cos(2)).max(), 0.1)

    def test_planes_to_slide_in_must_lie_along_the_axes(self):
        for ranks in (1, 2):
            sentence = refusal_of([*BOX, "-constraints", "wall", "-constraint_wall_where", "x == xmin",
                                   "-constraint_wall_slide", "1, 1, 0", "-time_end", "1", "-time_step",
                                   "0.1"], ranks)
            self.assertIn("not parallel to the axes, which a scene in time cannot do", sentence)


def children_of(pid):
    with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
        return [int(word) for word in file.read().split()]


@unittest.skipUnless(meshio, "needs python3-meshio, python3-h5py")
class Killed(unittest.TestCase):
    """kill -9 in the midst of a run: all states but perhaps the last can be read."""

    SCENE = [*BOX, "-material_young", "1e5", "-load_gravity", f"0, 0, {GRAVITY}", "-constraints",
             "wall", "-constraint_wall_where", "x == xmin", "-snes_trefoil_monitor", "false",
             "-time_end", "1000", "-time_step", "0.01", "-output_csv", "a.csv"]

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def kill_in_step(self, step, output, ranks):
        """@return how many steps stood when the run was killed, somewhere in a step from this one on"""
        command = [PROGRAM, *self.SCENE, "-output_file", output]
        if ranks > 1:
            command = ["mpirun", "-n", str(ranks), *command]
        began = 0
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              cwd=self.folder.name, env=environment()) as process:
            for line in process.stdout:
                if line.startswith("time step "):
                    began = int(line.split()[2].rstrip(","))
                if began >= step:
                    break
            time.sleep(random.uniform(0, 0.03))
            for pid in [*(children_of(process.pid) if ranks > 1 else []), process.pid]:
                os.kill(pid, signal.SIGKILL)
            for line in process.stdout:
                if line.startswith("time step "):
                    began = int(line.split()[2].rstrip(","))
        self.assertGreaterEqual(began, step)
        return began - 1

    def check_table(self, steps):
        with open(self.path("a.csv"), encoding="utf-8") as file:
            text = file.read()
        rows = list(csv.DictReader(text[:text.rindex("\n") + 1].splitlines()))
        self.assertGreaterEqual(len(rows), steps)
        for k, row in enumerate(rows):
            self.assertAlmostEqual(float(row["t"]), 0.01 * k, delta=1e-12)
            self.assertNotIn(None, row.values())

    def test_xdmf(self):
        random.seed(17)
        for ranks in (1, 2):
            for step in (1, 2, 3, 7, 12):
                steps = self.kill_in_step(step, "a.xdmf", ranks)
                with self.subTest(ranks=ranks, steps=steps):
                    points, states = read_series(self.path("a.xdmf"))
                    self.assertEqual(points.shape, (27, 3))
                    self.assertGreaterEqual(len(states), steps + 1)  # and the start
                    for k, (t, fields) in enumerate(states):
                        self.assertAlmostEqual(t, 0.01 * k, delta=1e-12)
                        for name in ("displacement", "velocity"):
                            self.assertTrue(np.isfinite(fields[name]).all())
                            self.assertEqual(fields[name].any(), k > 0)
                    tree = ElementTree.parse(self.path("a.xdmf"))
                    for item in tree.iter("DataItem"):
                        file, dataset = item.text.split(":")
                        with h5py.File(self.path(file), "r") as data:
                            self.assertEqual(" ".join(map(str, data[dataset].shape)),
                                             item.get("Dimensions"))
                    self.check_table(steps)

    def test_vtu(self):
        random.seed(18)
        for step in (1, 5):
            steps = self.kill_in_step(step, "a.vtu", 1)
            tree = ElementTree.parse(self.path("a.pvd"))
            files = [entry.get("file") for entry in tree.iter("DataSet")]
            self.assertGreaterEqual(len(files), steps + 1)
            for file in [*files, "a.vtu"]:
                self.assertEqual(meshio.read(self.path(file)).point_data["velocity"].shape, (27, 3))

    def test_a_disk_that_is_full_leaves_whole_rows(self):
        """Here a bound on the size of files, which comes in the midst of a row."""
        command = [PROGRAM, *self.SCENE]
        printed = []
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              cwd=self.folder.name, env=environment(),
                              restore_signals=False) as process:  # SIGXFSZ stays ignored
            for line in process.stdout:
                printed.append(line)
                if line.startswith("time step 3,"):
                    bound = os.path.getsize(self.path("a.csv")) + 50000
                    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (bound, bound))
        self.assertEqual(process.returncode, 1)
        self.assertIn("cannot write the file 'a.csv': File too large", printed[-1])
        with open(self.path("a.csv"), encoding="utf-8") as file:
            text = file.read()
        self.assertTrue(text.endswith("\n"), text[-80:])
        self.assertGreater(len(text), bound - 1000)

    def test_a_run_goes_over_what_a_killed_one_left(self):
        """Neither old states nor old rows nor parts of files stay in what is read; parts of a run that
        goes on do."""
        self.kill_in_step(4, "a.xdmf", 1)
        self.assertTrue(glob.glob(self.path("a_*.h5")))
        dead = subprocess.Popen(["true"])
        dead.wait()
        left = [f"a.xdmf.{dead.pid}.abcdef.part", f"a_0007.h5.{dead.pid}.abcdef.part",
                f"a.csv.{dead.pid}.a2cdef.part"]
        not_ours = [f"b.xdmf.{dead.pid}.abcdef.part", f"a.h5.{os.getpid()}.abcdef.part",
                    "a.h5.abcdef.part", "a.part"]
        for name in (*left, *not_ours):
            with open(self.path(name), "wb"):
                pass
        shorter = [*self.SCENE, "-time_end", "0.02", "-output_file", "a.xdmf"]
        result = run(shorter, folder=self.folder.name)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertEqual([round(t, 9) for t, _ in read_series(self.path("a.xdmf"))[1]], [0, 0.01, 0.02])
        with open(self.path("a.csv"), encoding="utf-8") as file:
            self.assertEqual(len(list(csv.DictReader(file))), 3)
        self.assertEqual(sorted(name for name in os.listdir(self.folder.name) if name.endswith(".part")),
                         sorted(not_ours))


if __name__ == "__main__":
    unittest.main()
