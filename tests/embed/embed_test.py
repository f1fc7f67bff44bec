#!/usr/bin/python3
"""Unmodified PETSc codes get the filter from their command line: examples/embed, 1 and 2 ranks."""
import os
import re
import subprocess
import tempfile
import unittest

from hosts import DIRECT, HOSTS, LIBRARY, LOAD, ROOT, TREFOIL, outcome, run, sentence

ELEMENTS = [os.path.join(HOSTS, "elements")]
PLEX = [os.path.join(HOSTS, "plex_fe")]
ROWS = [os.path.join(HOSTS, "row_by_row")]
SWING = [os.path.join(HOSTS, "swing")]
OWN_RULE = [os.path.join(HOSTS, "own_rule")]
TWO_MATRICES = [os.path.join(HOSTS, "two_matrices")]
STATIC = [os.path.join(HOSTS, "static_host")]
DOLFIN = ["/usr/bin/python3", os.path.join(ROOT, "tests", "embed", "dolfin_twist.py")]
DOLFINX = ["/usr/bin/python3", os.path.join(ROOT, "examples", "embed", "dolfinx_stretch.py")]


class Host(unittest.TestCase):
    def same_on_one_and_two_ranks(self, program, options, most_iterations):
        """Runs with the type and with the line search, on 1 and 2 ranks; all must agree."""
        expected = None
        for way in (TREFOIL, f"{LOAD} -snes_linesearch_type trefoil -snes_stol 0 "
                             "-snes_divergence_tolerance -1 -snes_max_it 200"):
            for ranks in (1, 2):
                with self.subTest(way=way, ranks=ranks, options=options):
                    printed, status, _ = run(program, f"{DIRECT} {options} {way}", ranks)
                    converged, iterations, value = outcome(printed)
                    self.assertEqual(status, 0)
                    self.assertTrue(converged, printed)
                    self.assertLessEqual(iterations, most_iterations)
                    if expected is None:
                        expected = iterations, value
                    self.assertEqual(iterations, expected[0])
                    self.assertLess(abs(value / expected[1] - 1), 1e-9)
        return expected

    def stock(self, program, options):
        """What PETSc's own default line search does in 60 iterations."""
        printed, _, _ = run(program, f"{DIRECT} {options} -snes_linesearch_type bt -snes_max_it 60")
        return outcome(printed)


class TheDefault(Host):
    SOLVERS = {"-ksp_type preonly -pc_type lu": "inertia",
               "-ksp_type preonly -pc_type cholesky": "inertia",
               DIRECT: "curvature", "-ksp_type cg -ksp_rtol 1e-10 -pc_type jacobi": "curvature"}

    def test_is_newtons_where_newton_works_and_vouches_for_it(self):
        stop = "-snes_rtol 1e-8 -snes_stol 0"
        bt = {stretch: self.stock(ELEMENTS, f"{stop} -stretch {stretch}")
              for stretch in (0.6, 0.9, 1.3, 1.8)}
        for solver, witness in self.SOLVERS.items():
            for stretch in bt:
                with self.subTest(solver=solver, stretch=stretch):
                    options = f"{solver} {stop} -stretch {stretch}"
                    printed, _, record = run(ELEMENTS, f"{options} {TREFOIL} "
                                                       "-snes_trefoil_record record.json")
                    ours, stock = outcome(printed), bt[stretch]
                    self.assertTrue(stock[0] and ours[0])
                    self.assertLessEqual(ours[1], stock[1] + 2)
                    self.assertLess(ours[2] / stock[2] - 1, 1e-9)
                    taken = [entry for entry in record["history"] if entry["step"] > 0]
                    self.assertEqual(taken[-1]["weight"], 0)
                    for entry in taken:
                        self.assertEqual(entry["definite_by"],
                                         witness if entry["weight"] < 0.5 else None)


class InTime(unittest.TestCase):
    def test_steps_of_generalised_alpha(self):
        """TSALPHA2: the states of PETSc's own Newton; with long steps in fewer iterations."""
        tight = f"{DIRECT} -snes_rtol 1e-11 -snes_stol 0"
        stock = outcome(run(SWING, tight)[0])[2]
        for ranks in (1, 2):
            printed, status, _ = run(SWING, f"{tight} {TREFOIL} -snes_trefoil_energy_tolerance "
                                            "1e-24", ranks)
            self.assertEqual(status, 0, printed)
            self.assertLess(abs(outcome(printed)[2] / stock - 1), 1e-9)
        stock, ours = (outcome(run(SWING, f"{DIRECT} -snes_stol 0 -ts_dt 0.1 {way}")[0])
                       for way in ("", TREFOIL))
        self.assertLess(ours[1], 0.7 * stock[1])
        self.assertLess(abs(ours[2] / stock[2] - 1), 1e-6)

    def test_a_step_that_is_too_long_is_no_error(self):
        """The solve diverges, in words, and TSALPHA2 tries a shorter step."""
        printed, status, _ = run(SWING, f"{DIRECT} -bars 100 -ts_dt 0.25 "
                                        f"-ts_max_snes_failures -1 {TREFOIL}")
        self.assertEqual(status, 0, printed)
        self.assertIn("the step is too long for a solve without an energy to compare", printed)
        self.assertTrue(outcome(printed)[0], printed)


class HandWrittenElements(Host):
    def test_stretch_where_stock_fails(self):
        self.assertFalse(self.stock(ELEMENTS, "")[0])
        self.same_on_one_and_two_ranks(ELEMENTS, "", 25)

    def test_coarse_spaces_of_another_jacobian_are_made_anew(self):
        """Smoothed aggregation keeps those of the first one, with which a later one may look
        indefinite."""
        for rule in ("newton_first", "clamp"):
            for ranks in (1, 2):
                with self.subTest(rule=rule, ranks=ranks):
                    printed, _, _ = run(ELEMENTS, "-cells 4 -poisson 0.3 -stretch 2 -ksp_type cg -pc_type gamg "
                                        f"{TREFOIL} -snes_trefoil_filter {rule}", ranks)
                    converged, iterations, _ = outcome(printed)
                    self.assertTrue(converged, printed)
                    self.assertLess(iterations, 15)

    def test_every_way_of_insertion_is_the_same(self):
        expected = self.same_on_one_and_two_ranks(ELEMENTS, "", 25)
        for options in ("-blocked", "-mat_type baij", "-mat_type baij -blocked",
                        "-mat_type sbaij -mat_ignore_lower_triangular -pc_type cholesky",
                        "-mat_type sbaij -mat_ignore_lower_triangular -pc_type cholesky -blocked",
                        "-mat_type aij -mat_type aij -objective"):
            # PETSc 3.18 has no MatZeroRowsColumns for MPISBAIJ, which this host calls.
            for ranks in (1,) if "sbaij" in options else (1, 2):
                with self.subTest(options=options, ranks=ranks):
                    printed, _, _ = run(ELEMENTS, f"{DIRECT} {TREFOIL} {options}", ranks)
                    converged, iterations, energy = outcome(printed)
                    self.assertTrue(converged)
                    self.assertEqual(iterations, expected[0])
                    self.assertLess(abs(energy / expected[1] - 1), 1e-9)

    def test_loaded_by_the_environment_and_twice(self):
        printed, _, _ = run(ELEMENTS, DIRECT, variables={"PETSC_OPTIONS": TREFOIL})
        self.assertTrue(outcome(printed)[0])
        printed, _, _ = run(ELEMENTS, f"{DIRECT} {LOAD},{LIBRARY} -snes_type trefoil")
        self.assertTrue(outcome(printed)[0])

    def test_record_monitor_view_and_no_leaks(self):
        printed, status, record = run(
            ELEMENTS, f"{DIRECT} {TREFOIL} -snes_trefoil_record record.json -snes_trefoil_monitor "
                      "-snes_view -malloc_dump -options_left", 2)
        converged, iterations, _ = outcome(printed)
        self.assertTrue(converged and status == 0)
        self.assertEqual(len(record["history"]), iterations + 1)
        self.assertEqual(record["solver"]["unfiltered_blocks"], 0)
        self.assertEqual(record["mesh"]["elements"], 384)
        self.assertEqual(record["history"][0]["rho"], None)  # the lifted boundary is no model's step
        self.assertEqual(record["history"][-1]["weight"], 0)  # it ends as Newton's method
        self.assertIn("snes_trefoil_filter: newton_first", printed)
        self.assertIn("There are no unused options", printed)
        self.assertNotIn("bytes", printed.split("There are no unused options")[1])

    def test_what_cannot_work_is_said(self):
        for options, words in (("-snes_mf_operator", "matrix-free"),
                               ("-snes_fd", "finite differences"),
                               ("-snes_trefoil_fliter clamp", "no option -snes_trefoil_fliter"),
                               ("-snes_trefoil_filter clmap", "no filter 'clmap'"),
                               ("-snes_linesearch_type bt", "cannot use 'bt'")):
            for ranks in (1, 2):
                with self.subTest(options=options, ranks=ranks):
                    printed, status, _ = run(ELEMENTS, f"{DIRECT} {TREFOIL} {options}", ranks)
                    self.assertNotEqual(status, 0)
                    self.assertIn(words, sentence(printed))

    def test_matrix_free_goes_on_where_the_user_says_so(self):
        for options, note in (("-pc_type lu -snes_mf_operator -ksp_type preonly", None),
                              ("-pc_type lu -snes_mf_operator -ksp_type gmres -stretch 1.1",
                               "multiplies by a matrix that is not filtered"),
                              ("-snes_mf -ksp_type gmres -stretch 1.1", "nothing of it is filtered")):
            with self.subTest(options=options):
                printed, status, record = run(
                    ELEMENTS, f"{TREFOIL} {options} -cells 3 -snes_trefoil_strict false "
                              "-snes_trefoil_record record.json")
                self.assertEqual(status, 0)
                self.assertTrue(outcome(printed)[0], printed)
                if note:
                    self.assertIn(note, printed)
                    self.assertIn(note, record["solver"]["notes"][0])
                    self.assertGreater(record["solver"]["unfiltered_blocks"], 0)

    def test_types_without_newton_directions_are_named(self):
        for kind in ("qn", "ncg", "vinewtonrsls", "vinewtonssls"):
            printed, status, _ = run(ELEMENTS, f"{LOAD} -snes_type {kind} -objective "
                                               "-snes_linesearch_type trefoil")
            self.assertNotEqual(status, 0)
            self.assertIn(f"SNES type '{kind}' does not support line search trefoil",
                          sentence(printed))


class TwoMatrices(Host):
    def test_the_operator_is_filtered_too_or_refused(self):
        krylov = "-ksp_type gmres -pc_type jacobi -ksp_rtol 1e-12 -ksp_gmres_restart 40"
        direct, _, _ = run(TWO_MATRICES, f"-same {DIRECT} {TREFOIL}")
        expected = outcome(direct)
        self.assertTrue(expected[0])
        for options in (f"-same {krylov}", DIRECT):  # a direct solver looks at P alone
            printed, _, _ = run(TWO_MATRICES, f"{options} {TREFOIL}")
            self.assertEqual(outcome(printed)[:2], expected[:2])
            self.assertLess(abs(outcome(printed)[2] / expected[2] - 1), 1e-8)
        printed, status, _ = run(TWO_MATRICES, f"{krylov} {TREFOIL}")
        self.assertNotEqual(status, 0)
        self.assertIn("two matrices differ", sentence(printed))

    def test_a_right_jacobian_passes_petscs_own_test(self):
        printed, _, record = run(TWO_MATRICES, f"-one {DIRECT} {TREFOIL} -snes_test_jacobian "
                                               "-snes_trefoil_filter adaptive "
                                               "-snes_max_it 4 -snes_trefoil_record record.json")
        ratios = re.findall(r"J - Jfd\|\|_F/\|\|J\|\|_F = ([0-9.e+-]+)", printed)
        self.assertEqual(len(ratios), 4, printed)  # once an iteration
        for ratio in ratios:
            self.assertLess(float(ratio), 1e-6)
        self.assertGreater(record["history"][0]["indefinite"], 0)  # and yet it was filtered


class StaticHost(Host):
    def test_petsc_may_end_after_our_own_destructors(self):
        for _ in range(5):
            printed, status, _ = run(STATIC, f"-pc_type lu {TREFOIL}")
            self.assertEqual(status, 0, printed)
            self.assertTrue(outcome(printed)[0])


@unittest.skipUnless(subprocess.run(["/usr/bin/python3", "-c", "import dolfin"], check=False,
                                    stderr=subprocess.DEVNULL).returncode == 0,
                     "python3-dolfin is not installed")
class LegacyDolfin(Host):
    def test_twist_has_stocks_energy_and_ends_well(self):
        with tempfile.TemporaryDirectory() as cache:
            home = {"DIJITSO_CACHE_DIR": cache}
            stock, _, _ = run(DOLFIN, "", variables={
                "PETSC_OPTIONS": "-snes_linesearch_type bt", **home})
            for _ in range(5):
                printed, status, _ = run(DOLFIN, "", variables={"PETSC_OPTIONS": TREFOIL, **home})
                self.assertEqual(status, 0, printed)
                self.assertIn("the objective is the norm of the residual", printed)
                self.assertLess(abs(outcome(printed)[2] / outcome(stock)[2] - 1), 1e-10)
                self.assertLessEqual(outcome(printed)[1], outcome(stock)[1] + 2)


class PlexFiniteElements(Host):
    def test_stretch_where_stock_fails(self):
        self.assertFalse(self.stock(PLEX, "")[0])
        self.same_on_one_and_two_ranks(PLEX, "", 20)


class RowByRow(Host):
    def test_one_call_makes_elements_visible(self):
        results = [outcome(run(ROWS, DIRECT, ranks)[0]) for ranks in (1, 2)]
        self.assertTrue(results[0][0] and results[1][0])
        self.assertEqual(results[0][1], results[1][1])
        self.assertLess(abs(results[0][2] / results[1][2] - 1), 1e-9)

    def test_rows_are_named(self):
        for ranks in (1, 2):
            printed, status, _ = run(ROWS, f"{DIRECT} -by_rows", ranks)
            self.assertNotEqual(status, 0)
            self.assertIn("TrefoilMatSetElementValues()", sentence(printed))
        _, _, record = run(ROWS, f"{DIRECT} -by_rows -snes_trefoil_strict false "
                                 "-snes_trefoil_record record.json")
        self.assertGreater(record["solver"]["unfiltered_blocks"], 0)


class OwnRule(Host):
    def test_it_is_used(self):
        for ranks in (1, 2):
            printed, _, record = run(OWN_RULE, f"{DIRECT} -snes_trefoil_record record.json", ranks)
            self.assertTrue(outcome(printed)[0])
            self.assertEqual(record["solver"]["filter"], "quarter_or_absolute")
            self.assertIn(0.25, [entry["weight"] for entry in record["history"]])


class Dolfinx(Host):
    def setUp(self):
        printed, status, _ = run(["/usr/bin/python3", "-c", "import dolfinx"], "")
        if status:
            self.skipTest("python3-dolfinx is not installed")

    def test_stretch_where_stock_fails(self):
        self.assertFalse(self.stock(DOLFINX, "")[0])
        self.same_on_one_and_two_ranks(DOLFINX, "", 20)


if __name__ == "__main__":
    unittest.main(verbosity=2)
