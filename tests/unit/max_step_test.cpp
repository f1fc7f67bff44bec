// An energy that is defined on a part of space only, with a barrier at its edge whose other side is
// finite, as with unsigned distances: the host says how far a step may go. Needs petsc_main.cpp.

#include <gtest/gtest.h>
#include <petscksp.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "plugin_fixture.hpp"
#include "trefoil.h"

namespace trefoil::test {
namespace {

/// f(x) = sum_i (x_i - log |x_i|) + k/2 sum_i (x_i - x_{i-1})^2, minimum 1 for all x_i, meant for
/// x > 0. A Newton step from x_i = 9 leads to -63.
class Barrier {
 public:
  explicit Barrier(PetscInt unknowns) {
    EXPECT_EQ(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, unknowns, unknowns, 3,
                           nullptr, 2, nullptr, &H_),
              0);
    EXPECT_EQ(MatCreateVecs(H_, &x_, nullptr), 0);
    EXPECT_EQ(SNESCreate(PETSC_COMM_WORLD, &snes), 0);
    EXPECT_EQ(SNESSetOptionsPrefix(snes, "barrier_"), 0);
  }
  Barrier(const Barrier &) = delete;
  Barrier &operator=(const Barrier &) = delete;
  ~Barrier() {
    for (const std::string &name : options_)
      static_cast<void>(PetscOptionsClearValue(nullptr, name.c_str()));
    static_cast<void>(SNESDestroy(&snes));
    static_cast<void>(MatDestroy(&H_));
    static_cast<void>(VecDestroy(&x_));
  }

  void option(const std::string &name, const std::string &value) {
    options_.push_back("-barrier_" + name);
    EXPECT_EQ(PetscOptionsSetValue(nullptr, options_.back().c_str(), value.c_str()), 0);
  }

  PetscErrorCode solve(bool limited) {
    KSP ksp = nullptr;
    PC pc = nullptr;
    const char *text = nullptr;
    PetscFunctionBeginUser;
    PetscCall(TrefoilInitializePackage());
    PetscCall(SNESSetType(snes, SNESTREFOIL));
    PetscCall(SNESSetObjective(snes, energy, this));
    PetscCall(SNESSetFunction(snes, nullptr, gradient, this));
    PetscCall(TrefoilSNESSetSplitJacobian(snes, H_, hessian, this));
    if (limited) PetscCall(TrefoilSNESSetMaxStep(snes, largest_step, this));
    PetscCall(SNESSetTolerances(snes, 1e-10, 0, 0, 60, 10000));
    PetscCall(SNESGetKSP(snes, &ksp));
    PetscCall(KSPSetType(ksp, KSPPREONLY));
    PetscCall(KSPGetPC(ksp, &pc));
    PetscCall(PCSetType(pc, PCCHOLESKY));
    PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
    PetscCall(SNESSetFromOptions(snes));
    PetscCall(VecSet(x_, 9));
    PetscCall(SNESSolve(snes, nullptr, x_));
    PetscCall(SNESGetConvergedReason(snes, &reason));
    PetscCall(whole(x_, &solution));
    PetscCall(TrefoilSNESGetRecord(snes, &text));
    record = nlohmann::json::parse(text);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  SNES snes = nullptr;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  std::vector<double> solution;
  nlohmann::json record;
  int gradients_beyond = 0;  ///< asked for at a point beyond the barrier
  int asked = 0;             ///< for the largest step
  int most_steps = 1000;     ///< of these; the next one is 0

 private:
  static constexpr double k = 0.1;

  static PetscErrorCode energy(SNES, Vec x, PetscReal *value, void *) {
    std::vector<double> v;
    PetscFunctionBeginUser;
    PetscCall(whole(x, &v));
    *value = 0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      *value += v[i] - std::log(std::abs(v[i]));
      if (i > 0) *value += k / 2 * (v[i] - v[i - 1]) * (v[i] - v[i - 1]);
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  static PetscErrorCode gradient(SNES, Vec x, Vec g, void *ctx) {
    std::vector<double> v;
    PetscFunctionBeginUser;
    PetscCall(whole(x, &v));
    std::vector<double> values(v.size());
    bool beyond = false;
    for (std::size_t i = 0; i < v.size(); ++i) {
      beyond = beyond || !(v[i] > 0);
      values[i] += 1 - 1 / v[i];
      if (i == 0) continue;
      values[i] += k * (v[i] - v[i - 1]);
      values[i - 1] -= k * (v[i] - v[i - 1]);
    }
    static_cast<Barrier *>(ctx)->gradients_beyond += beyond;
    PetscCall(fill(g, values));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  static PetscErrorCode hessian(SNES, Vec x, Mat H, Mat *, TrefoilSplitStatistics *statistics,
                                void *) {
    std::vector<double> v;
    PetscInt begin = 0, end = 0;
    PetscFunctionBeginUser;
    PetscCall(whole(x, &v));
    PetscCall(MatZeroEntries(H));
    PetscCall(MatGetOwnershipRange(H, &begin, &end));
    for (PetscInt i = begin; i < end; ++i) {
      const double at = v[static_cast<std::size_t>(i)];
      const PetscInt pair[] = {i - 1, i};
      const PetscScalar spring[] = {k, -k, -k, k};
      PetscCall(MatSetValue(H, i, i, 1 / (at * at), ADD_VALUES));
      if (i > 0) PetscCall(MatSetValues(H, 2, pair, 2, pair, spring, ADD_VALUES));
      ++statistics->elements;
    }
    PetscCall(MatAssemblyBegin(H, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(H, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  /// Nine tenths of the way to the first wall.
  static PetscErrorCode largest_step(SNES, Vec x, Vec d, PetscReal first, PetscReal *largest,
                                     void *ctx) {
    std::vector<double> v, direction;
    PetscFunctionBeginUser;
    auto &host = *static_cast<Barrier *>(ctx);
    ++host.asked;
    PetscCall(whole(x, &v));
    PetscCall(whole(d, &direction));
    *largest = host.asked > host.most_steps ? 0 : first;
    for (std::size_t i = 0; i < v.size(); ++i)
      if (direction[i] < 0) *largest = std::min(*largest, -0.9 * v[i] / direction[i]);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  std::vector<std::string> options_;
  Mat H_ = nullptr;
  Vec x_ = nullptr;
};

TEST(MaxStepTest, KeepsTheSearchOnItsSideOfABarrier) {
  for (const char *search : {"armijo", "subspace"}) {
    Barrier host(7);
    host.option("snes_trefoil_search", search);
    host.option("snes_trefoil_trust_start", "true");
    host.option("snes_trefoil_corrections", "3");
    ASSERT_EQ(host.solve(true), PETSC_SUCCESS);
    EXPECT_GT(host.reason, 0) << search;
    for (const double x : host.solution) EXPECT_NEAR(x, 1, 1e-8) << search;
    EXPECT_EQ(host.gradients_beyond, 0) << search;
    EXPECT_GT(host.asked, 0);
    const auto &history = host.record.at("history");
    EXPECT_EQ(history[0].at("truncated"), true) << search;
    EXPECT_LT(history[0].at("step"), 1);
    EXPECT_EQ(history.back().at("truncated"), false);
    // Factors of a step that was cut short are not used again.
    for (const auto &entry : history) {
      if (entry.at("truncated")) {
        EXPECT_EQ(entry.at("corrections"), 0) << search;
      }
    }
  }
}

TEST(MaxStepTest, WhereNoStepIsAllowedTheSolveEnds) {
  for (const char *search : {"armijo", "subspace"}) {
    Barrier host(7);
    host.most_steps = 2;
    host.option("snes_trefoil_search", search);
    ASSERT_EQ(host.solve(true), PETSC_SUCCESS);
    EXPECT_EQ(host.reason, SNES_DIVERGED_LINE_SEARCH) << search;
    EXPECT_EQ(host.record.at("result").at("reason"), "no step along the direction is allowed");
    EXPECT_EQ(host.record.at("history").size(), 3U);
    for (const double x : host.solution) EXPECT_GT(x, 0);
  }
}

TEST(MaxStepTest, WithoutItTheSearchGoesThrough) {
  Barrier host(7);
  ASSERT_EQ(host.solve(false), PETSC_SUCCESS);
  EXPECT_GT(host.gradients_beyond, 0);
  for (const auto &entry : host.record.at("history")) EXPECT_EQ(entry.at("truncated"), false);
}

/// The iterations that a rule was told of.
PetscErrorCode remember(SNES, const TrefoilIteration *last, PetscReal *weight, void *ctx) {
  PetscFunctionBeginUser;
  static_cast<std::vector<PetscInt> *>(ctx)->push_back(last ? last->k : -1);
  *weight = 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(MaxStepTest, ATruncatedStepTeachesTheRuleNothing) {
  std::vector<PetscInt> told;
  Barrier host(7);
  ASSERT_EQ(TrefoilRuleRegister("remember", remember, &told), PETSC_SUCCESS);
  host.option("snes_trefoil_filter", "remember");
  ASSERT_EQ(host.solve(true), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  const auto &history = host.record.at("history");
  ASSERT_GE(told.size(), 4U);
  PetscInt lesson = -1;
  for (std::size_t k = 0; k < told.size(); ++k) {
    EXPECT_EQ(told[k], lesson) << k;
    if (!history[k].at("truncated")) lesson = static_cast<PetscInt>(k);
  }
}

TEST(MaxStepTest, TheDescentFromASaddleBeginsThere) {
  constexpr double limit = 1.0 / 64;
  Host host;
  host.chain.place = 0;
  host.option("snes_trefoil_verify_minimum", "true");
  host.option("pc_type", "cholesky");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const auto largest = [](SNES, Vec, Vec, PetscReal, PetscReal *step, void *) {
    *step = limit;
    return PetscErrorCode(PETSC_SUCCESS);
  };
  ASSERT_EQ(TrefoilSNESSetMaxStep(host.snes, largest, nullptr), PETSC_SUCCESS);
  ASSERT_EQ(SNESSetTolerances(host.snes, 0, 0, 0, 2, 10000), PETSC_SUCCESS);
  std::vector<double> hill;
  for (PetscInt i = 0; i < host.chain.vertices; ++i) hill.push_back(1e-7 * ((i * 7) % 5 - 2));
  ASSERT_EQ(host.solve(hill), PETSC_SUCCESS);
  EXPECT_GE(host.record.at("result").at("saddles_left"), 1);
  EXPECT_LE(host.history()[0].at("step"), limit);
  EXPECT_EQ(host.history()[0].at("truncated"), true);
}

TEST(MaxStepTest, WhatKnowsNoLargestStepIsRefused) {
  {
    Barrier host(5);
    host.option("snes_type", "newtonls");
    host.option("snes_linesearch_type", "basic");
    const QuietErrors quiet;
    EXPECT_EQ(host.solve(true), PETSC_ERR_SUP);
  }
  Barrier host(5);
  SNESLineSearch search = nullptr;
  ASSERT_EQ(SNESGetLineSearch(host.snes, &search), PETSC_SUCCESS);
  const auto halve = [](SNESLineSearch, Vec, Vec d, Vec, PetscBool *changed, PetscBool *, void *) {
    *changed = PETSC_TRUE;
    return VecScale(d, 0.5);
  };
  ASSERT_EQ(SNESLineSearchSetPostCheck(search, halve, nullptr), PETSC_SUCCESS);
  const QuietErrors quiet;
  EXPECT_EQ(host.solve(true), PETSC_ERR_ARG_INCOMP);
}

}  // namespace
}  // namespace trefoil::test
