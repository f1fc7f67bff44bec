// The plugin in the hands of hosts that do more than one solve, and of users who mistype: several
// solves, several SNES, other types of SNES, options. Needs petsc_main.cpp.

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

/// The iterations of a record, without what differs from run to run.
nlohmann::json iterations_of(const Host &host) {
  nlohmann::json history = host.history();
  for (auto &entry : history) entry.erase("seconds");
  return history;
}

/// The result without what differs from run to run.
nlohmann::json solve_afresh(const std::vector<double> &start, PetscInt vertices,
                            const char *search = "armijo") {
  Host host("fresh_");
  host.option("snes_trefoil_search", search);
  host.chain.vertices = vertices;
  EXPECT_EQ(host.set_up(), PETSC_SUCCESS);
  EXPECT_EQ(host.solve(start), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  return iterations_of(host);
}

class SecondSolveTest : public testing::TestWithParam<const char *> {
 protected:
  SecondSolveTest() { host.option("snes_trefoil_search", GetParam()); }
  Host host;
};

INSTANTIATE_TEST_SUITE_P(Searches, SecondSolveTest, testing::Values("armijo", "subspace"),
                         [](const auto &each) { return std::string(each.param); });

TEST_P(SecondSolveTest, RemembersNothingOfTheFirst) {
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const std::vector<double> concave = concave_start(host.chain), convex = convex_start(host.chain);
  for (const auto &start : {concave, concave, convex, concave}) {
    ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
    EXPECT_GT(host.reason, 0);
    EXPECT_EQ(iterations_of(host), solve_afresh(start, host.chain.vertices, GetParam()));
  }
}

TEST_P(SecondSolveTest, FollowsASolveThatFailed) {
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const std::vector<double> start = concave_start(host.chain);
  host.chain.disturb_energy = [](int, double) { return std::nan(""); };
  ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
  EXPECT_LT(host.reason, 0);
  host.chain.disturb_energy = nullptr;
  ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_EQ(iterations_of(host), solve_afresh(start, host.chain.vertices, GetParam()));
}

TEST_P(SecondSolveTest, FollowsASolveThatEndedInAnError) {
#if !PETSC_VERSION_LT(3, 25, 0)
  GTEST_SKIP() << "PETSc leaves vectors locked where a residual has failed";
#endif
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const std::vector<double> start = concave_start(host.chain);
  for (const char *type : {SNESTREFOIL, SNESNEWTONLS}) {
    ASSERT_EQ(SNESSetType(host.snes, type), PETSC_SUCCESS);
    SNESLineSearch search = nullptr;
    ASSERT_EQ(SNESGetLineSearch(host.snes, &search), PETSC_SUCCESS);
    ASSERT_EQ(SNESLineSearchSetType(search, SNESLINESEARCHTREFOIL), PETSC_SUCCESS);
    ASSERT_EQ(SNESSetFromOptions(host.snes), PETSC_SUCCESS);
    host.chain.fail_residual = [](int n) { return n == 4; };
    {
      const QuietErrors quiet;
      EXPECT_EQ(host.solve(start), PETSC_ERR_USER);
    }
    host.chain.fail_residual = nullptr;
    ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
    EXPECT_GT(host.reason, 0);
    EXPECT_EQ(iterations_of(host), solve_afresh(start, host.chain.vertices, GetParam())) << type;
  }
}

TEST_P(SecondSolveTest, AfterAResetTheProblemMayHaveAnotherSize) {
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  for (const PetscInt vertices : {31, 7}) {
    ASSERT_EQ(SNESReset(host.snes), PETSC_SUCCESS);
    host.chain.vertices = vertices;
    ASSERT_EQ(host.set_problem(), PETSC_SUCCESS);
    const std::vector<double> start = concave_start(host.chain);
    ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
    EXPECT_GT(host.reason, 0);
    EXPECT_EQ(iterations_of(host), solve_afresh(start, vertices, GetParam()));
  }
}

TEST(TwoSolversTest, KeepTheirOwnOptionsAndMemories) {
  Host clamp("one_"), constant("two_");
  clamp.option("snes_trefoil_filter", "clamp");
  constant.option("snes_trefoil_filter", "constant");
  constant.option("snes_trefoil_weight", "1.5");
  constant.chain.vertices = 17;
  for (Host *host : {&clamp, &constant}) ASSERT_EQ(host->set_up(), PETSC_SUCCESS);
  for (int repeat = 0; repeat < 2; ++repeat)
    for (Host *host : {&clamp, &constant}) {
      ASSERT_EQ(host->solve(concave_start(host->chain)), PETSC_SUCCESS);
      EXPECT_GT(host->reason, 0);
      for (const auto &entry : host->history())
        EXPECT_EQ(entry.at("weight"), host == &clamp ? 0.5 : 1.5);
    }
}

// One solve inside another's callback: an inner problem decides on a coefficient of the outer one.
TEST(TwoSolversTest, OneMayRunInsideTheOther) {
  Host outer("outer_"), inner("inner_");
  for (Host *host : {&outer, &inner}) ASSERT_EQ(host->set_up(), PETSC_SUCCESS);
  const std::vector<double> start = concave_start(outer.chain);
  outer.chain.disturb_energy = [&](int, double energy) {
    EXPECT_EQ(inner.solve(convex_start(inner.chain)), PETSC_SUCCESS);
    EXPECT_GT(inner.reason, 0);
    return energy;
  };
  ASSERT_EQ(outer.solve(start), PETSC_SUCCESS);
  EXPECT_EQ(iterations_of(outer), solve_afresh(start, outer.chain.vertices));
}

TEST(HostTest, ARankMayHaveNoUnknowns) {
  Host host;
  host.chain.vertices = 2;
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
}

TEST(HostTest, MayLeaveTheEnergyScaleOut) {
  Host host;
  host.with_energy_scale = false;
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_EQ(host.reason, SNES_CONVERGED_FNORM_RELATIVE);  // PETSc's own test is left
  Host measured("measured_");
  measured.with_energy_scale = false;
  measured.option("snes_trefoil_energy_tolerance", "1e-4");
  ASSERT_EQ(measured.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(measured.solve(concave_start(measured.chain)), PETSC_SUCCESS);
  EXPECT_GT(measured.reason, 0);
  EXPECT_LT(measured.history().size(), host.history().size());
}

// The search needs energies: it finds them from the residuals, or refuses; it never makes them up.
TEST(HostTest, WithoutAnObjectiveItConvergesOrRefuses) {
  Host host;
  host.with_objective = false;
  host.with_energy_scale = false;
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const QuietErrors quiet;
  if (host.solve(concave_start(host.chain)) == PETSC_SUCCESS) {
    EXPECT_GT(host.reason, 0);
    EXPECT_LT(host.gradient_norm(), 1e-4);
    EXPECT_EQ(host.chain.indefinite(host.solution), 0);
  }
}

TEST(SnesTypeTest, NewtonlsWithOurLineSearchIsTheSame) {
  Host host;
  host.option("snes_type", "newtonls");
  host.option("snes_linesearch_type", "trefoil");
  host.option("snes_stol", "0");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const std::vector<double> start = concave_start(host.chain);
  for (int repeat = 0; repeat < 2; ++repeat) {
    ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
    EXPECT_GT(host.reason, 0);
    EXPECT_EQ(iterations_of(host), solve_afresh(start, host.chain.vertices));
    EXPECT_EQ(host.record.at("solver").at("filter"), "newton_first");
  }
}

TEST(SnesTypeTest, OtherLineSearchesLeaveTheHessianAsItIs) {
  Host host;
  host.option("snes_type", "newtonls");
  host.option("snes_linesearch_type", "basic");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  ASSERT_EQ(host.linear_solves.size(), host.chain.calls.size());
  for (std::size_t k = 0; k < host.chain.calls.size(); ++k) {
    EXPECT_FALSE(host.chain.calls[k].asked);
    for (std::size_t i = 0; i < host.chain.calls[k].hessian.size(); ++i)
      EXPECT_NEAR(host.linear_solves[k].matrix[i], host.chain.calls[k].hessian[i], 1e-13);
  }
}

TEST(SnesTypeTest, TrefoilWithAnotherLineSearchIsAnError) {
  Host host;
  host.option("snes_linesearch_type", "bt");
  const QuietErrors quiet;
  const bool set_up = host.set_up() == PETSC_SUCCESS;
  EXPECT_TRUE(!set_up || host.solve(concave_start(host.chain)) != PETSC_SUCCESS);
}

struct Typo {
  const char *option, *value;
};

class TypoTest : public testing::TestWithParam<Typo> {};

TEST_P(TypoTest, IsAnErrorBeforeTheSolve) {
  Host host;
  host.option(GetParam().option, GetParam().value);
  const QuietErrors quiet;
  EXPECT_NE(host.set_up(), PETSC_SUCCESS);
}

INSTANTIATE_TEST_SUITE_P(
    Options, TypoTest,
    testing::Values(Typo{"snes_trefoil_fliter", "clamp"}, Typo{"snes_trefoil_filter", "clmap"},
                    Typo{"snes_trefoil_", "1"}, Typo{"snes_trefoil_filter_", "clamp"},
                    Typo{"snes_trefoil_rho_tolerance", "-1"},
                    Typo{"snes_trefoil_rho_tolerance", "many"},
                    Typo{"snes_trefoil_search", "wolfe"},
                    Typo{"snes_trefoil_weight", "2"},  // of no use to the default filter
                    Typo{"snes_trefoil_energy_tolerance", "-1e-3"},
                    Typo{"snes_trefoil_decrement_tolerance", "-1"},
                    Typo{"snes_linesearch_shrink", "1"}, Typo{"snes_linesearch_armijo", "0.5"}));

TEST(OptionsTest, SubspaceNeedsAnObjective) {
  Host host;
  host.with_objective = host.with_energy_scale = false;
  host.option("snes_trefoil_search", "subspace");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const QuietErrors quiet;
  EXPECT_EQ(host.solve(concave_start(host.chain)), PETSC_ERR_ARG_WRONGSTATE);
}

TEST(OptionsTest, TheSearchJudgesFailedSolvesUnlessTheUserLimitsThem) {
  Host host;
  PetscInt most = 0;
  host.option("snes_trefoil_filter", "clamp");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(SNESGetMaxLinearSolveFailures(host.snes, &most), PETSC_SUCCESS);
  EXPECT_EQ(most, PETSC_MAX_INT);
  host.option("snes_max_linear_solve_fail", "7");
  ASSERT_EQ(SNESSetFromOptions(host.snes), PETSC_SUCCESS);
  ASSERT_EQ(SNESGetMaxLinearSolveFailures(host.snes, &most), PETSC_SUCCESS);
  EXPECT_EQ(most, 7);
}

TEST(OptionsTest, AnotherPrefixIsNobodysTypo) {
  Host other("other_"), host;
  other.option("snes_trefoil_fliter", "clamp");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
}

/// What PETSc's monitors see of the steps, and the host's own hand in them.
struct Steps {
  Chain *chain;
  std::vector<std::vector<double>> states;
  std::vector<double> norms;  ///< of the step to each state
  double factor = 1;          ///< of the host's on directions
};

PetscErrorCode look_at_step(SNES snes, PetscInt, PetscReal, void *ctx) {
  auto &steps = *static_cast<Steps *>(ctx);
  SNESLineSearch search = nullptr;
  Vec x = nullptr;
  PetscReal x_norm = 0, residual_norm = 0, step_norm = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESGetSolution(snes, &x));
  PetscCall(SNESGetLineSearch(snes, &search));
  PetscCall(SNESLineSearchGetNorms(search, &x_norm, &residual_norm, &step_norm));
  steps.norms.push_back(step_norm);
  PetscCall(whole(x, &steps.states.emplace_back()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode scale_direction(SNESLineSearch, Vec, Vec direction, Vec, PetscBool *changed,
                               PetscBool *, void *ctx) {
  PetscFunctionBeginUser;
  PetscCall(VecScale(direction, static_cast<Steps *>(ctx)->factor));
  *changed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

double distance(const std::vector<double> &a, const std::vector<double> &b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

TEST(HostTest, TheNormOfTheStepIsThatOfTheOneTaken) {
  Host host;
  host.option("snes_trefoil_filter", "clamp");  // whose steps are far too long at first
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  Steps steps{&host.chain, {}, {}};
  ASSERT_EQ(SNESMonitorSet(host.snes, look_at_step, &steps, nullptr), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_LT(host.history()[0].at("step"), 1);
  ASSERT_GE(steps.states.size(), 4u);
  for (std::size_t k = 1; k < 4; ++k)
    EXPECT_NEAR(steps.norms[k] / distance(steps.states[k], steps.states[k - 1]), 1, 1e-10) << k;
}

TEST(HostTest, ADirectionThatItsPostCheckChangesIsTaken) {
  for (const double factor : {0.5, 0.25}) {
    Host host;
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    Steps steps{&host.chain, {}, {}, factor};
    SNESLineSearch search = nullptr;
    ASSERT_EQ(SNESGetLineSearch(host.snes, &search), PETSC_SUCCESS);
    ASSERT_EQ(SNESLineSearchSetPostCheck(search, scale_direction, &steps), PETSC_SUCCESS);
    ASSERT_EQ(SNESMonitorSet(host.snes, look_at_step, &steps, nullptr), PETSC_SUCCESS);
    ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
    Host untouched("untouched_");
    ASSERT_EQ(untouched.set_up(), PETSC_SUCCESS);
    Steps full{&untouched.chain, {}, {}};
    ASSERT_EQ(SNESMonitorSet(untouched.snes, look_at_step, &full, nullptr), PETSC_SUCCESS);
    ASSERT_EQ(untouched.solve(convex_start(untouched.chain)), PETSC_SUCCESS);
    for (std::size_t i = 0; i < full.states[0].size(); ++i)
      EXPECT_NEAR(steps.states[1][i] - steps.states[0][i],
                  factor * (full.states[1][i] - full.states[0][i]), 1e-12);
    EXPECT_GT(host.reason, 0);
  }
}

TEST(OptionsTest, TheSearchTakesItsOwn) {
  Host host;
  host.option("snes_linesearch_shrink", "0.25");
  host.option("snes_linesearch_armijo", "0.3");
  host.option("snes_trefoil_filter", "clamp");  // whose steps are far too long at first
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_GT(host.history()[0].at("trials"), 1);
  for (const auto &entry : host.history()) {
    const double step = entry.at("step"), trials = entry.at("trials");
    if (step == 0) continue;
    EXPECT_EQ(step, std::pow(0.25, trials - 1));
  }
  for (std::size_t k = 0; k + 1 < host.history().size(); ++k) {
    const auto &entry = host.history()[k];
    const double gained =
        entry.at("energy").get<double>() - host.history()[k + 1].at("energy").get<double>();
    EXPECT_GE(
        gained,
        0.3 * entry.at("step").get<double>() * 2 * entry.at("decrement").get<double>() - 1e-14);
  }
}

}  // namespace
}  // namespace trefoil::test
