"""Lines about work that takes long."""
import re
import subprocess
import unittest

from trefoil_program import PROGRAM, environment

BOX = ["-mesh_generate", "box", "-mesh_resolution", "5", "-constraints", "held,pulled",
       "-constraint_held_where", "x == xmin", "-constraint_pulled_where", "x == xmax",
       "-constraint_pulled_move", "1, 1-z-y, y-z", "-material_poisson", "0.4"]
ALWAYS = ["-progress_seconds", "1e-9"]
LINE = re.compile(r"(\d+) s, (\d+\.\d\d) GB on the largest rank: (.+)")


def run(*options, ranks=1):
    return subprocess.run(["mpirun", "-n", str(ranks), PROGRAM, *BOX, *options], env=environment(),
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=100,
                          check=False)


class ProgressTest(unittest.TestCase):
    def lines_of(self, *options, ranks=1):
        """Seconds, gigabytes and work of each line."""
        finished = run(*ALWAYS, *options, ranks=ranks)
        self.assertEqual(finished.returncode, 0, finished.stderr)
        found = [LINE.fullmatch(line) for line in finished.stderr.splitlines()]
        self.assertTrue(found and all(found), finished.stderr)
        return [(int(line[1]), float(line[2]), line[3]) for line in found]

    def test_every_phase_tells_where_it_is(self):
        for ranks in 1, 2:
            lines = self.lines_of("-solver", "iterative", ranks=ranks)
            works = [work for _, _, work in lines]
            self.assertEqual(works[:2], ["the mesh is distributed", "the scene is built"])
            self.assertEqual(works[-1], "solved, results are written")
            self.assertEqual([work for work in works if work.startswith("start")],
                             [f"start: local/global step {k} of 20" for k in range(1, 21)])
            seconds = [second for second, _, _ in lines]
            self.assertEqual(seconds, sorted(seconds))
            for _, gigabytes, _ in lines:  # the libraries alone take 50 MB
                self.assertTrue(.03 < gigabytes < 1, gigabytes)

    def test_iterations_tell_how_far_the_end_is(self):
        pattern = re.compile(r"iteration (\d+), (\d+) linear iterations"
                             r"(?:, decrement (\S+) times its tolerance)?")
        lines = [work for _, _, work in self.lines_of("-solver", "iterative")]
        found = [pattern.fullmatch(work) for work in lines]
        iterations = [match for match in found if match]
        self.assertEqual([int(match[1]) for match in iterations], list(range(len(iterations))))
        totals = [int(match[2]) for match in iterations]
        self.assertEqual(totals, sorted(totals))
        self.assertIsNone(iterations[0][3])
        self.assertGreater(float(iterations[1][3]), 1)
        self.assertLess(float(iterations[-1][3]), float(iterations[1][3]))
        within = [work for work in lines if re.fullmatch(r"iteration 1, linear iteration \d+", work)]
        self.assertGreater(len(within), 1)

    def test_short_work_and_stdout_say_nothing_of_it(self):
        silent, often = run("-progress_seconds", "1000"), run(*ALWAYS)
        self.assertEqual((silent.stderr, run("-progress_seconds", "0").stderr), ("", ""))
        self.assertNotIn("largest rank", often.stdout)
        self.assertEqual(len(silent.stdout.splitlines()), len(often.stdout.splitlines()))

    def test_no_negative_seconds(self):
        refused = run("-progress_seconds", "-1")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("-progress_seconds is -1", refused.stderr)


if __name__ == "__main__":
    unittest.main()
