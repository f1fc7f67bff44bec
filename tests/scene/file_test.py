#!/usr/bin/python3
"""Where a run writes: devices, pipes and links stay what they are, files appear whole or not at all."""
import concurrent.futures
import json
import os
import stat
import subprocess
import tempfile
import unittest

from trefoil_program import PROGRAM, environment, run

SCENE = ["-mesh_generate", "box", "-mesh_resolution", "2", "-constraints", "low",
         "-constraint_low_where", "z==zmin"]


class InAFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def solve(self, *options, ranks=1):
        done = run([*SCENE, *options], ranks, self.folder)
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout

    def record(self, *names):
        with open(self.path(*names), encoding="utf-8") as file:
            return json.load(file)


class Streams(InAFolder):
    def test_device(self):
        null = self.path("null")
        try:  # one of our own: who would put the machine's at stake?
            os.mknod(null, stat.S_IFCHR | 0o666, os.makedev(1, 3))
        except PermissionError:
            self.skipTest("only root makes devices")
        for ranks in (1, 2):
            self.solve("-snes_trefoil_record", "null", ranks=ranks)
            self.assertTrue(stat.S_ISCHR(os.stat(null).st_mode))

    def test_pipe(self):
        os.mkfifo(self.path("pipe"))
        with concurrent.futures.ThreadPoolExecutor() as pool:
            reader = pool.submit(subprocess.run, ["cat", self.path("pipe")], text=True, timeout=60,
                                 stdout=subprocess.PIPE, check=True)
            self.solve("-snes_trefoil_record", "pipe")
            self.assertTrue(json.loads(reader.result().stdout)["result"]["converged"])
        self.assertTrue(stat.S_ISFIFO(os.stat(self.path("pipe")).st_mode))

    def test_standard_output(self):
        """Also where it is a file, which the record must not replace or write over."""
        os.symlink("/proc/self/fd/1", self.path("stdout"))  # what /dev/stdout is
        with open(self.path("log"), "w", encoding="utf-8") as log:
            subprocess.run([PROGRAM, *SCENE, "-snes_trefoil_record", self.path("stdout")], stdout=log,
                           env=environment(), check=True)
        with open(self.path("log"), encoding="utf-8") as log:
            text = log.read()
        for words in ("mesh: generated box", '"history"', "converged in", "\nseconds "):
            self.assertEqual(text.count(words), 1, text)

    def test_fields_need_a_file(self):
        os.mkfifo(self.path("run.xdmf"))
        done = run([*SCENE, "-output_file", "run.xdmf"], 1, self.folder)
        self.assertEqual(done.returncode, 1)
        self.assertIn("run.xdmf': it is a device or a pipe", done.stdout)
        self.assertEqual(os.listdir(self.folder), ["run.xdmf"])


class Links(InAFolder):
    def test_links_are_followed(self):
        os.mkdir(self.path("scratch"))
        for there in (True, False):  # with and without something at the link's end
            for name in ("run.json", "run.xdmf"):
                if there:
                    open(self.path("scratch", name), "w", encoding="utf-8").close()
                else:
                    os.remove(self.path("scratch", name))
                if not os.path.islink(self.path(name)):
                    os.symlink(os.path.join("scratch", name), self.path(name))
            for ranks in (1, 2):
                self.solve("-snes_trefoil_record", "run.json", "-output_file", "run.xdmf",
                           ranks=ranks)
                for name in ("run.json", "run.xdmf"):
                    self.assertTrue(os.path.islink(self.path(name)), name)
                self.assertTrue(self.record("scratch", "run.json")["result"]["converged"])
                self.assertEqual(sorted(os.listdir(self.path("scratch"))),
                                 ["run.h5", "run.json", "run.xdmf"])
        self.assertEqual(sorted(os.listdir(self.folder)), ["run.json", "run.xdmf", "scratch"])

    def test_permissions_are_the_users(self):
        self.solve("-snes_trefoil_record", "run.json", "-output_file", "run.xdmf")
        mask = os.umask(0)
        os.umask(mask)
        for name in ("run.json", "run.xdmf", "run.h5"):
            self.assertEqual(stat.S_IMODE(os.stat(self.path(name)).st_mode), 0o666 & ~mask, name)


class RunsAtOnce(InAFolder):
    def test_one_target(self):
        """Each run has parts of its own, so that any of them leaves whole files."""
        with concurrent.futures.ThreadPoolExecutor(max_workers=4) as pool:
            runs = [pool.submit(self.solve, "-snes_trefoil_record", "run.json", "-output_file",
                                "run.xdmf") for _ in range(8)]
            for each in runs:
                each.result()
        self.assertTrue(self.record("run.json")["result"]["converged"])
        self.assertEqual(sorted(os.listdir(self.folder)), ["run.h5", "run.json", "run.xdmf"])

    def test_a_part_of_the_users(self):
        with open(self.path("run.json.part"), "w", encoding="utf-8") as file:
            file.write("mine")
        self.solve("-snes_trefoil_record", "run.json")
        with open(self.path("run.json.part"), encoding="utf-8") as file:
            self.assertEqual(file.read(), "mine")


class BrokenPipe(unittest.TestCase):
    def test_help_that_nobody_reads(self):
        for options in ("-help", "--help all"):
            done = subprocess.run(["sh", "-c", f"{PROGRAM} {options} | true"],
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                  env=environment(), timeout=60, check=True)
            self.assertEqual(done.stderr, "")


if __name__ == "__main__":
    unittest.main(verbosity=2)
