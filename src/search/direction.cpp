#include "search/direction.hpp"

#include <petscksp.h>

#include <cmath>

#include "search/inertia.hpp"
#include "search/inexact.hpp"
#include "search/lanczos.hpp"
#include "search/linear_failure.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

namespace trefoil {
namespace {

enum class DirectionStatus { good, unsolved, unfactored, not_finite, zero, indefinite, ascends };

/// Whether a Jacobian that the filter may leave indefinite is so, and by what that is known. The
/// factors tell where they count negative pivots. Elsewhere a rule that has an answer to it asks
/// for the curvature along the direction, which a lifted step has none of, and a few Lanczos
/// vectors.
PetscErrorCode is_indefinite(KSP ksp, const Rule &rule, const FilteredJacobian &jacobian,
                             const SearchMemory &memory, LineSearchState &state,
                             SolveRecord &record, bool *indefinite) {
  Inertia inertia = Inertia::unknown;
  Vec product = nullptr;
  double curvature = 0;
  bool factors = false;
  PetscFunctionBegin;
  record.current.definite_by = DefiniteBy::nothing;
  PetscCall(makes_signed_factors(ksp, &factors));
  if (factors) PetscCall(inertia_of_factors(ksp, &inertia));
  *indefinite = inertia == Inertia::indefinite;
  if (inertia == Inertia::definite) record.current.definite_by = DefiniteBy::inertia;
  if (inertia != Inertia::unknown || !rule.may_be_rejected()) PetscFunctionReturn(PETSC_SUCCESS);
  const Phase phase = record.clock.switch_to(Phase::linear_solve);
  if (!state.lifted) {
    PetscCall(state.work.get(Work::product, state.x, &product));
    PetscCall(MatMult(jacobian.matrix(), state.d, product));
    PetscCall(dot(state.d, product, &curvature));
    *indefinite = !(curvature > 0);
  }
  if (!*indefinite) {
    PetscCall(meets_negative_curvature(ksp, memory.held_rows, state.x, state.work,
                                       &record.verification_solves, indefinite));
  }
  if (!*indefinite) record.current.definite_by = DefiniteBy::curvature;
  record.clock.switch_to(phase);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether it was the factors of the present matrix that failed, and would once more.
PetscErrorCode failed_to_factor(KSP ksp, bool *failed) {
  KSPConvergedReason solved = KSP_CONVERGED_ITERATING;
  PetscBool factors = PETSC_FALSE, lagged = PETSC_FALSE;
  PC pc = nullptr;
  PetscFunctionBegin;
  PetscCall(KSPGetConvergedReason(ksp, &solved));
  PetscCall(KSPGetReusePreconditioner(ksp, &lagged));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(
      PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(pc), &factors, PCLU, PCCHOLESKY, ""));
  *failed = solved == KSP_DIVERGED_PC_FAILED && factors && !lagged;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Newton's plain direction from an indefinite Hessian may descend by luck; it is none to follow.
PetscErrorCode status_of(KSP ksp, const Rule &rule, const FilteredJacobian &jacobian,
                         const SearchMemory &memory, LineSearchState &state, SolveRecord &record,
                         DirectionStatus *status) {
  const bool clamped = jacobian.is_clamped();
  KSPConvergedReason solved = KSP_CONVERGED_ITERATING;
  bool indefinite = false, unfactored = false;
  PetscFunctionBegin;
  PetscCall(KSPGetConvergedReason(ksp, &solved));
  *status = DirectionStatus::good;
  if (!clamped && solved < 0) {
    *status = DirectionStatus::indefinite;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(failed_to_factor(ksp, &unfactored));
  if (unfactored) {
    *status = DirectionStatus::unfactored;
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
  if (state.slope == 0 && record.current.gradient_norm > 0 && !state.lifted) {
    *status = DirectionStatus::zero;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (state.slope > 0 && !state.lifted) {
    *status = clamped ? DirectionStatus::ascends : DirectionStatus::indefinite;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (clamped) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(is_indefinite(ksp, rule, jacobian, memory, state, record, &indefinite));
  if (indefinite) *status = DirectionStatus::indefinite;
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

PetscErrorCode check_direction(SNES snes, Rule &rule, const SearchMemory &memory,
                               FilteredJacobian &jacobian, LineSearchState &state,
                               SolveRecord &record, SNESConvergedReason *reason) {
  KSP ksp = nullptr;
  DirectionStatus status = DirectionStatus::good;
  PetscFunctionBegin;
  *reason = SNES_CONVERGED_ITERATING;
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(status_of(ksp, rule, jacobian, memory, state, record, &status));
  for (bool is_fresh = false, is_refined = false; status != DirectionStatus::good;) {
    if (status == DirectionStatus::unsolved && !is_fresh) {
      is_fresh = true;
      PetscCall(solve_with_fresh_preconditioner(ksp, state, record));
    } else if (status == DirectionStatus::zero && !is_refined) {  // the first guess met a tolerance
      bool refined = false;
      is_refined = true;
      PetscCall(refine_direction(ksp, state, record, &refined));
    } else if (status == DirectionStatus::indefinite) {
      const std::optional<double> weight = rule.rejected(record.current);
      if (!weight) break;
      ++record.current.refused;
      PetscCall(replace_direction(snes, ksp, *weight, jacobian, state, record));
    } else {
      break;
    }
    PetscCall(status_of(ksp, rule, jacobian, memory, state, record, &status));
  }
  switch (status) {
    case DirectionStatus::good:
      break;
    case DirectionStatus::unsolved:
      record.reason = "the linear solver failed, with a fresh preconditioner as well";
      PetscCall(explain_linear_failure(ksp, &record.reason));
      *reason = SNES_DIVERGED_LINEAR_SOLVE;
      break;
    case DirectionStatus::unfactored:
      record.reason = "the linear solver failed";
      PetscCall(explain_linear_failure(ksp, &record.reason));
      *reason = SNES_DIVERGED_LINEAR_SOLVE;
      break;
    case DirectionStatus::not_finite:
      record.reason = "the energy or the direction is not finite";
      *reason = SNES_DIVERGED_FUNCTION_NANORINF;
      break;
    case DirectionStatus::zero:
      record.reason = "the linear solver gives no direction where the gradient is not zero";
      PetscCall(explain_linear_failure(ksp, &record.reason));
      *reason = SNES_DIVERGED_LINEAR_SOLVE;
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
