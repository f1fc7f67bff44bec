// Is the point where the stop test is met a minimum? A chain whose bars all stand on the hill
// between their two rest lengths is stationary: a saddle, or, with strong anchors, a minimum where
// every bar is indefinite. Runs on any number of ranks; needs petsc_main.cpp.

#include <limits>
#include <numbers>

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

struct Solver {
  const char *name, *preconditioner, *krylov;
};

/// The factors that tell whether a matrix is positive definite, on one rank.
void factor_by_cholmod(Host &host) {
  host.option("pc_type", "cholesky");
  host.option("pc_factor_mat_solver_type", MATSOLVERCHOLMOD);
  host.option("mat_cholmod_factor", "SUPERNODAL");
  host.option("mat_cholmod_print", "0");
}
bool cholmod_is_there() {
  PetscMPIInt ranks = 0;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
#if defined(PETSC_HAVE_SUITESPARSE)
  return ranks == 1;
#else
  return false;
#endif
}

class VerifyMinimumTest : public testing::TestWithParam<Solver> {
 protected:
  void SetUp() override {
    if (is_cholmod() && !cholmod_is_there()) GTEST_SKIP() << "CHOLMOD is for one rank";
  }
  static bool is_cholmod() { return GetParam().preconditioner == std::string("cholmod"); }
  /// Bars at nearly zero length, where forces vanish and each bar's curvature is -1.
  static void place_on_hill(Host &host, double anchor) {
    host.chain.place = 0;
    host.chain.anchor = anchor;
    if (is_cholmod()) {
      factor_by_cholmod(host);
    } else {
      host.option("pc_type", GetParam().preconditioner);
    }
    host.option("ksp_type", GetParam().krylov);
    host.option("ksp_rtol", "1e-12");
  }
  static std::vector<double> hill(const Host &host) {
    std::vector<double> start;
    for (PetscInt i = 0; i < host.chain.vertices; ++i) start.push_back(1e-7 * ((i * 7) % 5 - 2));
    return start;
  }
};

TEST_P(VerifyMinimumTest, LeavesASaddle) {
  Host host;
  place_on_hill(host, 0.05);
  host.option("snes_trefoil_verify_minimum", "true");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(hill(host)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  const auto &result = host.record.at("result");
  EXPECT_EQ(result.at("minimum"), true);
  EXPECT_GE(result.at("saddles_left"), 1);
  EXPECT_EQ(host.chain.indefinite(host.solution), 0);
  EXPECT_LT(host.chain.energy(host.solution), 0.5 * host.chain.energy(hill(host)));
  EXPECT_GT(host.history()[0].at("trials"), 0);
  EXPECT_GT(host.history()[0].at("step"), 0);
  expect_descent(host);
  // Off the saddle's top it goes the way that the slope says.
  const std::vector<double> &from = host.chain.calls[0].x, &to = host.chain.calls[1].x,
                            g = host.chain.gradient(from);
  double slope = 0;
  for (std::size_t i = 0; i < g.size(); ++i) slope += g[i] * (to[i] - from[i]);
  EXPECT_LT(slope, 0);
}

TEST_P(VerifyMinimumTest, FindsTheOneNegativeDirectionAmongMany) {
  // All bars at their rest length but one on its hill, and no anchors.
  Host host;
  place_on_hill(host, 0);
  host.option("snes_trefoil_decrement_tolerance", "1e-10");
  host.option("snes_trefoil_verify_minimum", "true");
  std::vector<double> saddle;
  for (PetscInt e = 0; e < host.chain.vertices; ++e)
    saddle.push_back((saddle.empty() ? 0 : saddle.back()) + (e == 11 ? 1e-7 : 1));
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(saddle), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_EQ(host.record.at("result").at("minimum"), true);
  EXPECT_EQ(host.record.at("result").at("saddles_left"), 1);
  EXPECT_NEAR(host.chain.energy(host.solution), 0, 1e-9);
}

TEST_P(VerifyMinimumTest, IsOffUnlessAskedFor) {
  Host host;
  place_on_hill(host, 0.05);
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(hill(host)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_EQ(host.solution, hill(host));
  EXPECT_TRUE(host.record.at("result").at("minimum").is_null());
}

TEST_P(VerifyMinimumTest, KnowsAMinimumWhereEveryElementIsIndefinite) {
  Host host;
  place_on_hill(host, 5);  // the bars' matrix is above -4
  host.option("snes_trefoil_verify_minimum", "true");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(hill(host)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_EQ(host.chain.indefinite(host.solution), host.chain.vertices);
  EXPECT_EQ(host.record.at("result").at("minimum"), true);
  EXPECT_EQ(host.record.at("result").at("saddles_left"), 0);
}

TEST_P(VerifyMinimumTest, DoesNotCallASaddleConvergedThatItCannotLeave) {
  Host host;
  place_on_hill(host, 0.05);
  host.option("snes_trefoil_verify_minimum", "true");
  host.chain.disturb_energy = [](int n, double energy) {
    return n == 1 ? energy : std::numeric_limits<double>::infinity();
  };
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(hill(host)), PETSC_SUCCESS);
  EXPECT_LT(host.reason, 0);
  EXPECT_EQ(host.solution, hill(host));
  const auto &result = host.record.at("result");
  EXPECT_EQ(result.at("converged"), false);
  EXPECT_EQ(result.at("minimum"), false);
  EXPECT_NE(result.at("reason").get<std::string>().find("no minimum"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Solvers, VerifyMinimumTest,
                         testing::Values(Solver{"cholesky", "cholesky", "preonly"},
                                         Solver{"cholmod", "cholmod", "preonly"},
                                         Solver{"lu", "lu", "preonly"},
                                         Solver{"conjugate_gradients", "jacobi", "cg"}),
                         [](const auto &each) { return each.param.name; });

/// Factors of an older matrix, which is definite, say nothing of this one.
TEST_P(VerifyMinimumTest, AsksNoFactorsThatTheSnesLags) {
  Host host;
  place_on_hill(host, 0.05);
  host.option("snes_trefoil_verify_minimum", "true");
  host.option("snes_lag_preconditioner", "-2");
  host.option("snes_lag_preconditioner_persists", "true");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(hill(host)), PETSC_SUCCESS);
  EXPECT_NE(host.record.at("result").at("minimum"), host.chain.indefinite(host.solution) > 0);
}

/// Bars on their hills with anchors that barely hold them: along the softest direction, neighbours
/// against each other, H is a three-hundredth of the filtered Jacobian, whose decrement is as
/// much too small.
TEST(VerifyMinimum, NewtonsOwnDecrementDecides) {
  if (!cholmod_is_there()) GTEST_SKIP() << "CHOLMOD is for one rank";
  double tolerance = 1, errors[2], iterations[2];
  for (int run = 0; run < 2; ++run) {
    Host host;
    host.chain.place = 0;
    host.chain.anchor = 4.01;
    factor_by_cholmod(host);
    host.option("snes_trefoil_verify_minimum", "true");
    host.option("snes_trefoil_energy_tolerance", nlohmann::json(tolerance).dump());
    std::vector<double> start;
    for (PetscInt i = 0; i < host.chain.vertices; ++i)
      start.push_back(0.01 * std::sin(47 * std::numbers::pi * (i + 1) / 49));
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
    EXPECT_GT(host.reason, 0);
    const auto &result = host.record.at("result");
    EXPECT_EQ(result.at("minimum"), true);
    // At the bottom, where all bars have no length, each has an energy of 1/4.
    errors[run] = host.chain.energy(host.solution) - 0.25 * host.chain.vertices;
    iterations[run] = result.at("iterations");
    EXPECT_NEAR(result.at("error_estimate").get<double>() / errors[run], 1, 0.1) << run;
    const double scale = result.at("energy_scale");
    // The next run takes this one's filtered decrement for small enough.
    tolerance = 1.1 * host.history()[0].at("decrement").get<double>() / scale;
  }
  EXPECT_EQ(iterations[0], 1);
  EXPECT_GT(iterations[1], 1);
  EXPECT_LT(errors[1], 1e-2 * errors[0]);
}

TEST(VerifyMinimum, CostsNothingWhereNoElementIsIndefinite) {
  Host host;
  host.option("snes_trefoil_filter", "adaptive");  // the default asks about w = 0 on its way
  host.option("snes_trefoil_verify_minimum", "true");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
  EXPECT_EQ(host.record.at("result").at("minimum"), true);
  EXPECT_EQ(host.record.at("result").at("verification_solves"), 0);
}

TEST(VerifyMinimum, ADecrementToleranceTurnsTheDefaultOff) {
  for (const bool asked : {false, true}) {
    Host host;
    host.chain.place = 0;
    host.option("snes_trefoil_decrement_tolerance", "1e-8");
    if (asked) host.option("snes_trefoil_verify_minimum", "true");
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    ASSERT_EQ(host.solve(std::vector<double>(24, 1e-7)), PETSC_SUCCESS);
    EXPECT_EQ(host.record.at("result").at("minimum").is_null(), !asked);
  }
}

TEST(VerifyMinimum, NewtonWithoutFactorsDoesNotKnow) {
  Host host;
  host.option("snes_trefoil_verify_minimum", "true");
  host.option("snes_trefoil_filter", "newton");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_TRUE(host.record.at("result").at("minimum").is_null());
}

}  // namespace
}  // namespace trefoil::test
