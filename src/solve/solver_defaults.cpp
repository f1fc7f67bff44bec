#include "solve/solver_defaults.hpp"

#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

namespace trefoil {

PetscErrorCode set_program_defaults(SNES snes) {
  PetscFunctionBeginUser;
  PetscCall(TrefoilSNESSetMonitor(snes, PETSC_TRUE));
  PetscCall(TrefoilSNESSetFilter(snes, "adaptive"));
  PetscCall(TrefoilSNESSetSearch(snes, TREFOIL_SEARCH_SUBSPACE));
  PetscCall(TrefoilSNESSetVerifyMinimum(snes, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_defaults(SNES snes) {
  PetscReal absolute = 0, step = 0;
  PetscInt iterations = 0, functions = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESSetType(snes, SNESTREFOIL));
  // The residual at the start is that of crushed elements: no measure for the one at the end.
  PetscCall(SNESGetTolerances(snes, &absolute, nullptr, &step, &iterations, &functions));
  PetscCall(SNESSetTolerances(snes, absolute, 0, step, iterations, functions));
  // A body at rest may be no minimum either, and solvers are to read their options in any case.
  PetscCall(SNESSetForceIteration(snes, PETSC_TRUE));
  PetscCall(set_program_defaults(snes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_time_defaults(SNES snes) {
  PetscReal absolute = 0, relative = 0;
  PetscInt iterations = 0, functions = 0;
  PetscFunctionBeginUser;
  // What a body has moved since it was at rest is no measure for a step.
  PetscCall(SNESGetTolerances(snes, &absolute, &relative, nullptr, &iterations, &functions));
  PetscCall(SNESSetTolerances(snes, absolute, relative, 0, iterations, functions));
  // Measured over steps from short to long it takes the fewest factorisations, and its directions
  // are none that a filter shortens: the velocity tolerance may believe them.
  PetscCall(TrefoilSNESSetFilter(snes, "clamp"));
  PetscCall(TrefoilSNESSetContinue(snes, PETSC_TRUE));
  PetscCall(TrefoilSNESSetTakeLast(snes, PETSC_TRUE));
  PetscCall(TrefoilSNESSetVerifyMinimum(snes, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether our search drives the SNES, whose options have been read.
static PetscErrorCode is_ours(SNES snes, bool *ours) {
  PetscBool is = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(snes), SNESNEWTONLS, &is));
  if (is) {
    SNESLineSearch search = nullptr;
    PetscCall(SNESGetLineSearch(snes, &search));
    PetscCall(
        PetscObjectTypeCompare(reinterpret_cast<PetscObject>(search), SNESLINESEARCHTREFOIL, &is));
  } else {
    PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(snes), SNESTREFOIL, &is));
  }
  *ours = is == PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_time_tests_of_others(SNES snes) {
  constexpr PetscReal residual = 1e-8, step = 1e-12;
  PetscReal absolute = 0, relative = 0, least_step = 0;
  PetscInt iterations = 0, functions = 0;
  PetscBool has_relative = PETSC_FALSE, has_step = PETSC_FALSE;
  bool ours = false;
  PetscFunctionBeginUser;
  PetscCall(is_ours(snes, &ours));
  if (ours) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscOptionsHasName(nullptr, nullptr, "-snes_rtol", &has_relative));
  PetscCall(PetscOptionsHasName(nullptr, nullptr, "-snes_stol", &has_step));
  PetscCall(SNESGetTolerances(snes, &absolute, &relative, &least_step, &iterations, &functions));
  PetscCall(SNESSetTolerances(snes, absolute, has_relative ? relative : residual,
                              has_step ? least_step : step, iterations, functions));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
