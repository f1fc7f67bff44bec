/*
   Whether the point where the stop test is met is a minimum: whether H is positive definite there.

   Where no element is indefinite there is nothing to do. Where the linear solver is a Cholesky
   factorisation, that of H tells, at the price of an iteration's. Elsewhere, and for a direction of
   negative curvature, conjugate gradients on H from a random right-hand side, preconditioned by the
   solver of the filtered Jacobian H + 2 w N, see negative_curvature.hpp.
*/
#include <petscksp.h>

#include <algorithm>
#include <cmath>

#include "hook/matrix_operations.hpp"
#include "search/line.hpp"
#include "search/negative_curvature.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr int most_saddles = 100;  ///< to leave in one solve
/// A relative energy error of 1e-6 is promised with the default tolerance of 1e-8.
constexpr double error_over_tolerance = 100;

/// H + 2 w N becomes H, or H becomes H + 2 w N again, and is factored, also where the SNES lags
/// its preconditioner. CHOLMOD calls a matrix that is not positive definite an error; it is none
/// here.
PetscErrorCode factor(SolveContext &context, double multiple_of_negative, bool *done) {
  Mat matrix = nullptr;
  KSP ksp = nullptr;
  PC solver = nullptr;
  PetscBool lagged = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(SNESGetJacobian(context.snes, nullptr, &matrix, nullptr, nullptr));
  PetscCall(SNESGetKSP(context.snes, &ksp));
  PetscCall(KSPGetPC(ksp, &solver));
  PetscCall(add_multiple(matrix, multiple_of_negative, context.negative));
  PetscCall(PCGetReusePreconditioner(solver, &lagged));
  PetscCall(PCSetReusePreconditioner(solver, PETSC_FALSE));
  PetscCall(PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr));
  const PetscErrorCode error = PCSetUp(solver);
  PetscCall(PetscPopErrorHandler());
  PetscCheck(!error || error == PETSC_ERR_MAT_CH_ZRPVT,
             PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), error,
             "the factorisation that verifies the minimum failed; "
             "-snes_trefoil_verify_minimum false goes without it");
  PetscCall(PCSetReusePreconditioner(solver, lagged));
  *done = !error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Tries Cholesky factors of H itself and leaves those of H + 2 w N where it has none.
PetscErrorCode try_factors(SolveContext &context, bool *definite) {
  const double multiple = 2 * context.current.weight;
  FactorSays says = FactorSays::nothing;
  bool done = false;
  PetscFunctionBeginUser;
  PetscCall(factor(context, -multiple, &done));
  if (done) PetscCall(ask_factor(context.snes, &says));
  *definite = says == FactorSays::definite;
  if (*definite) {
    context.negative_present = false;  // the Jacobian is H now
  } else {
    PetscCall(factor(context, multiple, &done));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// @param factored the solver now holds factors of H itself
PetscErrorCode classify(SolveContext &context, WorkVectors &work, StationaryPoint *kind,
                        bool *factored, NegativeCurvature *found) {
  const bool all_filtered = context.unfiltered.unfiltered() == 0;
  const bool clamped = context.current.weight >= 0.5 && all_filtered;
  Mat filtered = nullptr;
  KSP ksp = nullptr;
  PetscBool lagged = PETSC_FALSE;
  FactorSays says = FactorSays::nothing;
  PetscFunctionBeginUser;
  *factored = false;
  PetscCall(ask_factor(context.snes, &says));
  PetscCall(SNESGetKSP(context.snes, &ksp));
  PetscCall(KSPGetReusePreconditioner(ksp, &lagged));  // then the factors are an older matrix's
  const bool positive_solver = clamped || says == FactorSays::definite;
  *kind = StationaryPoint::unknown;
  if (!context.negative_present) {  // the Jacobian is H itself
    if (clamped || (positive_solver && !lagged)) *kind = StationaryPoint::minimum;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Phase phase = context.clock.switch_to(Phase::linear_solve);
  if (says != FactorSays::nothing) PetscCall(try_factors(context, factored));
  if (*factored) {
    *kind = StationaryPoint::minimum;
  } else if (positive_solver) {
    PetscCall(SNESGetJacobian(context.snes, nullptr, &filtered, nullptr, nullptr));
    PetscCall(probe_curvature(context, filtered, work, kind, found));
  }
  context.clock.switch_to(phase);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Halves steps along the negative curvature, downhill, from one as large as the deformation
/// itself, as long as that lowers the energy.
PetscErrorCode descend_from_saddle(SolveContext &context, const NegativeCurvature &found,
                                   Line &line, bool *lower) {
  constexpr int most_halvings = 40;
  const double noise = 8 * PETSC_MACHINE_EPSILON * std::abs(line.energy);
  double size = context.summary.energy_scale, slope = 0, best_step = 0;
  PetscFunctionBeginUser;
  if (!(size > 0)) size = std::abs(line.energy);
  if (!(size > 0)) size = found.squared_norm;
  PetscCall(dot(line.residual, found.direction, &slope));
  const double sign = slope > 0 ? 1 : -1;  // minus_d points uphill
  PetscCall(
      VecAXPBY(line.minus_d, sign * std::sqrt(2 * size / found.squared_norm), 0, found.direction));
  PetscCall(dot(line.residual, line.minus_d, &line.slope));
  line.slope = -line.slope;
  double best = line.energy - noise, step = 1;
  for (line.trials = 1; line.trials <= most_halvings; ++line.trials, step /= 2) {
    bool finite = false;
    PetscCall(evaluate_trial(context, line, step, &finite));
    const bool better = finite && line.trial_energy < best;
    if (best_step > 0 && !better) break;
    if (!better) continue;
    best = line.trial_energy;
    best_step = step;
  }
  *lower = best_step > 0;
  if (*lower) {
    bool finite = false;
    PetscCall(evaluate_trial(context, line, best_step, &finite));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Newton's own decrement, which the filtered one may fall short of by a factor of a hundred where
/// the filter makes H stiffer: with the factors of H at hand it costs one solve. Where it says that
/// the energy is still too far above its minimum, Newton's step is taken.
PetscErrorCode finish_by_newton(SolveContext &context, Line &line, bool *lower) {
  constexpr PetscInt most_trials = 20;
  const SolverOptions &options = context.options;
  KSP ksp = nullptr;
  Vec filtered_direction = nullptr;
  PetscFunctionBeginUser;
  *lower = false;
  PetscCall(SNESGetKSP(context.snes, &ksp));
  PetscCall(VecDuplicate(line.minus_d, &filtered_direction));
  PetscCall(VecCopy(line.minus_d, filtered_direction));
  PetscCall(KSPSolve(ksp, line.residual, line.minus_d));
  ++context.summary.verification_solves;
  PetscCall(dot(line.residual, line.minus_d, &line.slope));
  line.slope = -line.slope;
  context.summary.error_estimate = -line.slope / 2;
  PetscCall(scale_of_energy(context, line.x, &context.summary.energy_scale));
  if (options.energy_tolerance > 0 &&
      context.summary.error_estimate >
          error_over_tolerance * options.energy_tolerance * context.summary.energy_scale) {
    PetscCall(backtrack(context, line, 1, most_trials, lower));
  }
  if (!*lower) PetscCall(VecCopy(filtered_direction, line.minus_d));
  PetscCall(VecDestroy(&filtered_direction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A decrement tolerance ends a solve where it says; it turns the verification off, as it does the
/// energy tolerance, unless the user wants it.
bool verification_is_on(const SolverOptions &options) {
  return options.verify_minimum && (options.verify_minimum_set || options.decrement_tolerance <= 0);
}

}  // namespace

PetscErrorCode verify_minimum(SolveContext &context, Line &line, SNESConvergedReason *reason) {
  StationaryPoint kind = StationaryPoint::unknown;
  NegativeCurvature found;
  WorkVectors work(line.x);
  bool factored = false, lower = false;
  PetscFunctionBeginUser;
  *reason = SNES_CONVERGED_SNORM_RELATIVE;
  if (!verification_is_on(context.options)) PetscFunctionReturn(PETSC_SUCCESS);
  const bool unfiltered = !context.negative_present;
  PetscCall(classify(context, work, &kind, &factored, &found));
  context.summary.end = kind;
  if (unfiltered) context.summary.error_estimate = context.current.decrement;
  if (factored) PetscCall(finish_by_newton(context, line, &lower));
  if (lower) {
    context.summary.end = StationaryPoint::unknown;
    context.summary.error_estimate = IterationRecord::none;
    context.summary.reason.clear();
    *reason = SNES_CONVERGED_ITERATING;
  }
  if (kind != StationaryPoint::saddle) PetscFunctionReturn(PETSC_SUCCESS);
  if (context.summary.saddles_left < most_saddles) {
    PetscCall(descend_from_saddle(context, found, line, &lower));
  }
  if (lower) {
    ++context.summary.saddles_left;
    context.summary.end = StationaryPoint::unknown;
    context.summary.reason.clear();
    *reason = SNES_CONVERGED_ITERATING;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(stay(context, line));
  context.summary.reason =
      "a stationary point that is no minimum: the Hessian has negative curvature there, but no "
      "step along it that decreases the energy was found";
  *reason = SNES_DIVERGED_LOCAL_MIN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
