#include "search/direction.hpp"

#include <petscksp.h>

#include <cmath>

#include "search/inertia.hpp"
#include "search/inexact.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

namespace trefoil {
namespace {

enum class DirectionStatus { good, unsolved, not_finite, indefinite, ascends };

/// Newton's plain direction from an indefinite Hessian may descend by luck; it is none to follow.
PetscErrorCode status_of(KSP ksp, const FilteredJacobian &jacobian, const LineSearchState &state,
                         DirectionStatus *status) {
  KSPConvergedReason solved = KSP_CONVERGED_ITERATING;
  Inertia inertia = Inertia::unknown;
  PetscFunctionBegin;
  PetscCall(KSPGetConvergedReason(ksp, &solved));
  *status = DirectionStatus::good;
  if (!jacobian.is_clamped() && solved < 0) {
    *status = DirectionStatus::indefinite;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  // The iterate that a Krylov method has got to within -ksp_max_it is a direction all the same.
  if (solved < 0 && solved != KSP_DIVERGED_ITS) {
    *status = DirectionStatus::unsolved;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!std::isfinite(state.slope) || !std::isfinite(state.energy)) {
    *status = DirectionStatus::not_finite;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!jacobian.is_clamped()) PetscCall(inertia_of_factors(ksp, &inertia));
  if (inertia == Inertia::indefinite || (state.slope > 0 && !state.lifted)) {
    *status = jacobian.is_clamped() ? DirectionStatus::ascends : DirectionStatus::indefinite;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The Jacobian at x once more, and the solver's preconditioner, also where the SNES lags them.
PetscErrorCode compute_jacobian_now(SNES snes, KSP ksp, Vec x) {
  Mat J = nullptr, H = nullptr;
  PetscInt jacobian_lag = 1, preconditioner_lag = 1;
  PetscFunctionBegin;
  PetscCall(SNESGetLagJacobian(snes, &jacobian_lag));
  PetscCall(SNESGetLagPreconditioner(snes, &preconditioner_lag));
  PetscCall(SNESSetLagJacobian(snes, 1));
  PetscCall(SNESSetLagPreconditioner(snes, 1));
  PetscCall(SNESGetJacobian(snes, &J, &H, nullptr, nullptr));
  PetscCall(SNESComputeJacobian(snes, x, J, H));
  PetscCall(SNESSetLagJacobian(snes, jacobian_lag));
  PetscCall(SNESSetLagPreconditioner(snes, preconditioner_lag));
  PetscCall(KSPSetOperators(ksp, J, H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The direction once more, from a Jacobian with another weight.
PetscErrorCode replace_direction(SNES snes, KSP ksp, double weight, FilteredJacobian &jacobian,
                                 LineSearchState &state, SolveRecord &record) {
  PetscInt linear_iterations = 0;
  PetscFunctionBegin;
  jacobian.imposed_weight = weight;
  PetscCall(compute_jacobian_now(snes, ksp, state.solution));
  jacobian.imposed_weight.reset();
  PetscCall(KSPSolve(ksp, state.residual, state.update));
  PetscCall(KSPGetIterationNumber(ksp, &linear_iterations));
  ++record.factorisations;
  PetscCall(take_solvers_direction(state));
  record.clock.switch_to(Phase::line_search);
  record.current.decrement = std::abs(state.slope) / 2;
  record.current.linear_iterations = static_cast<int>(linear_iterations);
  record.current.linear_solves = record.linear_solves;
  record.current.seconds = record.seconds();
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode check_direction(SNES snes, Rule &rule, FilteredJacobian &jacobian,
                               LineSearchState &state, SolveRecord &record,
                               SNESConvergedReason *reason) {
  KSP ksp = nullptr;
  KSPConvergedReason solved = KSP_CONVERGED_ITERATING;
  DirectionStatus status = DirectionStatus::good;
  PetscFunctionBegin;
  *reason = SNES_CONVERGED_ITERATING;
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(status_of(ksp, jacobian, state, &status));
  if (status == DirectionStatus::unsolved) {
    PetscCall(solve_with_fresh_preconditioner(ksp, state, record));
    PetscCall(status_of(ksp, jacobian, state, &status));
  }
  while (status == DirectionStatus::indefinite && !state.lifted) {
    const std::optional<double> weight = rule.rejected(record.current);
    if (!weight) break;
    ++record.current.refused;
    PetscCall(replace_direction(snes, ksp, *weight, jacobian, state, record));
    PetscCall(status_of(ksp, jacobian, state, &status));
  }
  switch (status) {
    case DirectionStatus::good:
      break;
    case DirectionStatus::unsolved:
      PetscCall(KSPGetConvergedReason(ksp, &solved));
      record.reason =
          std::string("the linear solver failed, with a fresh preconditioner as well (") +
          KSPConvergedReasons[solved] + "): use a direct one, or tune it by -ksp_* and -pc_*";
      *reason = SNES_DIVERGED_LINEAR_SOLVE;
      break;
    case DirectionStatus::not_finite:
      record.reason = "the energy or the direction is not finite";
      *reason = SNES_DIVERGED_FUNCTION_NANORINF;
      break;
    case DirectionStatus::indefinite:
      record.reason =
          "the Hessian is indefinite and the filter leaves it so; filter adaptive, absolute or "
          "clamp do not";
      *reason = SNES_DIVERGED_LINEAR_SOLVE;
      break;
    case DirectionStatus::ascends:
      record.reason =
          "the direction ascends: the linear solve is too inexact or the residual is no gradient "
          "of the objective";
      *reason = SNES_DIVERGED_LINEAR_SOLVE;
      break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
