// Is the point where the stop test is met a minimum? A chain whose bars all stand on the hill
// between their two rest lengths is stationary: a saddle, or, with strong anchors, a minimum where
// every bar is indefinite. Runs on any number of ranks; needs petsc_main.cpp.

#include <limits>

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

struct Solver {
  const char *name, *preconditioner, *krylov;
};

class VerifyMinimumTest : public testing::TestWithParam<Solver> {
 protected:
  /// Bars at nearly zero length, where forces vanish and each bar's curvature is -1.
  static void place_on_hill(Host &host, double anchor) {
    host.chain.place = 0;
    host.chain.anchor = anchor;
    host.option("pc_type", GetParam().preconditioner);
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
                                         Solver{"lu", "lu", "preonly"},
                                         Solver{"conjugate_gradients", "jacobi", "cg"}),
                         [](const auto &each) { return each.param.name; });

TEST(VerifyMinimum, CostsNothingWhereNoElementIsIndefinite) {
  Host host;
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
