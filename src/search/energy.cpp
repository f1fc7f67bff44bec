#include "search/energy.hpp"

#include <petsc/private/snesimpl.h>

#include <cmath>
#include <limits>

#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

namespace trefoil {

void Energy::begin_solve() {
  known_state_ = -1;
  known_energy_ = 0;
  objective_examined_ = objective_is_norm_ = false;
}

PetscErrorCode Energy::wants_examination(bool *wants) const {
  PetscFunctionBeginUser;
  PetscCall(has_objective(wants));
  *wants = *wants && !objective_examined_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::examine_objective(double objective, double norm, double slope,
                                         double slope_of_half_square, bool *is_norm) {
  constexpr double rounding = 1e-10, difference = 1e-6;
  // What the objective may be, and its slope.
  const double norms[3][2] = {{norm, slope_of_half_square / norm},
                              {norm * norm / 2, slope_of_half_square},
                              {norm * norm, 2 * slope_of_half_square}};
  PetscFunctionBeginUser;
  *is_norm = false;
  if (!(norm > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  objective_examined_ = true;
  for (const auto &[value, slope_of_norm] : norms) {
    const bool same_value = std::abs(objective - value) <= rounding * value;
    const bool same_slope = std::abs(slope_of_norm - slope) <= difference * std::abs(slope);
    *is_norm = *is_norm || (same_value && !same_slope);
  }
  if (*is_norm) {
    objective_is_norm_ = true;
    known_energy_ = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::work_of_right_hand_side(Vec v, double *work) const {
  Vec b = nullptr;
  PetscFunctionBeginUser;
  *work = 0;
  PetscCall(SNESGetRhs(snes_, &b));
  if (b) PetscCall(dot(b, v, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::has_objective(bool *has) const {
  PetscErrorCode (*objective)(SNES, Vec, PetscReal *, void *) = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESGetObjective(snes_, &objective, nullptr));
  *has = objective && !objective_is_norm_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::evaluate(Vec x, double *energy) {
  PetscErrorCode (*objective)(SNES, Vec, PetscReal *, void *) = nullptr;
  void *context = nullptr;
  PetscReal value = 0;
  double work = 0;
  PetscFunctionBeginUser;
  // Not SNESComputeObjective(), which takes b'x off in some versions of PETSc.
  PetscCall(SNESGetObjective(snes_, &objective, &context));
  PetscCall(objective(snes_, x, &value, context));
#if !PETSC_VERSION_LT(3, 25, 0)
  if (snes_->objectivedomainerror) value = std::numeric_limits<double>::infinity();
  snes_->objectivedomainerror = PETSC_FALSE;
#endif
  PetscCall(work_of_right_hand_side(x, &work));
  *energy = value - work;
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
  for (PetscInt k = 0; k < directions; ++k) {
    double work = 0;
    PetscCall(work_of_right_hand_side(d[k], &work));
    for (PetscInt p = 0; p < points; ++p) changes[p] -= coefficients[directions * p + k] * work;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::limit_step(Vec x, Vec d, double *step, bool *truncated) {
  PetscReal largest = 0;
  PetscFunctionBeginUser;
  *truncated = false;
  if (!max_step_callback) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(max_step_callback.function(snes_, x, d, *step, &largest, max_step_callback.context));
  PetscCheck(
      largest >= 0, PetscObjectComm(reinterpret_cast<PetscObject>(snes_)), PETSC_ERR_ARG_OUTOFRANGE,
      "the largest step of TrefoilSNESSetMaxStep()'s callback is %g and must not be negative",
      largest);
  *truncated = largest < *step;
  if (*truncated) *step = largest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Energy::direction_size(Vec d, double *size) {
  PetscReal found = 0;
  PetscFunctionBeginUser;
  if (direction_size_callback) {
    PetscCall(direction_size_callback.function(snes_, d, &found, direction_size_callback.context));
    PetscCheck(found >= 0, PetscObjectComm(reinterpret_cast<PetscObject>(snes_)),
               PETSC_ERR_ARG_OUTOFRANGE,
               "the size of a direction by TrefoilSNESSetDirectionSize()'s callback is %g and must "
               "not be negative",
               found);
  } else {
    PetscCall(VecNorm(d, NORM_INFINITY, &found));
  }
  *size = found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
