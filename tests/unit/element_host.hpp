#pragma once

// A host that knows nothing of Trefoil, for the tests of the element hook: its SNES has the energy
// |x - 1|^2 / 2, and a Jacobian that a test adds as it likes.

#include <gtest/gtest.h>
#include <petscksp.h>
#include <petscsnes.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "element_matrices.hpp"
#include "trefoil.h"

namespace trefoil::test {

/// Keeps the first error's sentence; none is printed.
class CaughtError {
 public:
  CaughtError() { EXPECT_EQ(PetscPushErrorHandler(keep, this), 0); }
  ~CaughtError() { EXPECT_EQ(PetscPopErrorHandler(), 0); }
  CaughtError(const CaughtError &) = delete;
  CaughtError &operator=(const CaughtError &) = delete;

  std::string sentence;

 private:
  static PetscErrorCode keep(MPI_Comm, int, const char *, const char *, PetscErrorCode code,
                             PetscErrorType type, const char *text, void *context) {
    auto &error = *static_cast<CaughtError *>(context);
    if (type == PETSC_ERROR_INITIAL && error.sentence.empty() && text) error.sentence = text;
    return code;
  }
};

/// A Jacobian callback that has these elements only.
inline auto filled_with(const Elements &elements) {
  return [&elements](Mat H) {
    PetscFunctionBeginUser;
    PetscCall(MatZeroEntries(H));
    PetscCall(add_elements(H, elements, Way::values));
    PetscFunctionReturn(PETSC_SUCCESS);
  };
}

class ElementHost {
 public:
  /// Adds to H what the Jacobian has, and finishes its assembly.
  using Callback = std::function<PetscErrorCode(Mat H)>;

  explicit ElementHost(std::string prefix = "host_") : prefix_(std::move(prefix)) {}
  ElementHost(const ElementHost &) = delete;
  ElementHost &operator=(const ElementHost &) = delete;
  ~ElementHost() {
    for (const std::string &name : options_)
      static_cast<void>(PetscOptionsClearValue(nullptr, name.c_str()));
    static_cast<void>(SNESDestroy(&snes));
    static_cast<void>(MatDestroy(&H));
    static_cast<void>(VecDestroy(&x_));
  }

  void option(const std::string &name, const std::string &value) {
    options_.push_back("-" + prefix_ + name);
    EXPECT_EQ(PetscOptionsSetValue(nullptr, options_.back().c_str(), value.c_str()), 0);
  }

  /// A solve of type trefoil with this constant weight, unless an option says otherwise.
  void weigh(double weight) {
    option("snes_trefoil_filter", "constant");
    option("snes_trefoil_weight", std::to_string(weight));
  }

  /// H may be there already.
  PetscErrorCode solve(PetscInt nodes, PetscInt block, const Callback &callback,
                       PetscInt iterations = 1) {
    KSP ksp = nullptr;
    PC pc = nullptr;
    const char *record_text = nullptr;
    PetscFunctionBeginUser;
    callback_ = callback;
    matrices.clear();
    if (!H) PetscCall(make_matrix(MATAIJ, nodes, block, &H));
    if (!x_) PetscCall(MatCreateVecs(H, &x_, nullptr));
    PetscCall(VecSet(x_, 0));
    if (!snes) {
      PetscCall(TrefoilInitializePackage());
      PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
      PetscCall(SNESSetOptionsPrefix(snes, prefix_.c_str()));
      PetscCall(SNESSetType(snes, SNESTREFOIL));
      if (dm) PetscCall(SNESSetDM(snes, dm));
      PetscCall(SNESSetObjective(snes, energy, this));
      PetscCall(SNESSetFunction(snes, nullptr, residual, this));
      PetscCall(SNESSetJacobian(snes, H, H, jacobian, this));
      PetscCall(SNESSetTolerances(snes, 1e-12, 1e-12, 0, iterations, PETSC_DEFAULT));
      PetscCall(SNESGetKSP(snes, &ksp));
      PetscCall(KSPSetType(ksp, KSPPREONLY));  // the energy's own Hessian is the identity
      PetscCall(KSPGetPC(ksp, &pc));
      PetscCall(PCSetType(pc, PCNONE));
      PetscCall(KSPSetPreSolve(ksp, look, this));
      PetscCall(SNESSetFromOptions(snes));
    }
    PetscCall(SNESSolve(snes, nullptr, x_));
    PetscCall(TrefoilSNESGetRecord(snes, &record_text));
    record = nlohmann::json::parse(record_text);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  [[nodiscard]] PetscInt64 unfiltered() const {
    return record.at("solver").at("unfiltered_blocks").get<PetscInt64>();
  }

  SNES snes = nullptr;
  DM dm = nullptr;  ///< borrowed
  Mat H = nullptr;
  std::vector<Dense> matrices;  ///< that KSP was given
  nlohmann::json record;
  std::function<PetscErrorCode()> in_residual;
  double energy_offset = 0;  ///< added to the energy, for each unknown

 private:
  static PetscErrorCode energy(SNES, Vec x, PetscReal *value, void *context) {
    PetscScalar square = 0, sum = 0;
    PetscInt size = 0;
    PetscFunctionBeginUser;
    PetscCall(VecDot(x, x, &square));
    PetscCall(VecSum(x, &sum));
    PetscCall(VecGetSize(x, &size));
    *value = square / 2 - sum +
             static_cast<ElementHost *>(context)->energy_offset * static_cast<double>(size);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  static PetscErrorCode residual(SNES, Vec x, Vec f, void *context) {
    auto &host = *static_cast<ElementHost *>(context);
    PetscFunctionBeginUser;
    if (host.in_residual) PetscCall(host.in_residual());
    PetscCall(VecCopy(x, f));
    PetscCall(VecShift(f, -1));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  static PetscErrorCode jacobian(SNES, Vec, Mat, Mat H, void *context) {
    PetscFunctionBeginUser;
    PetscCall(static_cast<ElementHost *>(context)->callback_(H));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  static PetscErrorCode look(KSP ksp, Vec, Vec, void *context) {
    Mat matrix = nullptr;
    PetscFunctionBeginUser;
    PetscCall(KSPGetOperators(ksp, nullptr, &matrix));
    static_cast<ElementHost *>(context)->matrices.push_back(dense(matrix));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  std::string prefix_;
  std::vector<std::string> options_;
  Callback callback_;
  Vec x_ = nullptr;
};

}  // namespace trefoil::test
