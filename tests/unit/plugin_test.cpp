// The plugin as a host sees it, through include/trefoil.h: does it find the minimum, and does it
// know when it does not? Runs on any number of ranks; needs petsc_main.cpp.

#include <limits>

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

struct Setting {
  const char *filter, *linear_solver;
};

class ConvergenceTest : public testing::TestWithParam<Setting> {};

TEST_P(ConvergenceTest, FindsAMinimumFromAConcaveStart) {
  Host host;
  host.option("snes_trefoil_filter", GetParam().filter);
  if (GetParam().filter == std::string("constant")) host.option("snes_trefoil_weight", "0.75");
  host.option("snes_trefoil_energy_tolerance", "1e-14");
  if (GetParam().linear_solver == std::string("cg")) {
    host.option("ksp_type", "cg");
    host.option("ksp_rtol", "1e-12");
    host.option("pc_type", "jacobi");
  } else {
    host.option("pc_type", GetParam().linear_solver);
  }
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const std::vector<double> start = concave_start(host.chain);
  ASSERT_EQ(host.chain.indefinite(start), host.chain.vertices);
  ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_LT(host.gradient_norm(), 1e-6);
  EXPECT_LT(host.chain.energy(host.solution), host.chain.energy(start));
  EXPECT_EQ(host.chain.indefinite(host.solution), 0);  // a minimum, not only a stationary point
  expect_descent(host);
}

INSTANTIATE_TEST_SUITE_P(Filters, ConvergenceTest,
                         testing::Values(Setting{"adaptive", "lu"}, Setting{"adaptive", "cholesky"},
                                         Setting{"adaptive", "cg"}, Setting{"clamp", "lu"},
                                         Setting{"clamp", "cg"}, Setting{"absolute", "lu"},
                                         Setting{"absolute", "cg"}, Setting{"constant", "lu"}),
                         [](const auto &each) {
                           return each.param.filter + std::string("_") + each.param.linear_solver;
                         });

/// A solve that ends without a step: not converged, x and energy as they were.
void expect_refusal(const Host &host, const std::vector<double> &start) {
  EXPECT_LT(host.reason, 0);
  EXPECT_EQ(host.solution, start);
  EXPECT_FALSE(host.record.at("result").at("converged"));
  EXPECT_EQ(host.history().size(), 1u);
  EXPECT_EQ(host.history()[0].at("step"), 0);
}

TEST(NewtonTest, RefusesADirectionThatAscends) {
  Host host;
  host.chain.anchor = 1e-4;  // too weak for the concave bars: the Hessian is negative definite
  host.option("snes_trefoil_filter", "newton");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const std::vector<double> start = concave_start(host.chain);
  ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
  expect_refusal(host, start);
  EXPECT_EQ(host.reason, SNES_DIVERGED_LINEAR_SOLVE);
}

TEST(NewtonTest, RefusesAnIndefiniteHessianEvenIfTheDirectionDescends) {
  Host host;
  host.option("snes_trefoil_filter", "newton");
  host.option("pc_type", "cholesky");
  host.option("pc_factor_mat_solver_type", "mumps");  // whose factors tell
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  std::vector<double> start = convex_start(host.chain);
  // One concave bar; the force on the rest decides where the direction goes.
  for (std::size_t i = 12; i < start.size(); ++i) start[i] -= 0.9;
  ASSERT_EQ(host.chain.indefinite(start), 1);
  ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
  expect_refusal(host, start);
  EXPECT_NE(host.record.at("result").at("reason").get<std::string>().find("indefinite"),
            std::string::npos);
}

TEST(NewtonTest, ConvergesWhereTheEnergyIsConvex) {
  Host host;
  host.option("snes_trefoil_filter", "newton");
  host.option("pc_type", "cholesky");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  for (const JacobianCall &call : host.chain.calls) EXPECT_FALSE(call.asked);  // N is not wanted
}

class NotFiniteTest : public testing::TestWithParam<double> {};

INSTANTIATE_TEST_SUITE_P(Values, NotFiniteTest,
                         testing::Values(std::numeric_limits<double>::quiet_NaN(),
                                         std::numeric_limits<double>::infinity(),
                                         -std::numeric_limits<double>::infinity()));

TEST_P(NotFiniteTest, ASearchBacksOffFromIt) {
  Host host;
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  // The first energy is that of the start; then three trials of the first search.
  host.chain.disturb_energy = [](int n, double energy) {
    return 2 <= n && n <= 4 ? GetParam() : energy;
  };
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_GE(host.history()[0].at("trials"), 4);
  EXPECT_LE(host.history()[0].at("step").get<double>(), 0.8 * 0.8 * 0.8 * (1 + 1e-12));
  EXPECT_LT(host.gradient_norm(), 1e-3);
  expect_descent(host);
}

TEST_P(NotFiniteTest, EverywhereButAtTheStartItFailsTheSearch) {
  Host host;
  host.option("snes_linesearch_max_it", "7");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  host.chain.disturb_energy = [](int n, double energy) { return n > 1 ? GetParam() : energy; };
  const std::vector<double> start = concave_start(host.chain);
  ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
  expect_refusal(host, start);
  EXPECT_EQ(host.reason, SNES_DIVERGED_LINE_SEARCH);
  EXPECT_EQ(host.record.at("result").at("line_search_trials"), 7);
}

TEST_P(NotFiniteTest, AtTheStartItEndsTheSolve) {
  Host host;
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  host.chain.disturb_energy = [](int, double) { return GetParam(); };
  const std::vector<double> start = concave_start(host.chain);
  ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
  expect_refusal(host, start);
  EXPECT_TRUE(host.history()[0].at("energy").is_null());  // JSON knows no NaN
}

TEST(ResidualTest, NotANumberEndsTheSolve) {
  for (const int first_bad : {1, 3}) {
    Host host;
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    host.chain.spoil_residual = [=](int n) { return n >= first_bad; };
    ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
    EXPECT_LT(host.reason, 0) << first_bad;
    EXPECT_FALSE(host.record.at("result").at("converged"));
    for (const double x : host.solution) EXPECT_TRUE(std::isfinite(x));
  }
}

TEST(StopTest, TheDecrementIsMeasuredBeforeTheStepAndXStays) {
  Host host;
  host.option("snes_trefoil_decrement_tolerance", "1e-5");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_EQ(host.solution, host.chain.calls.back().x);
  const auto &history = host.history();
  for (std::size_t k = 0; k + 1 < history.size(); ++k) EXPECT_GE(history[k].at("decrement"), 1e-5);
  EXPECT_LT(history.back().at("decrement"), 1e-5);
  EXPECT_GT(history.back().at("decrement"), 0);
}

TEST(StopTest, AtTheMinimumNothingMoves) {
  Host exact;
  exact.chain.place = 1;  // anchors and bars agree: a gradient of exactly zero
  ASSERT_EQ(exact.set_up(), PETSC_SUCCESS);
  const std::vector<double> rest = stretched(exact.chain, 1, 1);
  ASSERT_EQ(exact.solve(rest), PETSC_SUCCESS);
  EXPECT_GT(exact.reason, 0);
  EXPECT_EQ(exact.solution, rest);
  EXPECT_TRUE(exact.record.at("result").at("converged"));

  Host rounded;
  ASSERT_EQ(rounded.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(rounded.solve(concave_start(rounded.chain)), PETSC_SUCCESS);
  const std::vector<double> minimum = rounded.solution;
  ASSERT_EQ(rounded.solve(minimum), PETSC_SUCCESS);
  EXPECT_GT(rounded.reason, 0);
  EXPECT_EQ(rounded.solution, minimum);
  EXPECT_EQ(rounded.record.at("result").at("iterations"), 1);
  EXPECT_EQ(rounded.record.at("result").at("line_search_trials"), 0);
}

class TightToleranceTest : public testing::TestWithParam<double> {};

// Long before the decrement is that small, energies differ by rounding only; a constant in the
// energy makes it worse.
TEST_P(TightToleranceTest, RoundingDoesNotFailTheSearch) {
  Host host;
  host.chain.constant = GetParam();
  host.option("snes_trefoil_decrement_tolerance", "1e-20");
  host.option("snes_rtol", "0");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0) << host.record.at("result").at("reason");
  EXPECT_LT(host.gradient_norm(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Constants, TightToleranceTest, testing::Values(0, 1e3, -1e6, 1e9));

// Rounding keeps the decrement from getting there: the iterations run out, and no search fails.
TEST(StopTest, AToleranceBelowRoundingIsNoFailedSearch) {
  Host host;
  host.option("snes_trefoil_energy_tolerance", "1e-40");
  host.option("snes_rtol", "0");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_TRUE(host.reason > 0 || host.reason == SNES_DIVERGED_MAX_IT) << host.reason;
  EXPECT_LT(host.gradient_norm(), 1e-12);
  expect_descent(host);
}

TEST(StopTest, PetscsOwnToleranceWork) {
  struct Row {
    const char *option, *value;
    SNESConvergedReason reason;
  };
  for (const Row &row : {Row{"snes_atol", "1e-3", SNES_CONVERGED_FNORM_ABS},
                         Row{"snes_rtol", "1e-3", SNES_CONVERGED_FNORM_RELATIVE},
                         Row{"snes_max_it", "3", SNES_DIVERGED_MAX_IT}}) {
    Host host;
    host.option("snes_trefoil_filter", "adaptive");  // one Jacobian an iteration
    host.option("snes_trefoil_energy_tolerance", "0");
    host.option("snes_rtol", "0");
    host.option(row.option, row.value);
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    const std::vector<double> start = concave_start(host.chain);
    ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
    EXPECT_EQ(host.reason, row.reason) << row.option;
    // The state after the last step closes the history, without a direction of its own.
    const auto directions = host.chain.calls.size();
    EXPECT_EQ(host.record.at("result").at("iterations"), directions) << row.option;
    EXPECT_EQ(host.history().size(), directions + 1) << row.option;
    EXPECT_EQ(host.history().back().at("step"), 0);
    EXPECT_NEAR(host.history().back().at("energy"), host.chain.energy(host.solution), 1e-14);
    EXPECT_NEAR(host.history().back().at("gradient_norm"), host.gradient_norm(), 1e-12);
    if (row.reason == SNES_DIVERGED_MAX_IT) {
      EXPECT_EQ(directions, 3u);
    }
    expect_descent(host);
  }
}

class UnitsTest : public testing::TestWithParam<std::pair<double, double>> {};

TEST_P(UnitsTest, DoNotChangeTheIterations) {
  Host plain, scaled("scaled_");
  std::tie(scaled.chain.energy_unit, scaled.chain.length_unit) = GetParam();
  for (Host *host : {&plain, &scaled}) {
    ASSERT_EQ(host->set_up(), PETSC_SUCCESS);
    ASSERT_EQ(host->solve(concave_start(host->chain)), PETSC_SUCCESS);
    EXPECT_GT(host->reason, 0);
  }
  ASSERT_EQ(scaled.history().size(), plain.history().size());
  for (std::size_t k = 0; k < plain.history().size(); ++k) {
    const auto &one = plain.history()[k], &other = scaled.history()[k];
    for (const char *key : {"weight", "step", "trials"}) EXPECT_EQ(other.at(key), one.at(key));
    EXPECT_NEAR(other.at("energy").get<double>() / GetParam().first, one.at("energy"), 1e-9);
  }
  for (std::size_t i = 0; i < plain.solution.size(); ++i)
    EXPECT_NEAR(scaled.solution[i] / GetParam().second, plain.solution[i], 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Units, UnitsTest,
                         testing::Values(std::pair{1e12, 1.0}, std::pair{1e-12, 1.0},
                                         std::pair{1.0, 1e3}, std::pair{1e12, 1e-3},
                                         std::pair{1e-12, 1e3}));

}  // namespace
}  // namespace trefoil::test
