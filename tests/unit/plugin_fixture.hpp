#pragma once

// A SNES that solves the chain of chain.hpp, as a host would set it up, and what came of it.

#include <gtest/gtest.h>
#include <petscksp.h>

#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "chain.hpp"

namespace trefoil::test {

/// The matrix that KSP was given, and the weight that the plugin named at that time.
struct LinearSolve {
  std::vector<double> matrix;
  double weight = 0;
};

inline PetscErrorCode look_at_matrix(KSP ksp, Vec, Vec, void *ctx);

/// One host: its SNES, its callbacks' problem, its options under its own prefix.
class Host {
 public:
  explicit Host(std::string prefix = "chain_") : prefix_(std::move(prefix)) {}
  Host(const Host &) = delete;
  Host &operator=(const Host &) = delete;

  ~Host() {
    for (const std::string &name : options_)
      static_cast<void>(PetscOptionsClearValue(nullptr, name.c_str()));
    static_cast<void>(SNESDestroy(&snes));
    free_problem();
  }

  void option(const std::string &name, const std::string &value) {
    options_.push_back("-" + prefix_ + name);
    EXPECT_EQ(PetscOptionsSetValue(nullptr, options_.back().c_str(), value.c_str()), PETSC_SUCCESS);
  }

  /// Makes the SNES of type trefoil with a direct solver; its options have the last word.
  PetscErrorCode set_up() {
    KSP ksp = nullptr;
    PC pc = nullptr;
    PetscFunctionBeginUser;
    PetscCall(TrefoilInitializePackage());
    PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
    PetscCall(SNESSetOptionsPrefix(snes, prefix_.c_str()));
    PetscCall(SNESSetType(snes, SNESTREFOIL));
    PetscCall(set_problem());
    if (with_energy_scale) PetscCall(TrefoilSNESSetEnergyScale(snes, chain_scale, &chain));
    PetscCall(SNESGetKSP(snes, &ksp));
    PetscCall(KSPSetType(ksp, KSPPREONLY));
    PetscCall(KSPGetPC(ksp, &pc));
    PetscCall(PCSetType(pc, PCLU));
    PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
    PetscCall(KSPSetPreSolve(ksp, look_at_matrix, this));
    PetscCall(SNESSetFromOptions(snes));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  /// Vectors, matrix and callbacks for the chain as it is now.
  PetscErrorCode set_problem() {
    PetscFunctionBeginUser;
    free_problem();
    PetscCall(chain_matrix(chain, &hessian_));
    PetscCall(MatCreateVecs(hessian_, &x_, &residual_));
    if (with_objective) PetscCall(SNESSetObjective(snes, chain_energy, &chain));
    PetscCall(SNESSetFunction(snes, residual_, chain_gradient, &chain));
    PetscCall(TrefoilSNESSetSplitJacobian(snes, hessian_, chain_hessian, &chain));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  PetscErrorCode solve(const std::vector<double> &start) {
    const char *text = nullptr;
    PetscFunctionBeginUser;
    chain.calls.clear();
    linear_solves.clear();
    chain.energies = chain.residuals = 0;
    PetscCall(fill(x_, start));
    PetscCall(SNESSolve(snes, nullptr, x_));
    PetscCall(whole(x_, &solution));
    PetscCall(SNESGetConvergedReason(snes, &reason));
    PetscCall(TrefoilSNESGetRecord(snes, &text));
    text_of_record = text;
    record = nlohmann::json::parse(text_of_record, nullptr, false);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  [[nodiscard]] const nlohmann::json &history() const { return record.at("history"); }
  [[nodiscard]] double gradient_norm() const {
    double sum = 0;
    for (const double g : chain.gradient(solution)) sum += g * g;
    return std::sqrt(sum);
  }

  Chain chain;
  bool with_objective = true, with_energy_scale = true;
  SNES snes = nullptr;
  std::vector<double> solution;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  std::string text_of_record;
  nlohmann::json record;
  std::vector<LinearSolve> linear_solves;

 private:
  void free_problem() {
    static_cast<void>(VecDestroy(&x_));
    static_cast<void>(VecDestroy(&residual_));
    static_cast<void>(MatDestroy(&hessian_));
  }

  std::string prefix_;
  std::vector<std::string> options_;
  Vec x_ = nullptr, residual_ = nullptr;
  Mat hessian_ = nullptr;
};

inline PetscErrorCode look_at_matrix(KSP ksp, Vec, Vec, void *ctx) {
  auto &host = *static_cast<Host *>(ctx);
  LinearSolve seen;
  Mat matrix = nullptr;
  PetscReal weight = 0;
  PetscFunctionBeginUser;
  PetscCall(KSPGetOperators(ksp, &matrix, nullptr));
  PetscCall(whole(matrix, &seen.matrix));
  PetscCall(TrefoilSNESGetWeight(host.snes, &weight));
  seen.weight = weight;
  host.linear_solves.push_back(std::move(seen));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Bars stretched to between `low` and `high` rest lengths, at random.
inline std::vector<double> stretched(const Chain &chain, double low, double high) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> stretch(low, high);
  std::vector<double> x;
  double end = 0;
  for (PetscInt e = 0; e < chain.vertices; ++e)
    x.push_back(end += stretch(engine) * chain.length_unit);
  return x;
}

/// Every bar on the hill between its two rest lengths: no bar is convex there.
inline std::vector<double> concave_start(const Chain &chain) {
  return stretched(chain, 0.1, 0.45);
}
/// Every bar near its rest length.
inline std::vector<double> convex_start(const Chain &chain) {
  return stretched(chain, 1.05, 1.5);
}

/// The energies of the history never rise by more than rounding.
inline void expect_descent(const Host &host) {
  for (std::size_t k = 1; k < host.history().size(); ++k) {
    const double before = host.history()[k - 1].at("energy"),
                 after = host.history()[k].at("energy");
    EXPECT_LE(after, before + 1e-13 * std::abs(before)) << k;
  }
}

/// Errors are returned and not printed for the life of this object.
class QuietErrors {
 public:
  QuietErrors() { EXPECT_EQ(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr), 0); }
  ~QuietErrors() { EXPECT_EQ(PetscPopErrorHandler(), 0); }
  QuietErrors(const QuietErrors &) = delete;
  QuietErrors &operator=(const QuietErrors &) = delete;
};

}  // namespace trefoil::test
