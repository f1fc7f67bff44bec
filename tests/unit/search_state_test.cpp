// What a solve carries from one iteration to the next: taken from a monitor or after the solve,
// through the numbers of a checkpoint, and given to another SNES. Needs petsc_main.cpp.

#include <cmath>
#include <limits>

#include "plugin_fixture.hpp"
#include "solve/saved_numbers.hpp"

namespace trefoil::test {
namespace {

/// A search state with a previous step of its own, as a file holds it.
struct Saved {
  nlohmann::ordered_json numbers;
  std::vector<double> x;
  Vec previous_step = nullptr;
  PetscInt at = 0;  ///< iterations before it is taken

  Saved() = default;
  Saved(const Saved &) = delete;
  Saved &operator=(const Saved &) = delete;
  ~Saved() { static_cast<void>(VecDestroy(&previous_step)); }

  static PetscErrorCode take(SNES snes, PetscInt iteration, PetscReal, void *self) {
    auto &saved = *static_cast<Saved *>(self);
    TrefoilSearchState state;
    Vec x = nullptr;
    PetscFunctionBeginUser;
    if (iteration != saved.at) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(TrefoilSNESGetSearchState(snes, &state));
    saved.numbers = nlohmann::ordered_json::parse(json_of(state).dump());
    if (state.previous_step) {
      PetscCall(VecDuplicate(state.previous_step, &saved.previous_step));
      PetscCall(VecCopy(state.previous_step, saved.previous_step));
    }
    PetscCall(SNESGetSolution(snes, &x));
    PetscCall(whole(x, &saved.x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  PetscErrorCode give(SNES snes) const {
    TrefoilSearchState state = search_state_of(numbers);
    PetscFunctionBeginUser;
    state.previous_step = previous_step;
    PetscCall(TrefoilSNESSetSearchState(snes, &state));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};

struct Case {
  const char *filter, *search;
  bool is_refused;  ///< a Jacobian on the way is indefinite, and the rule has to remember that
};

class SearchStateTest : public testing::TestWithParam<Case> {
 protected:
  static void set_up(Host &host) {
    host.option("snes_trefoil_filter", GetParam().filter);
    host.option("snes_trefoil_search", GetParam().search);
    host.option("snes_trefoil_rho_tolerance", "0.9");  // rules below clamp try early
    host.option("pc_type", "cholesky");
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  }
};

TEST_P(SearchStateTest, AnotherSnesGoesOnAsTheFirstWouldHave) {
  std::size_t iterations = 3;
  bool was_refused = false;
  for (PetscInt at = 1; at < static_cast<PetscInt>(iterations); ++at) {
    Host run("one_"), rest("two_");
    Saved saved;
    saved.at = at;
    set_up(run);
    set_up(rest);
    ASSERT_EQ(SNESMonitorSet(run.snes, Saved::take, &saved, nullptr), PETSC_SUCCESS);
    ASSERT_EQ(run.solve(concave_start(run.chain)), PETSC_SUCCESS);
    iterations = run.history().size();
    was_refused = was_refused || saved.numbers.contains("refused_decrement");
    ASSERT_EQ(saved.give(rest.snes), PETSC_SUCCESS);
    ASSERT_EQ(rest.solve(saved.x), PETSC_SUCCESS);
    ASSERT_EQ(rest.history().size() + static_cast<std::size_t>(at), iterations);
    for (std::size_t k = 0; k < rest.history().size(); ++k) {
      const auto &mine = rest.history()[k];
      const auto &its = run.history()[k + static_cast<std::size_t>(at)];
      EXPECT_EQ(mine.at("weight"), its.at("weight")) << "from " << at << ", " << k;
      EXPECT_EQ(mine.at("refused"), its.at("refused")) << "from " << at << ", " << k;
      EXPECT_NEAR(mine.at("energy").get<double>(), its.at("energy").get<double>(), 1e-11);
    }
  }
  EXPECT_GT(iterations, 4u);
  EXPECT_EQ(was_refused, GetParam().is_refused);
}

INSTANTIATE_TEST_SUITE_P(Filters, SearchStateTest,
                         testing::Values(Case{"adaptive", "subspace", false},
                                         Case{"multiplicative", "armijo", false},
                                         Case{"three_state", "subspace", false},
                                         Case{"newton_first", "armijo", true}));

/// A rule that was refused Newton's Hessian waits with another attempt in the next run, too.
TEST(SearchStateRuleTest, WhatARuleWasRefusedIsGivenBack) {
  for (const auto &[refused, weight] :
       {std::pair(1.0, 0.125), std::pair(std::numeric_limits<double>::infinity(), 0.0)}) {
    Host host;
    TrefoilSearchState state{};
    host.option("snes_trefoil_filter", "newton_first");
    host.option("pc_type", "cholesky");
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    state.has_last = PETSC_TRUE;
    state.last = {.k = 3,
                  .energy = 1,
                  .weight = 0.5,
                  .rho = 1,
                  .step = 1,
                  .trials = 1,
                  .decrement = 1,
                  .indefinite = 0};
    state.refused_decrement = refused;
    ASSERT_EQ(TrefoilSNESSetSearchState(host.snes, &state), PETSC_SUCCESS);
    ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
    EXPECT_EQ(host.history().front().at("weight"), weight);
  }
}

TEST(SearchNumbersTest, NumbersSurviveTheFile) {
  TrefoilSearchState state{};
  state.trusts_model = PETSC_TRUE;
  state.proxy_scale = 0.1 + 0.2;
  state.refused_decrement = 1e-300;
  state.has_last = PETSC_TRUE;
  state.last = {3, -1.0 / 3, 0.5, std::nan(""), 0.64, 4, 1e17 + 1, 0.25};
  const TrefoilSearchState back =
      search_state_of(nlohmann::ordered_json::parse(json_of(state).dump()));
  EXPECT_EQ(back.trusts_model, PETSC_TRUE);
  EXPECT_EQ(back.proxy_scale, state.proxy_scale);
  EXPECT_EQ(back.refused_decrement, state.refused_decrement);
  ASSERT_EQ(back.has_last, PETSC_TRUE);
  EXPECT_EQ(back.last.k, 3);
  EXPECT_EQ(back.last.energy, state.last.energy);
  EXPECT_EQ(back.last.weight, 0.5);
  EXPECT_TRUE(std::isnan(back.last.rho));
  EXPECT_EQ(back.last.step, 0.64);
  EXPECT_EQ(back.last.trials, 4);
  EXPECT_EQ(back.last.decrement, state.last.decrement);
  EXPECT_EQ(back.last.indefinite, 0.25);
}

TEST(SearchNumbersTest, NothingLearnedIsNothing) {
  TrefoilSearchState state{};
  state.refused_decrement = std::numeric_limits<double>::infinity();
  const TrefoilSearchState back =
      search_state_of(nlohmann::ordered_json::parse(json_of(state).dump()));
  EXPECT_EQ(back.has_last, PETSC_FALSE);
  EXPECT_EQ(back.trusts_model, PETSC_FALSE);
  EXPECT_TRUE(std::isinf(back.refused_decrement));
}

TEST(SearchNumbersTest, ASolveThatRunsIsNotToldWhereToGoOn) {
  Host host;
  const auto interfere = [](SNES snes, PetscInt iteration, PetscReal, void *outcome) {
    TrefoilSearchState state;
    PetscFunctionBeginUser;
    PetscCall(TrefoilSNESGetSearchState(snes, &state));
    const QuietErrors quiet;
    if (iteration == 1)
      *static_cast<PetscErrorCode *>(outcome) = TrefoilSNESSetSearchState(snes, &state);
    PetscFunctionReturn(PETSC_SUCCESS);
  };
  PetscErrorCode outcome = PETSC_SUCCESS;
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(SNESMonitorSet(host.snes, interfere, &outcome, nullptr), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_EQ(outcome, PETSC_ERR_ORDER);
}

}  // namespace
}  // namespace trefoil::test
