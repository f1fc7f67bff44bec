"""Which linear solver runs, and that its answer is the same whichever it is."""
import re
import subprocess
import unittest

from trefoil_program import PROGRAM, environment, record_of, refusal_of, run

BOX = ["-mesh_generate", "box", "-constraints", "held,pulled", "-constraint_held_where",
       "x == xmin", "-constraint_pulled_where", "x == xmax", "-constraint_pulled_move",
       "1, 1-z-y, y-z"]


def box(resolution, *options):
    return [*BOX, "-mesh_resolution", str(resolution), *options]


def linear(record):
    return f'{record["solver"]["linear"]} ({record["solver"]["linear_reason"]})'


def megabytes(text):
    """The first size in a sentence."""
    number, unit = re.search(r"([0-9.]+) (MB|GB)", text).groups()
    return float(number) * (1000 if unit == "GB" else 1)


LIMIT = 700 * 1000 ** 2  # bytes of address space; the program and its libraries take 470 MB of it


def run_within(limit, options, ranks=1):
    """A run whose ranks may each take no more than `limit`."""
    words = ["mpirun", "-n", str(ranks), "prlimit", f"--as={limit}", PROGRAM, *options]
    return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          env=environment(), timeout=100, check=False)


class ChoiceTest(unittest.TestCase):
    def test_small_bodies_are_factored(self):
        for ranks, package in (1, "cholmod"), (2, "mumps"):
            record = record_of(box(4), ranks)
            self.assertIn(f"Cholesky by {package} (384 tetrahedra", linear(record))
            self.assertIn("linear solver: Cholesky", record["printed"])

    def test_bulky_bodies_are_not(self):
        record = record_of(box(18, "-snes_max_it", "1"), 2)
        self.assertIn("cg with gamg (34992 tetrahedra; a Cholesky factor would take "
                      "about", linear(record))

    def test_conjugate_gradients_need_no_matrix_of_negative_parts(self):
        direct, iterative = (record_of(box(6, "-material_poisson", "0.45", "-solver", solver))
                             for solver in ("direct", "iterative"))
        self.assertGreater(max(entry["indefinite"] or 0 for entry in iterative["history"]), 0)
        scale = direct["result"]["energy_scale"]
        self.assertLess(abs(direct["result"]["energy"] - iterative["result"]["energy"]), 1e-8 * scale)
        self.assertLess(iterative["memory"]["matrix_bytes"], 0.6 * direct["memory"]["matrix_bytes"])
        # Where H has to be looked at alone, the two stay apart.
        tested = run(box(2, "-solver", "iterative", "-snes_test_jacobian", "-snes_max_it", "2"))
        ratios = re.findall(r"\|\|J - Jfd\|\|_F/\|\|J\|\|_F = ([0-9.e+-]+)", tested.stdout)
        self.assertTrue(ratios)
        self.assertLess(max(map(float, ratios)), 1e-5)

    def test_coarse_levels_are_small(self):
        """With PETSc's one level of large aggregates 1.31 times the entries of the Hessian."""
        viewed = run(box(20, "-material_poisson", "0.495", "-solver", "iterative", "-snes_max_it", "1",
                         "-snes_view")).stdout
        self.assertLess(float(re.search(r"operator = ([0-9.]+)", viewed)[1]), 1.27)

    def test_the_wish_and_then_petscs_options_win(self):
        self.assertIn("cg with gamg",
                      linear(record_of(box(4, "-solver", "iterative"))))
        self.assertIn("minres with jacobi (as -pc_type says)",
                      linear(record_of(box(4, "-solver", "iterative", "-pc_type", "jacobi",
                                           "-ksp_type", "minres"))))
        self.assertIn("fgmres with gamg",
                      linear(record_of(box(4, "-solver", "iterative", "-ksp_type", "fgmres"))))
        result = run(box(4, "-solver", "fast"))
        self.assertEqual(result.returncode, 1)
        self.assertIn("auto, direct, iterative", result.stdout)

    def test_factors_that_are_named_are_the_direct_solvers(self):
        """With corrections, and without conjugate gradients around them."""
        default = record_of(box(4))
        for options, solver in (
                (["-pc_type", "cholesky"], "Cholesky by cholmod (as -pc_type says)"),
                (["-solver", "direct", "-pc_type", "cholesky"], "Cholesky by cholmod (as -pc_type"),
                (["-pc_type", "lu"], "LU by mumps (as -pc_type says)"),
                (["-pc_factor_mat_solver_type", "mumps"], "Cholesky by mumps (384 tetrahedra"),
                (["-solver", "direct", "-pc_factor_mat_solver_type", "petsc"],
                 "Cholesky by petsc (384 tetrahedra")):
            with self.subTest(options=options):
                record = record_of(box(4, *options))
                self.assertIn(solver, linear(record))
                for count in "iterations", "linear_solves":
                    self.assertEqual(record["result"][count], default["result"][count])
        self.assertIn("cg with Cholesky by cholmod",
                      linear(record_of(box(4, "-pc_type", "cholesky", "-ksp_type", "cg"))))

    def test_a_wish_that_a_preconditioner_contradicts_is_said_to_lose(self):
        for wish, preconditioner in ("direct", "gamg"), ("iterative", "cholesky"):
            record = record_of(box(4, "-solver", wish, "-pc_type", preconditioner))
            self.assertIn(f"(as -pc_type says, which wins over -solver {wish})", linear(record))

    def test_packages_without_such_factors_are_refused(self):
        package = ["-pc_factor_mat_solver_type", "cholmod"]
        self.assertIn("no Cholesky factors of that name on 2 ranks; without the option they are "
                      "those of mumps", refusal_of(box(2, "-pc_type", "cholesky", *package), 2))
        self.assertIn("no LU factors of that name on 1 rank",
                      refusal_of(box(2, "-pc_type", "lu", *package)))

    def test_the_factors_size_is_known_beforehand(self):
        record = record_of(box(16, "-solver", "direct", "-initial", "rest"))
        ratio = record["memory"]["factor_bytes"] / 1e6 / megabytes(linear(record))
        self.assertLess(abs(ratio - 1), 0.2)

    def test_what_does_not_fit_is_not_factored(self):
        result = run_within(LIMIT, box(24, "-snes_max_it", "0", "-initial", "rest"))
        self.assertRegex(result.stdout, r"gamg \(82944 tetrahedra; a Cholesky factor would need "
                         r"about [0-9.]+ MB of the [0-9.]+ MB free\)")


class AccuracyTest(unittest.TestCase):
    def test_inexact_directions_end_at_the_same_energy(self):
        for poisson in "0.3", "0.495":
            for ranks in 1, 2:
                direct, iterative = (
                    record_of(box(8, "-material_poisson", poisson, "-solver", kind), ranks)
                    for kind in ("direct", "iterative"))
                for record in direct, iterative:
                    self.assertEqual(record["status"], 0, record["printed"])
                scale = direct["result"]["energy_scale"]
                above = iterative["result"]["energy"] - direct["result"]["energy"]
                self.assertLess(above / scale, 1e-8)

    def test_a_coarse_solve_does_not_fool_the_stop_test(self):
        # Half of the residual: the decrements of such directions are far too small.
        options = ["-ksp_rtol", "0.9", "-snes_trefoil_take_last", "false"]
        direct = record_of(box(8, "-solver", "direct"))
        coarse = record_of(box(8, "-solver", "iterative", *options))
        self.assertEqual(coarse["status"], 0, coarse["printed"])
        above = coarse["result"]["energy"] - direct["result"]["energy"]
        self.assertLess(above / direct["result"]["energy_scale"], 1e-7)

    def test_the_state_after_the_last_direction_has_no_solve_of_its_own(self):
        """It is followed with the iterative solver: one line more than iterations."""
        record = record_of(box(4, "-solver", "iterative"))
        last = record["history"][-1]
        self.assertEqual(len(record["history"]), record["result"]["iterations"] + 1)
        self.assertEqual((last["decrement"], last["step"], last["linear_iterations"]), (None, 0, 0))
        line = next(line.split() for line in record["printed"].splitlines()
                    if line.split()[:1] == [str(last["k"])])
        self.assertEqual(line[8], "0")

    def verdict(self, record):
        self.assertEqual(record["status"], 0, record["printed"])
        return next(line for line in record["printed"].splitlines()
                    if line.startswith("converged in"))

    def test_a_last_solve_that_may_not_go_on_is_said_to_be_no_measure(self):
        for options in (["-ksp_type", "preonly", "-pc_type", "jacobi"],
                        ["-ksp_type", "preonly", "-pc_type", "gamg"],
                        ["-solver", "iterative", "-ksp_max_it", "1"]):
            record = record_of(box(4, *options))
            self.assertGreater(record["result"]["linear_residual"], 0.01)
            self.assertRegex(self.verdict(record), r"the energy error is not known: the last "
                             r"linear solve left [0-9.]+ of the gradient")
        for options in [], ["-solver", "iterative"]:
            record = record_of(box(4, *options))
            self.assertLess(record["result"]["linear_residual"], 0.01)
            self.assertNotIn("is not known: the last", self.verdict(record))

    def test_an_unknown_end_is_said_to_be_unknown(self):
        iterative = box(8, "-solver", "iterative", "-material_poisson", "0.495")
        bounded = record_of(iterative)  # thirty solves tell nothing there
        self.assertIsNone(bounded["result"]["minimum"])
        self.assertTrue(any("is a minimum is not known" in note
                            for note in bounded["solver"]["notes"]))
        self.assertLessEqual(bounded["result"]["verification_solves"], 60)
        left_out = record_of(box(4, "-solver", "iterative", "-snes_trefoil_verify_minimum",
                                 "false"))
        for record in bounded, left_out:
            self.assertIn("; unverified", self.verdict(record))
        patient = record_of([*iterative, "-snes_trefoil_verify_share", "0"])
        for record in patient, record_of(box(4)):
            self.assertIs(record["result"]["minimum"], True)
            self.assertNotIn("unverified", self.verdict(record))


class RetryTest(unittest.TestCase):
    """What follows where conjugate gradients fail."""

    # The smoother of the second level amplifies: no preconditioner for conjugate gradients.
    BROKEN = ["-mg_levels_ksp_type", "richardson", "-mg_levels_ksp_richardson_scale", "-1"]

    def test_a_fresh_preconditioner_lets_the_solve_go_on(self):
        # Bounds of the first Jacobian make the smoothers of a later one indefinite.
        record = record_of(box(6, "-solver", "iterative", "-material_poisson", "0.495",
                               "-pc_gamg_use_sa_esteig", "true"))
        self.assertEqual(record["status"], 0, record["printed"])
        self.assertGreater(record["result"]["factorisations"], record["result"]["iterations"])
        direct = record_of(box(6, "-solver", "direct", "-material_poisson", "0.495"))
        above = record["result"]["energy"] - direct["result"]["energy"]
        self.assertLess(above / direct["result"]["energy_scale"], 1e-8)

    def test_a_failure_that_stays_names_its_cause_and_the_way_out(self):
        for ranks in 1, 2:
            record = record_of(box(6, "-solver", "iterative", *self.BROKEN), ranks)
            self.assertEqual(record["status"], 3, record["printed"])
            verdict = next(line for line in record["printed"].splitlines()
                           if line.startswith("NOT CONVERGED"))
            self.assertRegex(verdict, r"with a fresh preconditioner as well \(DIVERGED_INDEFINITE_PC\)"
                             r": use a direct one, or tune it by -ksp_\* and -pc_\*")
            self.assertGreater(record["result"]["factorisations"], record["result"]["iterations"])


    def test_it_is_the_same_with_a_solver_of_the_users(self):
        """Where it fails by itself; what it has reached within its iterations is a direction."""
        record = record_of(box(4, "-pc_type", "jacobi", "-ksp_type", "richardson",
                               "-ksp_richardson_scale", "100"))
        self.assertEqual(record["status"], 3, record["printed"])
        self.assertRegex(record["result"]["reason"], r"^the linear solver failed, with a fresh "
                         r"preconditioner as well \(DIVERGED_DTOL\): use a direct one, or tune it")
        self.assertGreater(record["result"]["factorisations"], record["result"]["iterations"])
        for preconditioner in "jacobi", "gamg":
            record = record_of(box(4, "-pc_type", preconditioner, "-ksp_max_it", "5"))
            self.assertEqual(record["status"], 0, record["printed"])
        others = record_of(box(4, "-pc_type", "jacobi", "-ksp_max_it", "5", "-snes_type",
                               "newtonls"))
        self.assertRegex(others["result"]["reason"],
                         r"^the linear solver failed \(DIVERGED_ITS\): use a direct one, or")


class QuadraticTest(unittest.TestCase):
    """p-multigrid: linear elements under quadratic ones."""

    def both(self, options, ranks=1):
        """Records of p-multigrid and of factors, which must end at the same energy."""
        records = [record_of([*options, "-order", "2", "-solver", kind], ranks)
                   for kind in ("iterative", "direct")]
        for record in records:
            self.assertEqual(record["status"], 0, record["printed"])
        multigrid, direct = records
        self.assertIn("cg with p-multigrid over", linear(multigrid))
        above = multigrid["result"]["energy"] - direct["result"]["energy"]
        self.assertLess(above / direct["result"]["energy_scale"], 1e-8)
        return records

    def test_conjugate_gradients_take_as_many_iterations_on_finer_meshes(self):
        for poisson, most in ("0.3", 20), ("0.45", 25), ("0.495", 60):
            iterations = []
            for resolution in 3, 4, 6:
                record = self.both(box(resolution, "-material_poisson", poisson))[0]
                iterations.append(sum(entry["linear_iterations"] for entry in record["history"]))
            self.assertLess(max(iterations), most)
            self.assertLess(max(iterations), 1.3 * min(iterations))

    def test_aggregation_alone_takes_more_of_them(self):
        ours, plain = (record_of(box(6, "-order", "2", "-material_poisson", "0.495", "-solver",
                                     "iterative", *options))
                       for options in ([], ["-pc_type", "gamg"]))
        self.assertIn("cg with gamg", linear(plain))
        self.assertLess(2 * sum(entry["linear_iterations"] for entry in ours["history"]),
                        sum(entry["linear_iterations"] for entry in plain["history"]))

    def test_ranks_components_slides_and_load_steps(self):
        by_component = ["-constraint_held_move", "0, free, free"]
        oblique = ["-constraint_held_slide", "1, 0.2, 0"]
        for ranks in 1, 2, 3:
            for options in ([], by_component, oblique, ["-load_steps", "2"]):
                with self.subTest(ranks=ranks, options=options):
                    self.both(box(3, "-material_poisson", "0.45", *options), ranks)
        self.both(["-mesh_generate", "square", "-mesh_resolution", "8", *BOX[2:-1], "0.5, 0.3*y"])

    def test_one_pressure_an_element_is_for_it_whatever_poissons_ratio(self):
        """The last direction, the one that is solved to a thousandth, takes more iterations the
        nearer Poisson's ratio is to 1/2, but not on a finer mesh; the energy is that of factors."""
        pressure = ["-element_pressure", "constant", "-material_model", "neo_hookean",
                    "-constraint_pulled_move", "0.2, -0.2*y, 0.2*z"]
        for poisson, most in ("0.4999", 100), ("0.49999", 300):
            coarse, fine = (self.both(box(resolution, "-material_poisson", poisson, *pressure))[0]
                            ["history"][-2]["linear_iterations"] for resolution in (3, 5))
            self.assertLess(fine, most)
            self.assertLess(fine, 1.5 * coarse)
        start = ["-order", "2", "-snes_max_it", "0", "-initial", "rest", "-material_poisson",
                 "0.4999"]
        self.assertIn("cg with p-multigrid over cholesky (10368 tetrahedra; a Cholesky factor "
                      "would take about", linear(record_of(box(12, *start, *pressure[:2]))))
        self.assertIn("is too much for multigrid", linear(record_of(
            box(12, *start, "-element_pressure", "pointwise"))))

    def test_it_is_chosen_by_size_and_takes_petscs_options(self):
        start = ["-order", "2", "-snes_max_it", "0", "-initial", "rest"]
        self.assertIn("cg with p-multigrid over cholesky", linear(record_of(box(10, *start))))
        self.assertIn("Cholesky by", linear(record_of(box(3, *start))))
        self.assertIn("cg with p-multigrid over gamg",
                      linear(record_of(box(3, "-order", "2", "-pc_type", "mg",
                                           "-mg_coarse_pc_type", "gamg",
                                           "-mg_levels_ksp_max_it", "2"))))
        refused = run(box(3, "-order", "2", "-solver", "iterative", "-mg_coarse_pc_typ", "gamg"))
        self.assertEqual(refused.returncode, 1)
        self.assertIn("mg_coarse_pc_typ", refused.stdout)


class MemoryTest(unittest.TestCase):
    def check(self, result):
        self.assertEqual(result.returncode, 3, result.stdout)
        self.assertRegex(result.stdout, "out of memory")

    def test_factors_that_do_not_fit(self):
        for ranks in 1, 2:
            result = run_within(LIMIT, box(24, "-solver", "direct", "-initial", "rest"), ranks)
            self.check(result)
            self.assertIn("trefoil: out of memory for the factors of the linear solver: -solver "
                          "iterative needs much less; else", result.stdout)
            self.assertNotIn("NOT CONVERGED", result.stdout)

    def test_no_room_for_the_library_of_linear_algebra(self):
        """Which would ask for its buffer for ever."""
        for ranks in 1, 2:
            self.check(run_within(400 * 1000 ** 2, box(2), ranks))

    def test_matrices_that_do_not_fit(self):
        for ranks in 1, 2:
            self.check(run_within(LIMIT, box(40, "-initial", "rest"), ranks))


if __name__ == "__main__":
    unittest.main()
