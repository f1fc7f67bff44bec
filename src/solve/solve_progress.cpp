#include "solve/solve_progress.hpp"

#include <cmath>
#include <sstream>

#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

namespace trefoil {

PetscErrorCode SolveProgress::watch(SNES snes) {
  KSP ksp = nullptr;
  PetscFunctionBeginUser;
  if (!progress_.is_on()) PetscFunctionReturn(PETSC_SUCCESS);
  snes_ = snes;
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(SNESMonitorSet(snes, after_iteration, this, nullptr));
  PetscCall(KSPMonitorSet(ksp, after_linear_iteration, this, nullptr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A monitor of the SNES.
PetscErrorCode SolveProgress::after_iteration(SNES snes, PetscInt iteration, PetscReal,
                                              void *self) {
  PetscInt linear_iterations = 0;
  PetscReal ratio = 0;
  std::ostringstream text;
  PetscFunctionBeginUser;
  PetscCall(SNESGetLinearSolveIterations(snes, &linear_iterations));
  PetscCall(TrefoilSNESGetDecrementRatio(snes, &ratio));
  text << "iteration " << iteration << ", " << linear_iterations << " linear iterations";
  text.precision(2);
  if (std::isfinite(ratio)) text << ", decrement " << ratio << " times its tolerance";
  PetscCall(static_cast<SolveProgress *>(self)->progress_.pass(text.str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A monitor of the KSP, whose iterations are too many for a word between ranks after each.
PetscErrorCode SolveProgress::after_linear_iteration(KSP, PetscInt iteration, PetscReal,
                                                     void *self) {
  auto &solve = *static_cast<SolveProgress *>(self);
  PetscInt newton = 0;
  PetscFunctionBeginUser;
  if (!solve.progress_.is_due()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetIterationNumber(solve.snes_, &newton));
  std::ostringstream text;
  text << "iteration " << newton + 1;
  if (iteration > 0) text << ", linear iteration " << iteration;  // factors need none
  solve.progress_.show(text.str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
