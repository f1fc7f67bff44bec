#!/usr/bin/python3
"""examples/speed_against_error: its judgement, with data made by hand, and one quick run."""
import csv
import math
import os
import subprocess
import sys
import tempfile
import unittest

from trefoil_program import PROGRAM, ROOT, environment

sys.path.insert(0, os.path.join(ROOT, "examples"))
from speed_error import judgement, runs, tables  # noqa: E402
from speed_error.judgement import ANOTHER, FAILED, MINIMUM, UNFINISHED  # noqa: E402

SCENE = runs.Scene("made up", ())
METHODS = [runs.Method(rule, "rest", "armijo", 1e-11) for rule in ("one", "two", "three")]


def record_with(energies, converged=True, scale=2.0, decrement=1e-12, guess_solves=0):
    """A run with these energies before its steps; a second and a linear solve a direction."""
    history = [{"k": k, "energy": energy, "seconds": 1.0 + k, "linear_solves": k + 1,
                "decrement": scale * 10.0 ** -(2 * k + 1)} for k, energy in enumerate(energies)]
    return {"result": {"energy": energies[-1], "energy_scale": scale, "converged": converged,
                       "newton_decrement": decrement, "iterations": len(energies),
                       "guess_linear_solves": guess_solves}, "history": history}


def judge(*records):
    return judgement.judge_all({(SCENE, method): record
                                for method, record in zip(METHODS, records)})


class Outcomes(unittest.TestCase):
    def outcomes(self, *records):
        _, judged = judge(*records)
        return [judged[SCENE, method].outcome for method, _ in zip(METHODS, records)]

    def test_a_wrong_minimum_is_flagged(self):
        right, wrong = record_with([9.0, 5.0]), record_with([9.0, 5.0 + 2 * 1.1e-6])
        self.assertEqual(self.outcomes(right, wrong), [MINIMUM, ANOTHER])
        self.assertEqual(self.outcomes(wrong, right), [ANOTHER, MINIMUM])

    def test_the_same_minimum_is_not(self):
        self.assertEqual(self.outcomes(record_with([9.0, 5.0]), record_with([5.0 + 2 * 0.9e-6])),
                         [MINIMUM, MINIMUM])

    def test_the_error_is_relative_to_the_scale_and_not_to_the_energy(self):
        offset = 1e4  # 1e-5 in 1e4 would be 1e-9
        self.assertEqual(self.outcomes(record_with([offset]), record_with([offset + 1e-5])),
                         [MINIMUM, ANOTHER])

    def test_negative_energies(self):
        references, judged = judge(record_with([-5.0]), record_with([-4.0]))
        self.assertEqual(references[SCENE].energy, -5.0)
        self.assertEqual(judged[SCENE, METHODS[1]].outcome, ANOTHER)

    def test_a_run_that_did_not_converge_says_so_wherever_it_ended(self):
        self.assertEqual(self.outcomes(record_with([9.0, 5.0]),
                                       record_with([9.0, 5.0], converged=False)),
                         [MINIMUM, UNFINISHED])

    def test_a_lower_energy_of_any_run_is_the_reference(self):
        self.assertEqual(self.outcomes(record_with([9.0, 5.0]),
                                       record_with([9.0, 4.0], converged=False)),
                         [ANOTHER, UNFINISHED])

    def test_no_record(self):
        self.assertEqual(self.outcomes(None, record_with([5.0])), [FAILED, MINIMUM])
        self.assertEqual(self.outcomes(None), [FAILED])

    def test_no_finite_energy(self):
        self.assertEqual(self.outcomes(record_with([None], converged=False), record_with([5.0])),
                         [UNFINISHED, MINIMUM])


class References(unittest.TestCase):
    """A lowest energy of a run that had not converged is one whose error nobody knows."""

    def setUp(self):
        lowest = record_with([9.0, 4.0], converged=False, decrement=None)
        self.references, self.judged = judge(record_with([9.0, 5.0]), lowest)

    def test_tables_say_so(self):
        self.assertEqual(self.references[SCENE].support, math.inf)
        text = tables.overview(self.judged, self.references, METHODS[:2], METHODS[0])
        self.assertIn(f"too small, in: {SCENE.name}.", text)
        self.assertIn("had not converged", tables.by_scene(self.judged, self.references))
        references, judged = judge(record_with([9.0, 5.0]))
        self.assertNotIn("too small",
                         tables.overview(judged, references, METHODS[:1], METHODS[0]))

    def test_plots_are_drawn(self):
        from speed_error import plots
        with tempfile.TemporaryDirectory() as folder:
            plots.draw_all(folder, self.judged, self.references, METHODS[:2])
            self.assertEqual(len(os.listdir(folder)), 4)


class Levels(unittest.TestCase):
    def test_cost_includes_guess_and_last_direction(self):
        _, judged = judge(record_with([4.0, 0.1, 1e-3, 0.0], guess_solves=7))
        levels = judged[SCENE, METHODS[0]].levels
        self.assertEqual(levels[1e-1], (2, 9, 2.0))
        self.assertEqual(levels[1e-2], (3, 10, 3.0))
        self.assertEqual(levels[1e-3], (3, 10, 3.0))
        self.assertEqual(levels[1e-8], (4, 11, 4.0))

    def test_only_the_last_load_step_comes_close(self):
        path = record_with([1.0, 0.5, 9.0, 5.0])
        for k, entry in enumerate(path["history"]):
            entry["load_step"] = 1 if k < 2 else 2
        references, judged = judge(path)
        self.assertEqual(judged[SCENE, METHODS[0]].levels[1e-1], (4, 4, 4.0))
        self.assertEqual(judgement.stop_at(path, references[SCENE], 1e-2), (3, 2.0))

    def test_a_path_walked_in_vain_after_the_leap_is_no_cost_of_its_states(self):
        run = record_with([1.0, 0.5, 9.0, 6.0, 5.0])
        for k, entry in enumerate(run["history"]):
            entry["rejected"] = k < 2
            entry["seconds"] += 10 if k < 2 else 0
        _, judged = judge(run)
        self.assertEqual(judged[SCENE, METHODS[0]].levels[1e-1], (3, 3, 5.0))

    def test_another_minimum_never_comes_close(self):
        _, judged = judge(record_with([4.0, 0.0]), record_with([4.0, 1.0, 0.1]))
        levels = judged[SCENE, METHODS[1]].levels
        self.assertEqual(levels[1e-1], (3, 3, 3.0))
        self.assertIsNone(levels[1e-2])

    def test_ratios_are_of_what_both_reached(self):
        _, judged = judge(record_with([4.0, 0.0]), record_with([4.0, 3.0, 2.0, 0.1]))
        one, two = METHODS[:2]
        self.assertEqual(judgement.ratios_to(judged, two, one, 1e-1, 0), {SCENE: 2.0})
        self.assertEqual(judgement.ratios_to(judged, two, one, 1e-2, 0), {})

    def test_profile(self):
        _, judged = judge(record_with([4.0, 0.0]), record_with([4.0, 3.0, 2.0, 0.0]),
                          record_with([4.0, 1.0]))
        profile = judgement.profile(judged, 1e-4)
        self.assertEqual([profile[method] for method in METHODS], [[1.0], [2.0], [math.inf]])

    def test_geometric_mean(self):
        self.assertAlmostEqual(judgement.geometric_mean([0.5, 2.0, 8.0]), 2.0)
        self.assertTrue(math.isnan(judgement.geometric_mean([])))

    def test_stop_test(self):
        record = record_with([4.0, 0.1, 1e-3, 0.0])  # decrements 1e-1, 1e-3, 1e-5, 1e-7 scales
        reference = judgement.reference_of({None: record})
        self.assertEqual(judgement.stop_at(record, reference, 1e-4), (3, 1e-3 / 2))
        self.assertIsNone(judgement.stop_at(record, reference, 1e-8))


class Paper(unittest.TestCase):
    ROW = {"final_energy": "15.0", "iterations": "4"}  # theirs are three times ours

    def test_first_state_at_or_below_their_energy(self):
        theirs = record_with([9.0] * 5)
        self.assertEqual(judgement.against_paper(record_with([9.0, 5.0 * (1 + 1e-10), 4.0]),
                                                 theirs, self.ROW), (2, 0.5, 2.0 / 5.0))
        self.assertEqual(judgement.against_paper(record_with([9.0, 5.0 * (1 + 1e-8), 4.0]),
                                                 theirs, self.ROW), (3, 0.75, 3.0 / 5.0))

    def test_states_of_other_loads_do_not_count(self):
        path, given_up = record_with([3.0, 9.0, 5.0]), record_with([3.0, 9.0, 5.0])
        for entry, step in zip(path["history"], (1, 2, 2)):
            entry["load_step"] = step
        for entry in given_up["history"]:
            entry["load_step"] = 1
        given_up["history"][0]["rejected"] = True
        for record in (path, given_up):
            self.assertEqual(judgement.against_paper(record, record_with([9.0] * 4), self.ROW)[0], 3)

    def test_table(self):
        scene, method = runs.Scene("of the paper", (), self.ROW), METHODS[0]
        lost = runs.Scene("not reached", (), self.ROW)
        comparison = tables.compare_with_paper(
            {(scene, method): record_with([9.0, 5.0]), (lost, method): record_with([9.0])},
            {scene: record_with([9.0] * 4), lost: record_with([9.0])}, [method])
        self.assertIn(f"| {method.name} | 1 of 2 | 0.500 | 0.50 of the paper | 0.500 |",
                      tables.paper_overview(comparison))
        by_scene = tables.paper_by_scene(comparison)
        self.assertIn(f"| {method.name} | of the paper | 4 | 2 | 0.50 | 0.50 |", by_scene)
        self.assertIn(f"| {method.name} | not reached | 4 | not reached | - | - |", by_scene)

    def test_never_below(self):
        self.assertIsNone(judgement.against_paper(record_with([9.0, 6.0]), record_with([9.0]),
                                                  self.ROW))


class Running(unittest.TestCase):
    """With a program that only counts its runs and takes longer in the first and the third."""

    PROGRAM = """#!/usr/bin/python3
import json, os, sys
counter = os.path.join(os.path.dirname(sys.argv[0]), "counter")
count = os.path.getsize(counter) + 1 if os.path.exists(counter) else 1
open(counter, "a").write("x")
record = sys.argv[sys.argv.index("-snes_trefoil_record") + 1]
if "-fail" in sys.argv:
    sys.exit("trefoil: there is no such mesh")
json.dump({"run": count, "history": [{"seconds": 2 + count % 2}],
           "result": {"iterations": 1, "converged": True}}, open(record, "w"))
"""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.program = os.path.join(self.folder.name, "program")
        with open(self.program, "w", encoding="utf-8") as file:
            file.write(self.PROGRAM)
        os.chmod(self.program, 0o755)

    def run_all(self, reuse=False, options=(), repeats=1):
        runner = runs.Runner(self.program, 1, options, os.path.join(self.folder.name, "records"),
                             reuse, 60)
        record = runner.run_all([SCENE], METHODS[:1], repeats, lambda line: None)
        return runner, record[SCENE, METHODS[0]]

    def test_the_fastest_of_the_repeats_is_kept(self):
        self.assertEqual(self.run_all(repeats=3)[1]["run"], 2)

    def test_reuse(self):
        self.run_all()
        self.assertEqual(self.run_all(reuse=True)[1]["run"], 1)
        self.assertEqual(self.run_all(reuse=True, options=["-mesh_refine", "1"])[1]["run"], 2)
        self.assertEqual(self.run_all()[1]["run"], 3)

    def test_a_failure_is_told(self):
        runner, record = self.run_all(options=["-fail"])
        self.assertIsNone(record)
        self.assertIn("there is no such mesh", runner.summary(SCENE, METHODS[0], None))


class Refusals(unittest.TestCase):
    """What makes no study: one sentence, and no exit status 0."""

    def check_tool(self, tool, arguments, status, word):
        result = subprocess.run(["/usr/bin/python3", os.path.join(ROOT, tool), *arguments],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                env=environment(), check=False)
        self.assertEqual(result.returncode, status, result.stdout)
        self.assertIn(word, result.stdout)
        self.assertNotIn("Traceback", result.stdout)

    def check(self, arguments, status, word):
        with tempfile.TemporaryDirectory() as folder:
            self.check_tool("examples/speed_against_error", [
                "--quick", "--program", PROGRAM, "-o", folder, *arguments], status, word)

    def test_what_is_not_there(self):
        self.check(["--scenes", "nofile.yaml"], 2, "'nofile.yaml'")
        self.check(["--paper", "/nonexistent"], 2, "/nonexistent/reference/official.csv")
        self.check(["--rules", "nonsense"], 1, "'nonsense'")

    def test_cost_model(self):
        self.check_tool("tests/benchmarks/cost_model.py", ["nonsense"], 1, "cost_model.py: ")

    def test_no_run_left_an_energy(self):
        self.check(["--only", "stretch .3", "--guesses", "rest", "--searches", "armijo", "--",
                    "-mesh_file", "nofile.mesh"], 1, "no run left an energy")


class QuickRun(unittest.TestCase):
    def test_tables_and_plots(self):
        tool = os.path.join(ROOT, "examples", "speed_against_error")
        guesses, searches, scenes = ("rest", "arap"), ("armijo", "subspace"), ("stretch", "twist")
        with tempfile.TemporaryDirectory() as folder:
            result = subprocess.run(
                ["/usr/bin/python3", tool, "--quick", "--poisson", ".4", "--only", ",".join(scenes),
                 "--guesses", ",".join(guesses), "--searches", ",".join(searches),
                 "--program", PROGRAM, "-o", folder], stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT, text=True, env=environment(), check=False)
            self.assertEqual(result.returncode, 0, result.stdout)
            with open(os.path.join(folder, "errors.csv"), encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            with open(os.path.join(folder, "tables.md"), encoding="utf-8") as file:
                text = file.read()
            for name in ("profiles", *(f"scene_{scene}_.4" for scene in scenes)):
                for ending in ("png", "svg"):
                    path = os.path.join(folder, f"{name}.{ending}")
                    self.assertGreater(os.path.getsize(path), 1000, path)
        pairs = {(row["scene"], row["guess"], row["search"], row["relative_error"]) for row in rows}
        expected = {(f"{scene} .4", guess, search, tables.power(level)) for scene in scenes
                    for guess in guesses for search in searches for level in judgement.LEVELS}
        self.assertEqual(pairs, expected)
        self.assertEqual(len(rows), len(expected))
        for scene in scenes:
            found = [row for row in rows if row["scene"] == f"{scene} .4"
                     and row["outcome"] == MINIMUM]
            self.assertTrue(found, text)
            for row in found:
                self.assertLessEqual(float(row["final_error"]), 1e-8, row)
                self.assertGreater(int(row["iterations"]), 0)
                self.assertGreaterEqual(int(row["linear_solves"]), int(row["iterations"]))
                self.assertGreater(float(row["seconds"]), 0)
        self.assertIn("| adaptive rest armijo |", text)
        self.assertIn("## Stop tests", text)

    def test_rules_are_the_programs(self):
        names = runs.rules_of(PROGRAM)
        self.assertIn("adaptive", names)
        self.assertNotIn("constant", names)


if __name__ == "__main__":
    unittest.main()
