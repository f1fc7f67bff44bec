// Who vouches for a Hessian that the filter may leave indefinite, and what happens where nobody
// does: the default rule on the chain, whose matrices are small enough to be factored here. Runs on
// any number of ranks; needs petsc_main.cpp.

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

/// Cholesky's method on a dense symmetric matrix, row by row.
bool is_definite(std::vector<double> A, std::size_t n) {
  for (std::size_t j = 0; j < n; ++j) {
    if (!(A[j * n + j] > 0)) return false;
    for (std::size_t i = j + 1; i < n; ++i) {
      const double factor = A[i * n + j] / A[j * n + j];
      for (std::size_t k = j; k < n; ++k) A[i * n + k] -= factor * A[j * n + k];
    }
  }
  return true;
}

struct Setting {
  const char *name, *krylov, *preconditioner, *package;
  bool counts_pivots;
};

class DefiniteTest : public testing::TestWithParam<Setting> {
 protected:
  static void choose_solver(Host &host) {
    host.option("ksp_type", GetParam().krylov);
    host.option("ksp_rtol", "1e-10");
    host.option("pc_type", GetParam().preconditioner);
    if (GetParam().package[0]) host.option("pc_factor_mat_solver_type", GetParam().package);
  }
};

/// Of a solve's iterations those with w < 1/2, checked, and the Jacobians that were refused.
struct Seen {
  int taken = 0, refused = 0;
};

void check_iterations(const Host &host, bool counts_pivots, Seen &seen) {
  const auto n = static_cast<std::size_t>(host.chain.vertices);
  PetscMPIInt ranks = 0;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  std::size_t call = 0;
  for (const auto &entry : host.history()) {
    const int refused = entry.at("refused");
    seen.refused += refused;
    call += static_cast<std::size_t>(refused);
    if (call >= host.chain.calls.size()) break;  // the state after the last step
    const JacobianCall &made = host.chain.calls[call++];
    const double weight = entry.at("weight");
    if (weight >= 0.5) {
      EXPECT_TRUE(entry.at("definite_by").is_null());
    } else if (entry.at("step") > 0) {
      std::vector<double> jacobian = made.hessian;
      for (std::size_t i = 0; i < made.negative.size(); ++i)
        jacobian[i] += 2 * weight * made.negative[i];
      EXPECT_TRUE(is_definite(jacobian, n)) << "k " << entry.at("k") << ", w " << weight;
      if (ranks == 1) {
        EXPECT_EQ(entry.at("definite_by"), counts_pivots ? "inertia" : "curvature");
      }
      EXPECT_FALSE(entry.at("definite_by").is_null());
      ++seen.taken;
    }
  }
}

TEST_P(DefiniteTest, NoStepIsTakenWithAnIndefiniteHessian) {
  PetscMPIInt ranks = 0;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 1 && GetParam().package == std::string("petsc")) {
    GTEST_SKIP() << "PETSc's own factors are for one rank";
  }
  Seen seen;
  for (const double anchor : {0.01, 0.05, 0.2, 0.5, 1.0}) {
    for (const double place : {0.5, 0.7, 0.9, 1.2}) {
      Host host;
      host.chain.anchor = anchor;
      host.chain.place = place;
      host.option("snes_trefoil_energy_tolerance", "1e-14");
      choose_solver(host);
      ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
      ASSERT_EQ(host.solve(stretched(host.chain, 0.1, 1.2)), PETSC_SUCCESS);
      EXPECT_GT(host.reason, 0) << anchor << ' ' << place;
      expect_descent(host);
      check_iterations(host, GetParam().counts_pivots, seen);
    }
  }
  EXPECT_GT(seen.taken, 50);
  EXPECT_GT(seen.refused, 20);
}

INSTANTIATE_TEST_SUITE_P(Solvers, DefiniteTest,
                         testing::Values(Setting{"lu", "preonly", "lu", "mumps", false},
                                         Setting{"own_lu", "preonly", "lu", "petsc", true},
                                         Setting{"cholesky", "preonly", "cholesky", "mumps", true},
                                         Setting{"own_cholesky", "preonly", "cholesky", "petsc",
                                                 true},
                                         Setting{"cg", "cg", "jacobi", "", false}),
                         [](const auto &each) { return std::string(each.param.name); });

/// What a direct solver cannot factor it cannot factor the second time.
TEST(FactorTest, FailsOnceAndIsTheAnswer) {
  PetscMPIInt ranks = 0;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 1) GTEST_SKIP() << "PETSc's own factors are for one rank";
  Host host;
  host.chain.anchor = 0;  // every bar is concave: with w = 1/2 the matrix is zero
  host.option("snes_trefoil_filter", "on_demand");
  host.option("pc_factor_mat_solver_type", "petsc");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_EQ(host.reason, SNES_DIVERGED_LINEAR_SOLVE);
  EXPECT_EQ(host.record.at("result").at("factorisations"), 2);
  EXPECT_NE(host.record.at("result").at("reason").get<std::string>().find("ZEROPIVOT"),
            std::string::npos);
}

/// Also where the host never reads options.
TEST(FactorTest, TheDefaultRuleIsAskedBeforeAFailureEndsTheSolve) {
  SNES snes = nullptr;
  PetscInt most = 0;
  ASSERT_EQ(TrefoilInitializePackage(), PETSC_SUCCESS);
  ASSERT_EQ(SNESCreate(PETSC_COMM_WORLD, &snes), PETSC_SUCCESS);
  ASSERT_EQ(SNESSetType(snes, SNESTREFOIL), PETSC_SUCCESS);
  ASSERT_EQ(SNESGetMaxLinearSolveFailures(snes, &most), PETSC_SUCCESS);
  EXPECT_EQ(most, PETSC_MAX_INT);
  ASSERT_EQ(SNESDestroy(&snes), PETSC_SUCCESS);
}

}  // namespace
}  // namespace trefoil::test
