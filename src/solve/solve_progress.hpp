#pragma once

#include <petscsnes.h>

#include "output/progress.hpp"

namespace trefoil {

/// Lines about a solve that takes long: after its iterations, and within its linear solves.
class SolveProgress {
 public:
  explicit SolveProgress(Progress &progress) : progress_(progress) {}
  SolveProgress(const SolveProgress &) = delete;
  SolveProgress &operator=(const SolveProgress &) = delete;

  /// This object must outlive the SNES. Collective.
  PetscErrorCode watch(SNES snes);

 private:
  static PetscErrorCode after_iteration(SNES snes, PetscInt iteration, PetscReal, void *self);
  static PetscErrorCode after_linear_iteration(KSP ksp, PetscInt iteration, PetscReal, void *self);

  Progress &progress_;
  SNES snes_ = nullptr;
};

}  // namespace trefoil
