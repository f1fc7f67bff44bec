#!/usr/bin/python3
"""Checkpoints and restarts: runs that are killed, stopped or out of iterations go on where they were, on
other numbers of ranks, to the same end; files that do not fit are refused."""
import csv
import glob
import json
import math
import os
import resource
import signal
import subprocess
import tempfile
import unittest

import h5py

from boxes import ENDS, THREE_PLANES
from trefoil_program import PROGRAM, environment, run

TIGHT = ["-snes_trefoil_energy_tolerance", "1e-14"]
TURNED = [*ENDS, *TIGHT, "-constraint_high_move", "1, 1-z-y, y-z", "-material_poisson", "0.45"]
HARD = [*TURNED, "-initial", "harmonic"]
MOMENT = ["-checkpoint", "run.ckpt", "-checkpoint_every", "1"]
BODY = ["-mesh_generate", "box", "-mesh_resolution", "3", "-material_density", "1e3", "-material_young",
        "2e4", "-material_poisson", "0.3"]
IN_TIME = ["-snes_trefoil_energy_tolerance", "1e-26", "-time_velocity_tolerance", "1e-13", "-snes_max_it",
           "30", "-time_step", "0.02"]
SWINGING = [*BODY, *IN_TIME, "-constraints", "wall", "-constraint_wall_where", "x == xmin",
            "-load_gravity", "0, 0, -9.81", "-time_damping_stiffness", "1e-3"]
DROPPED = [*BODY, *IN_TIME, "-load_gravity", "3, 0, -9.81", "-initial_velocity", "1, 0, -1",
           "-obstacles", "floor", "-obstacle_floor_plane", "0, 0, 1", "-obstacle_floor_at", "0, 0, -0.03",
           "-obstacle_floor_friction", "0.3"]


def children_of(process):
    with open(f"/proc/{process}/task/{process}/children", encoding="utf8") as file:
        return [int(child) for child in file.read().split()]


class RestartTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def solve(self, options, ranks=1, status=0):
        result = run([*options, "-snes_trefoil_record", "run.json"], ranks, self.folder)
        self.assertEqual(result.returncode, status, result.stdout)
        with open(self.path("run.json"), encoding="utf-8") as file:
            return json.load(file)

    def refused(self, options, *words, ranks=(1, 2)):
        for count in ranks:
            result = run(options, count, self.folder)
            self.assertEqual(result.returncode, 1, result.stdout)
            self.assertEqual(result.stdout.count("trefoil: "), 1, result.stdout)
            for word in words:
                self.assertIn(word, result.stdout)

    def interrupt(self, options, at, number, ranks=1):
        """Sends a signal once a line is printed that begins with `at`; exit status and all lines."""
        command = [PROGRAM, *options]
        if ranks > 1:
            command = ["mpirun", "-n", str(ranks), *command]
        with subprocess.Popen(command, cwd=self.folder, env=environment(), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
            lines = []
            for line in process.stdout:
                lines.append(line)
                if line.startswith(at):
                    os.kill(children_of(process.pid)[-1] if ranks > 1 else process.pid, number)
                    break
            self.assertTrue(lines[-1].startswith(at), "".join(lines))
            lines += process.stdout.readlines()
            return process.wait(), "".join(lines)

    def same_end(self, one, other, tolerance=1e-9):
        size = one["result"]["energy_scale"]
        self.assertAlmostEqual(one["result"]["energy"], other["result"]["energy"], delta=tolerance * size)

    def same_states(self, one, other, tolerance=1e-9):
        """All that is told of all steps."""
        def compare(a, b, name):
            self.assertEqual(type(a), type(b), name)
            if isinstance(a, dict):
                self.assertEqual(list(a), list(b))
                for key in a:
                    compare(a[key], b[key], f"{name}.{key}")
            elif isinstance(a, list):
                self.assertEqual(len(a), len(b), name)
                for k, (x, y) in enumerate(zip(a, b)):
                    compare(x, y, f"{name}.{k}")
            elif isinstance(a, float):
                self.assertLessEqual(abs(a - b), tolerance * max(1e3, abs(a)), name)
            elif "iterations" not in name:
                self.assertEqual(a, b, name)
        for step in (*one["steps"], *other["steps"]):
            for key in ("largest_von_mises", "least_det_F", "largest_displacement"):
                step[key].pop("at", None)  # of two places with the same value either may be named
        compare(one["steps"], other["steps"], "steps")


class Static(RestartTest):
    def test_within_a_solve(self):
        """Linear and quadratic cells, refined ones, vertices that slide along axes of their own; on
        other numbers of ranks."""
        slides = [*THREE_PLANES, *TIGHT, "-constraints", "floor,wall,back,lid", "-constraint_lid_where",
                  "z == zmax", "-constraint_lid_slide", "0.2, 0.1, 1", "-load_top_where", "x == xmax",
                  "-loads", "top", "-load_top_traction", "3e5, 0, 0", "-initial", "rest"]
        for options, ranks, others in ((HARD, 1, (1, 2, 3)), ([*HARD, "-order", "2"], 2, (1,)),
                                       ([*HARD, "-mesh_refine", "1", "-mesh_resolution", "2"], 3, (1, 2)),
                                       (slides, 1, (2,))):
            whole = self.solve(options)
            most = str(max(2, whole["result"]["iterations"] // 2))
            self.solve([*options, *MOMENT, "-snes_max_it", most], ranks, status=3)
            for count in others:
                with self.subTest(options=options, ranks=count):
                    rest = self.solve([*options, "-restart", "run.ckpt"], count)
                    self.same_end(whole, rest)
                    self.assertLess(rest["result"]["iterations"], whole["result"]["iterations"])
                    self.assertEqual(rest["restarted_from"], "run.ckpt")

    def test_the_search_goes_on(self):
        """Not only x: weight, trust and previous step make the next iterations those of the run."""
        for filter_name in ("adaptive", "multiplicative"):
            options = [*HARD, "-snes_trefoil_filter", filter_name]
            whole = self.solve(options)["history"]
            self.solve([*options, *MOMENT, "-snes_max_it", "4"], status=3)
            rest = self.solve([*options, "-restart", "run.ckpt"])["history"]
            self.assertEqual(len(rest), len(whole) - 4)
            for mine, its in zip(rest, whole[4:]):
                self.assertEqual(mine["weight"], its["weight"])
                self.assertAlmostEqual(mine["energy"], its["energy"], delta=1e-8 * abs(its["energy"]))

    def test_killed(self):
        options = [*HARD, "-mesh_resolution", "10"]
        whole = self.solve(options)
        for ranks in (1, 2):
            status, text = self.interrupt([*options, *MOMENT], "   3 ", signal.SIGKILL, ranks)
            self.assertNotEqual(status, 0, text)
            rest = self.solve([*options, "-restart", "run.ckpt"], 3 - ranks)
            self.same_end(whole, rest)
            # One interval is lost at most; the signal may have come late.
            self.assertLessEqual(rest["result"]["iterations"], whole["result"]["iterations"] - 2)

    def test_stopped(self):
        options = [*HARD, "-mesh_resolution", "10", "-checkpoint", "run.ckpt"]
        whole = self.solve(options)
        for ranks in (1, 2):
            os.remove(self.path("run.ckpt"))
            status, text = self.interrupt(options, "   2 ", signal.SIGTERM, ranks)
            self.assertEqual(status, 3, text)
            self.assertEqual(text.count("trefoil: stopped by SIGTERM; -restart run.ckpt goes on"), 1, text)
            self.same_end(whole, self.solve([*options, "-restart", "run.ckpt"], ranks))

    def test_stopped_while_its_start_is_made(self):
        """A softer body, and full steps from it, are begun anew."""
        options = [*HARD, "-mesh_resolution", "8", "-order", "2", "-material_poisson", "0.4999",
                   "-material_model", "neo_hookean", "-initial", "auto", "-checkpoint", "run.ckpt",
                   "-constraint_high_move", "0.5, 0.2*y, 0"]
        whole = self.solve(options)
        for line, ranks in (("   1 ", 1), ("   1 ", 2), ("start: full steps", 1)):
            os.remove(self.path("run.ckpt"))
            with self.subTest(line=line, ranks=ranks):
                status, text = self.interrupt(options, line, signal.SIGTERM, ranks)
                self.assertEqual(status, 3, text)
                self.assertEqual("start: full steps" in text, line != "   1 ", text)
                self.assertEqual(text.count("   k  "), 1, text)
                rest = self.solve([*options, "-restart", "run.ckpt"], ranks)
                self.same_end(whole, rest)
                self.assertEqual(rest["result"]["iterations"], whole["result"]["iterations"])

    def test_asked_for(self):
        """SIGUSR1 saves, and the run goes on."""
        options = [*HARD, "-mesh_resolution", "10", "-checkpoint", "run.ckpt"]
        for ranks in (1, 2):
            status, text = self.interrupt(options, "   2 ", signal.SIGUSR1, ranks)
            self.assertEqual(status, 0, text)
            self.assertIn("converged", text)

    def test_by_time(self):
        self.solve([*HARD, "-checkpoint", "run.ckpt", "-checkpoint_seconds", "1e-9", "-snes_max_it", "3"],
                   status=3)
        self.assertLess(self.solve([*HARD, "-restart", "run.ckpt"])["result"]["iterations"],
                        self.solve(HARD)["result"]["iterations"])
        os.remove(self.path("run.ckpt"))
        self.solve([*HARD, "-checkpoint", "run.ckpt", "-snes_max_it", "3"], status=3)
        self.assertFalse(os.path.exists(self.path("run.ckpt")), "a minute has not gone by")

    def test_finished(self):
        """The file stays, and a tighter run begins where the looser one has ended."""
        loose = [*ENDS, "-constraint_high_move", "1, 1-z-y, y-z", "-initial", "harmonic"]
        self.solve([*loose, "-checkpoint", "run.ckpt", "-snes_trefoil_energy_tolerance", "1e-4"])
        rest = self.solve([*loose, *TIGHT, "-restart", "run.ckpt"])
        whole = self.solve([*loose, *TIGHT])
        self.same_end(whole, rest)
        self.assertLess(rest["history"][0]["energy"], whole["history"][0]["energy"])

    def test_load_steps(self):
        for steps in ("4", "auto"):
            options = [*TURNED, "-load_steps", steps]
            whole = self.solve(options)
            for at in ("load step 2", "load step 3"):
                status, text = self.interrupt([*options, *MOMENT, "-output_file", "run.xdmf"], at,
                                              signal.SIGKILL)
                self.assertEqual(status, -signal.SIGKILL, text)
                rest = self.solve([*options, "-restart", "run.ckpt", "-output_file", "run.xdmf"], 2)
                self.same_states(whole, rest, 1e-6)  # stresses are off by the energy's root
                self.assertEqual(len(rest["result"]["load_step_iterations"]), len(rest["steps"]))
                self.assertEqual(len(glob.glob(self.path("run_*.h5"))), len(rest["steps"]))
        self.refused([*TURNED, "-load_steps", "7", "-restart", "run.ckpt"], "other -load_steps", ranks=(1,))

    def test_path(self):
        """A leap and a path of the program's own accord, wherever they are left."""
        options = [*TURNED, "-constraint_high_move", "1.4, 1-z-y, y-z", "-material_poisson", "0.49"]
        whole = self.solve(options)
        solves = run(options, 1, self.folder).stdout.count("\n   k")
        self.assertGreater(solves, 2, "a scene without path tests nothing")
        for at in ("   2 ", "path to t = 0.6", "path to t = 1"):
            with self.subTest(at=at):
                status, text = self.interrupt([*options, *MOMENT], at, signal.SIGKILL)
                self.assertEqual(status, -signal.SIGKILL, text)
                self.same_end(whole, self.solve([*options, "-restart", "run.ckpt"], 2))

    def test_leap_beside_a_path(self):
        """The leap is tried as well, where a path ends with inverted elements; either may count."""
        for angle in (130, 160):
            c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
            options = [*ENDS, *TIGHT, "-mesh_resolution", "6", "-material_poisson", "0.3",
                       "-constraint_high_move",
                       f"{c - 1}*(x-0.5) - {s}*(y-0.5), {s}*(x-0.5) + {c - 1}*(y-0.5), -0.3"]
            whole = self.solve(options)
            with self.subTest(angle=angle):
                self.interrupt([*options, *MOMENT], "the path ends with", signal.SIGKILL)
                again = self.solve([*options, "-restart", "run.ckpt"], 2)
                self.same_end(whole, again)
                self.assertEqual([step.get("rejected") for step in whole["steps"]],
                                 [step.get("rejected") for step in again["steps"]])

    def test_contact(self):
        options = ["-mesh_generate", "box", "-mesh_resolution", "3", "-material_young", "1e5",
                   "-material_poisson", "0.3", "-constraints", "top", "-constraint_top_where", "z == zmax",
                   "-snes_trefoil_energy_tolerance", "1e-13",
                   "-obstacles", "floor", "-obstacle_floor_plane", "0, 0, 1", "-obstacle_floor_at",
                   "0, 0, -0.02", "-obstacle_floor_friction", "0.3", "-contact_friction_iterations", "2",
                   "-constraint_top_move", "0.1*t, 0, -0.3*t", "-load_steps", "3"]
        whole = self.solve(options)
        for at in ("load step 2", "load step 3"):
            self.interrupt([*options, *MOMENT], at, signal.SIGKILL)
            rest = self.solve([*options, "-restart", "run.ckpt"], 2)
            self.same_states(whole, rest, 1e-6)


class InitialFile(RestartTest):
    def test_each_kind(self):
        whole = self.solve([*TURNED, "-checkpoint", "run.ckpt", "-output_file", "one.xdmf"])
        self.solve([*TURNED, "-output_file", "one.vtu", "-mesh_partitioner", "metis"], 2)
        self.solve([*TURNED, "-output_file", "more.xdmf", "-load_steps", "2"])
        for name in ("run.ckpt", "one.xdmf", "one.h5", "one.vtu", "more.xdmf", "more_0001.h5"):
            for ranks in (1, 2):
                with self.subTest(name, ranks=ranks):
                    again = self.solve([*TURNED, "-initial", "file", "-initial_file", name], ranks)
                    self.same_end(whole, again)
                    self.assertLessEqual(again["result"]["iterations"], 2)
        halfway = self.solve([*TURNED, "-initial", "file", "-initial_file", "more_0000.h5"])
        self.assertGreater(halfway["result"]["iterations"], 2)

    def test_other_meshes_are_refused(self):
        self.solve([*TURNED, "-output_file", "one.xdmf"])
        self.solve([*TURNED, "-output_file", "one.vtu"])
        start = [*TURNED, "-initial", "file", "-initial_file"]
        with open(self.path("bent.vtu"), "wb") as file, open(self.path("one.vtu"), "rb") as good:
            file.write(good.read()[:3000])
        for name in ("one.xdmf", "one.vtu"):
            self.refused([*start, name, "-mesh_resolution", "5"], "one.", "another mesh", "vertices")
            self.refused([*start, name, "-mesh_normalize"], "in other places", ranks=(1,))
        self.refused([*start, "bent.vtu"], "bent.vtu")
        self.refused([*start, "gone.xdmf"], "gone.xdmf", "No such file")
        self.refused([*TURNED, "-initial", "file"], "-initial_file", ranks=(1,))
        self.refused([*TURNED, "-initial_file", "one.vtu"], "-initial file", ranks=(1,))


class Refused(RestartTest):
    def test_files_that_do_not_fit(self):
        self.solve([*HARD, *MOMENT])
        restart = [*HARD, "-restart"]
        with open(self.path("run.ckpt"), "rb") as file:
            whole = file.read()
        for name, data in (("short.ckpt", whole[:len(whole) // 2]), ("text.ckpt", b"no HDF5 at all\n"),
                           ("empty.ckpt", b"")):
            with open(self.path(name), "wb") as file:
                file.write(data)
            self.refused([*restart, name], name)
        run([*HARD, "-mesh_write", "mesh.h5"], 1, self.folder)
        self.refused([*restart, "mesh.h5"], "mesh.h5", "no checkpoint")
        self.refused([*restart, "gone.ckpt"], "gone.ckpt", "No such file")
        self.refused([*restart, "run.ckpt", "-mesh_resolution", "5"], "another mesh", "216", ranks=(1, 3))
        self.refused([*restart, "run.ckpt", "-order", "2"], "another mesh", "tet10")
        self.refused([*restart, "run.ckpt", "-mesh_normalize"], "in other places")
        self.refused(["-mesh_generate", "square", "-restart", "run.ckpt", "-constraint_low_where",
                      "x == xmin", "-constraints", "low"], "another mesh", "tri3")
        self.refused([*SWINGING, "-time_end", "1", "-mesh_resolution", "4", "-restart", "run.ckpt"],
                     "without time")

    def test_another_material_is_said(self):
        self.solve([*HARD, *MOMENT])
        self.assertEqual(self.solve([*HARD, "-restart", "run.ckpt"])["result"]["warnings"], [])
        other = self.solve([*HARD, "-material_young", "2e6", "-restart", "run.ckpt"])
        self.assertIn("-material_young", other["result"]["warnings"][0])
        self.assertIn("2e6 here", other["result"]["warnings"][0])
        printed = run([*HARD, "-material_young", "2e6", "-restart", "run.ckpt"], 2, self.folder).stdout
        self.assertEqual(printed.count("WARNING: the run goes on from one of another scene"), 1)

    def test_a_pressure_of_elements_that_was_chosen_is_like_one_that_is_given(self):
        rubber = ["-mesh_generate", "square", "-mesh_resolution", "2", "-order", "2",
                  "-material_poisson", "0.49", "-constraints", "low", "-constraint_low_where",
                  "y == ymin", "-loads", "pull", "-load_pull_where", "y == ymax",
                  "-load_pull_traction", "1e4, 0"]
        self.solve([*rubber, "-checkpoint", "rubber.ckpt"])
        restart = [*rubber, "-restart", "rubber.ckpt", "-element_pressure"]
        for pressure in ("constant", "auto"):
            self.assertEqual(self.solve([*restart, pressure])["result"]["warnings"], [])
        self.assertIn("-element_pressure constant there",
                      self.solve([*restart, "pointwise"])["result"]["warnings"][0])

    def test_numbers_that_are_damaged(self):
        """Of these the program could not make sense; a letter of them may be damaged on a disk."""
        self.solve([*HARD, *MOMENT, "-snes_max_it", "2"], status=3)
        for number in (b'"last_number":-1', b'"accepted":0', b'"k":1'):
            with h5py.File(self.path("run.ckpt"), "r+") as file:
                letters = file["checkpoint"][()]
                at = bytes(letters.ravel().tolist()).index(number) + len(number) - 1
                letters.reshape(-1)[at] = ord("9")
                file["checkpoint"][...] = letters
            self.refused([*HARD, "-restart", "run.ckpt"], "run.ckpt is damaged")

    def test_fields_that_are_damaged(self):
        self.solve([*HARD, *MOMENT, "-snes_max_it", "2"], status=3)
        with h5py.File(self.path("run.ckpt"), "r+") as file:
            file["fields/displacement"][20, 1] += 1e-6
        words = "run.ckpt is damaged in /fields/displacement"
        self.refused([*HARD, "-restart", "run.ckpt"], words)
        self.refused([*TURNED, "-initial", "file", "-initial_file", "run.ckpt"], words)

    def test_another_way_is_said(self):
        self.solve([*TURNED, *MOMENT, "-snes_max_it", "2"], status=3)
        self.refused([*HARD, "-restart", "run.ckpt"], "-initial none there, harmonic here", ranks=(1,))

    def test_options(self):
        self.refused([*HARD, "-restart", "a.ckpt", "-initial", "file", "-initial_file", "b.ckpt"],
                     "give one", ranks=(1,))
        self.refused([*HARD, "-checkpoint_every", "2"], "-checkpoint run.ckpt", ranks=(1,))
        self.refused([*HARD, "-checkpoint", "a.ckpt", "-checkpoint_every", "-2"], "negative", ranks=(1,))
        self.refused([*HARD, "-checkpoint", "gone/a.ckpt"], "no directory 'gone'")
        self.refused([*HARD, "-checkpoint", "/dev/full"], "device")
        self.refused([*HARD, "-checkpoint", "a.json", "-snes_trefoil_record", "a.json"], "write over",
                     ranks=(1,))

    def test_a_disk_that_is_full(self):
        """The last checkpoint stays, and the run goes on to its end."""
        large = [*HARD, "-mesh_resolution", "10"]
        text = self.solve_on_a_full_disk(large)
        self.assertIn("WARNING: a checkpoint was not written: ", text)
        self.assertEqual(glob.glob(self.path("run.ckpt*")), [])
        self.solve([*large, *MOMENT, "-snes_max_it", "2"], status=3)
        with open(self.path("run.ckpt"), "rb") as file:
            before = file.read()
        text = self.solve_on_a_full_disk(large)
        self.assertIn("WARNING: a checkpoint was not written, the one before stays: ", text)
        with open(self.path("run.ckpt"), "rb") as file:
            self.assertEqual(file.read(), before)
        self.assertEqual(glob.glob(self.path("*.part")), [])

    def solve_on_a_full_disk(self, large):
        # As from a full disk, errors come without a signal.
        with subprocess.Popen([PROGRAM, *large, "-checkpoint", "run.ckpt", "-checkpoint_every", "2"],
                              cwd=self.folder, env=environment(), text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT,
                              preexec_fn=lambda: signal.signal(signal.SIGXFSZ, signal.SIG_IGN)) as process:
            lines = [process.stdout.readline()]  # the mesh is there, and MPI has its files
            resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (100000, 100000))
            text = "".join(lines + process.stdout.readlines())
            self.assertEqual(process.wait(), 0, text)
        return text


class InTime(RestartTest):
    def table(self, name):
        with open(self.path(name), encoding="utf8") as file:
            return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]

    def goes_on(self, options, ranks=1, others=1, number=signal.SIGKILL, tolerance=1e-9):
        """Killed in the middle of a step, and again later: the states, the series and the table of a run
        in one piece."""
        options = [*options, "-time_end", "0.3"]
        kept = ["-output_file", "run.xdmf", "-output_csv", "run.csv", *MOMENT]
        whole = self.solve([*options, "-output_file", "whole.xdmf", "-output_csv", "whole.csv"])
        status, text = self.interrupt([*options, *kept], "time step 6", number, ranks)
        self.assertNotEqual(status, 0, text)
        status, text = self.interrupt([*options, *kept, "-restart", "run.ckpt"], "time step 11", number,
                                      ranks)
        self.assertNotEqual(status, 0, text)
        self.assertNotIn("time step 3,", text)
        rest = self.solve([*options, *kept, "-restart", "run.ckpt"], others)
        self.same_states(whole, rest, tolerance)
        self.assertEqual([row["t"] for row in self.table("run.csv")],
                         [row["t"] for row in self.table("whole.csv")])
        self.assertEqual(len(rest["result"]["time_step_iterations"]), 15)
        with open(self.path("run.xdmf"), encoding="utf8") as mine, \
                open(self.path("whole.xdmf"), encoding="utf8") as its:
            self.assertEqual(mine.read().replace("run", "whole"), its.read())
        for step in range(16):
            self.assertTrue(os.path.exists(self.path(f"run_{step:04d}.h5")))

    def test_each_scheme(self):
        for integrator in ("backward_euler", "bdf2", "newmark"):
            with self.subTest(integrator):
                self.goes_on([*SWINGING, "-time_integrator", integrator])

    def test_other_ranks(self):
        self.goes_on([*SWINGING, "-time_integrator", "bdf2"], ranks=2, others=3)

    def test_stopped(self):
        """At once: what the step under way has found so far is thrown away."""
        self.goes_on(SWINGING, number=signal.SIGTERM)

    def test_contact_and_friction(self):
        self.goes_on(DROPPED, others=2, tolerance=1e-8)

    def test_what_was_written_later_is_cut(self):
        kept = [*SWINGING, "-output_file", "run.vtu"]
        self.solve([*kept, "-time_end", "0.1", "-checkpoint", "run.ckpt"])
        self.solve([*kept, "-time_end", "0.2"])
        self.assertEqual(len(glob.glob(self.path("run_*.vtu"))), 11)
        self.refused([*kept, "-time_end", "0.12", "-restart", "run.ckpt", "-constraint_wall_where",
                      "x == xmax", "-constraints", "wall,top", "-constraint_top_where", "z == zmax"],
                     "other constraints", ranks=(1,))
        self.solve([*kept, "-time_end", "0.12", "-restart", "run.ckpt"])
        self.assertEqual(len(glob.glob(self.path("run_*.vtu"))), 7)
        with open(self.path("run.pvd"), encoding="utf8") as file:
            self.assertEqual(file.read().count("<DataSet"), 7)
        os.remove(self.path("run_0003.vtu"))
        self.refused([*kept, "-time_end", "0.12", "-restart", "run.ckpt"], "run_0003.vtu", "not there")

    def test_a_longer_run(self):
        whole = self.solve([*SWINGING, "-time_end", "0.2"])
        self.solve([*SWINGING, "-time_end", "0.1", "-checkpoint", "run.ckpt"])
        self.same_states(whole, self.solve([*SWINGING, "-time_end", "0.2", "-restart", "run.ckpt"]))
        done = self.solve([*SWINGING, "-time_end", "0.1", "-restart", "run.ckpt"])
        self.assertEqual(len(done["steps"]), 6)
        self.assertIn("run.ckpt is at t = 0.1, the end: nothing is left to be solved", run(
            [*SWINGING, "-time_end", "0.1", "-restart", "run.ckpt"], folder=self.folder).stdout)
        self.refused([*SWINGING, "-time_end", "0.06", "-restart", "run.ckpt"],
                     "run.ckpt is at t = 0.1, behind -time_end 0.06: give a later end")


if __name__ == "__main__":
    unittest.main()
