#include "search/energy.hpp"

#include <petsc/private/petscimpl.h>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

void Energy::begin_solve() {
  known_state_ = -1;
  known_energy_ = 0;
}

PetscErrorCode Energy::has_objective(bool *has) const {
  PetscErrorCode (*objective)(SNES, Vec, PetscReal *, void *) = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESGetObjective(snes_, &objective, nullptr));
  *has = objective != nullptr;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::evaluate(Vec x, double *energy) {
  PetscReal value = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESComputeObjective(snes_, x, &value));
  *energy = value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::at(Vec x, double *energy) {
  PetscObjectId id = 0;
  PetscObjectState state = 0;
  bool known = false;
  PetscFunctionBeginUser;
  PetscCall(has_objective(&known));
  known = !known;  // then it is what the steps have changed
  if (!known) {
    PetscCall(PetscObjectGetId(reinterpret_cast<PetscObject>(x), &id));
    PetscCall(PetscObjectStateGet(reinterpret_cast<PetscObject>(x), &state));
    known = id == known_vector_ && state == known_state_;
  }
  if (!known) {
    double value = 0;
    PetscCall(evaluate(x, &value));
    PetscCall(remember(x, value));
  }
  *energy = known_energy_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::remember(Vec x, double energy) {
  PetscFunctionBeginUser;
  PetscCall(PetscObjectGetId(reinterpret_cast<PetscObject>(x), &known_vector_));
  PetscCall(PetscObjectStateGet(reinterpret_cast<PetscObject>(x), &known_state_));
  known_energy_ = energy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::scale(Vec x, double *size) {
  PetscReal value = 0;
  PetscFunctionBeginUser;
  if (scale_callback) {
    PetscCall(scale_callback.function(snes_, x, &value, scale_callback.context));
  }
  *size = value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::changes(Vec x, PetscInt directions, const Vec d[], PetscInt points,
                               const double coefficients[], double changes[]) {
  PetscFunctionBeginUser;
  PetscCall(changes_callback.function(snes_, x, directions, d, points, coefficients, changes,
                                      changes_callback.context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::limit_step(Vec x, Vec d, double *step, bool *truncated) {
  PetscReal largest = 0;
  PetscFunctionBeginUser;
  *truncated = false;
  if (!max_step_callback) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(max_step_callback.function(snes_, x, d, *step, &largest, max_step_callback.context));
  PetscCheck(
      largest > 0, PetscObjectComm(reinterpret_cast<PetscObject>(snes_)), PETSC_ERR_ARG_OUTOFRANGE,
      "the largest step of TrefoilSNESSetMaxStep()'s callback is %g and must be positive", largest);
  *truncated = largest < *step;
  if (*truncated) *step = largest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
