/*
   Whether the point where the stop test is met is a minimum: whether H is positive definite there.

   Where no element is indefinite there is nothing to do. Where the linear solver is a Cholesky
   factorisation, that of H tells, at the price of an iteration's. Elsewhere, and for a direction of
   negative curvature, conjugate gradients on H from a random right-hand side, preconditioned by the
   solver of the filtered Jacobian H + 2 w N, see negative_curvature.hpp.
*/
#include "search/verify_minimum.hpp"

#include <petscksp.h>

#include <algorithm>
#include <cmath>

#include "search/inertia.hpp"
#include "search/negative_curvature.hpp"
#include "search/step.hpp"
#include "search/stop_test.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

namespace trefoil {
namespace {

constexpr int most_saddles = 100;  ///< to leave in one solve
/// A relative energy error of 1e-6 is promised with the default tolerance of 1e-8.
constexpr double error_over_tolerance = 100;

PetscErrorCode factor(PC solver, bool *done) {
  PetscErrorCode error = PETSC_SUCCESS;
  PetscFunctionBeginUser;
  PetscCall(try_to_factor(solver, &error));
  PetscCheck(!error || error == PETSC_ERR_MAT_CH_ZRPVT,
             PetscObjectComm(reinterpret_cast<PetscObject>(solver)), error,
             "the factorisation that verifies the minimum failed; "
             "-snes_trefoil_verify_minimum false goes without it");
  *done = !error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Tries factors of H itself that tell its inertia, and leaves those of H + 2 w N where it has
/// none.
PetscErrorCode try_factors(KSP ksp, PC solver, FilteredJacobian &jacobian, SolveRecord &record,
                           bool *definite) {
  Inertia inertia = Inertia::unknown;
  bool done = false;
  PetscFunctionBeginUser;
  PetscCall(jacobian.remove_filter());
  PetscCall(factor(solver, &done));
  ++record.factorisations;
  if (done) PetscCall(inertia_of_factors(ksp, &inertia));
  *definite = inertia == Inertia::definite;
  if (!*definite) {
    PetscCall(jacobian.restore_filter());
    PetscCall(factor(solver, &done));
    ++record.factorisations;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Solves with the preconditioner of the filtered Jacobian that the verification may take.
int most_solves(const StopOptions &options, const SolveRecord &record) {
  constexpr int most = 500, least = 30;
  constexpr double solves_a_setup = 40;  // measured with GAMG on 38 000 tetrahedra
  if (options.verify_share == 0) return most;
  const double spent = record.krylov_iterations + solves_a_setup * record.factorisations;
  return std::clamp(static_cast<int>(options.verify_share * spent), least, most);
}

/// What a few Lanczos vectors have vouched for is looked at closely: by conjugate gradients with
/// the diagonal, since the solver's preconditioner is of H itself, which nobody knows to be
/// definite.
PetscErrorCode probe_by_diagonal(const StopOptions &options, FilteredJacobian &jacobian,
                                 LineSearchState &state, SolveRecord &record, StationaryPoint *kind,
                                 NegativeCurvature *found) {
  PC diagonal = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PCCreate(PetscObjectComm(reinterpret_cast<PetscObject>(jacobian.matrix())), &diagonal));
  PetscCall(PCSetType(diagonal, PCJACOBI));
  PetscCall(PCJacobiSetUseAbs(diagonal, PETSC_TRUE));
  PetscCall(PCSetOperators(diagonal, jacobian.matrix(), jacobian.matrix()));
  PetscCall(PCSetUp(diagonal));
  PetscCall(probe_curvature(jacobian, diagonal, most_solves(options, record), state.x, state.work,
                            &record.verification_solves, kind, found));
  PetscCall(PCDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// @param factored the solver now holds factors of H itself
PetscErrorCode classify(const StopOptions &options, KSP ksp, FilteredJacobian &jacobian,
                        LineSearchState &state, SolveRecord &record, StationaryPoint *kind,
                        bool *factored, NegativeCurvature *found) {
  const bool clamped = jacobian.is_definite_by_construction();
  PC solver = nullptr;
  PetscBool lagged = PETSC_FALSE;
  Inertia inertia = Inertia::unknown;
  PetscFunctionBeginUser;
  *factored = false;
  PetscCall(KSPGetPC(ksp, &solver));
  PetscCall(inertia_of_factors(ksp, &inertia));
  PetscCall(KSPGetReusePreconditioner(ksp, &lagged));  // then the factors are an older matrix's
  const bool positive_solver = clamped || inertia == Inertia::definite;
  *kind = StationaryPoint::unknown;
  if (jacobian.is_unfiltered()) {
    if (clamped || (positive_solver && !lagged)) {
      *kind = StationaryPoint::minimum;
    } else if (record.current.definite_by == DefiniteBy::curvature) {
      PetscCall(probe_by_diagonal(options, jacobian, state, record, kind, found));
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Phase phase = record.clock.switch_to(Phase::linear_solve);
  if (inertia != Inertia::unknown && jacobian.can_remove_filter()) {
    PetscCall(try_factors(ksp, solver, jacobian, record, factored));
  }
  if (*factored) {
    *kind = StationaryPoint::minimum;
  } else if (positive_solver) {
    const int most = most_solves(options, record);
    PetscCall(probe_curvature(jacobian, solver, most, state.x, state.work,
                              &record.verification_solves, kind, found));
    if (*kind == StationaryPoint::unknown) {
      record.notes.push_back("whether the end is a minimum is not known: " + std::to_string(most) +
                             " solves did not tell (-snes_trefoil_verify_share 0 allows more)");
    }
  }
  record.clock.switch_to(phase);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Halves steps along the negative curvature, downhill, from one as large as the deformation
/// itself or the largest that the host allows, as long as that lowers the energy.
PetscErrorCode descend_from_saddle(double energy_scale, const NegativeCurvature &found,
                                   LineSearchState &state, bool *lower) {
  constexpr int most_halvings = 40;
  const double noise = state.has_objective ? 8 * PETSC_MACHINE_EPSILON * std::abs(state.energy) : 0;
  double size = energy_scale, slope = 0, best_step = 0;
  bool finite = false;
  PetscFunctionBeginUser;
  if (!(size > 0)) size = std::abs(state.energy);
  if (!(size > 0)) size = found.squared_norm;
  PetscCall(dot(state.residual, found.direction, &slope));
  const double downhill = slope > 0 ? -1 : 1;
  PetscCall(VecScale(found.direction, downhill * std::sqrt(2 * size / found.squared_norm)));
  PetscCall(dot(state.residual, found.direction, &slope));
  state.aim(found.direction, slope);
  double best = -noise, step = 1;
  PetscCall(state.f.limit_step(state.x, state.d, &step, &state.truncated));
  *lower = false;
  if (step == 0) PetscFunctionReturn(PETSC_SUCCESS);
  for (state.trials = 1; state.trials <= most_halvings; ++state.trials, step /= 2) {
    PetscCall(evaluate_trial(state, step, &finite));
    const bool better = finite && state.trial_change < best;
    if (best_step > 0 && !better) break;
    if (!better) continue;
    best = state.trial_change;
    best_step = step;
  }
  *lower = best_step > 0;
  if (*lower) PetscCall(evaluate_trial(state, best_step, &finite));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Newton's own decrement, which the filtered one may fall short of by a factor of a hundred where
/// the filter makes H stiffer: with the factors of H at hand it costs one solve. Where it says that
/// the energy is still too far above its minimum, Newton's step is taken.
PetscErrorCode finish_by_newton(const SearchOptions &search, const StopOptions &options, KSP ksp,
                                LineSearchState &state, SolveRecord &record, bool *lower) {
  constexpr PetscInt most_trials = 20;
  const Vec filtered_direction = state.d;
  const double filtered_slope = state.slope;
  Vec direction = nullptr;
  double slope = 0;
  PetscFunctionBeginUser;
  *lower = false;
  PetscCall(state.work.get(Work::newton_direction, state.x, &direction));
  PetscCall(KSPSolve(ksp, state.residual, direction));
  PetscCall(VecScale(direction, -1));
  ++record.verification_solves;
  PetscCall(dot(state.residual, direction, &slope));
  record.error_estimate = -slope / 2;
  PetscCall(scale_of_energy(state.f, record, state.x, &record.energy_scale));
  if (options.energy_tolerance > 0 && record.error_estimate > error_over_tolerance *
                                                                  options.energy_tolerance *
                                                                  record.energy_scale) {
    state.aim(direction, slope);
    PetscCall(backtrack(search, state, 1, most_trials, lower));
    if (!*lower) state.aim(filtered_direction, filtered_slope);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The solve goes on, and where it will end is not known any more.
void go_on(SolveRecord &record, SNESConvergedReason *reason) {
  record.end = StationaryPoint::unknown;
  record.linear_residual = IterationRecord::none;
  record.reason.clear();
  *reason = SNES_CONVERGED_ITERATING;
}

/// A decrement tolerance ends a solve where it says; it turns the verification off, as it does the
/// energy tolerance, unless the user wants it.
bool verification_is_on(const StopOptions &options) {
  return options.verify_minimum && (options.verify_minimum_set || options.decrement_tolerance <= 0);
}

}  // namespace

PetscErrorCode verify_minimum(const SearchOptions &search, const StopOptions &options, SNES snes,
                              FilteredJacobian &jacobian, LineSearchState &state,
                              SolveRecord &record, SNESConvergedReason *reason) {
  StationaryPoint kind = StationaryPoint::unknown;
  NegativeCurvature found;
  KSP ksp = nullptr;
  bool factored = false, lower = false;
  PetscFunctionBeginUser;
  *reason = SNES_CONVERGED_SNORM_RELATIVE;
  if (!verification_is_on(options)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetKSP(snes, &ksp));
  if (jacobian.is_unfiltered()) record.error_estimate = record.current.decrement;
  PetscCall(classify(options, ksp, jacobian, state, record, &kind, &factored, &found));
  record.end = kind;
  if (factored) {
    PetscCall(finish_by_newton(search, options, ksp, state, record, &lower));
    if (lower) {
      go_on(record, reason);
      record.error_estimate = IterationRecord::none;
    }
  }
  if (kind != StationaryPoint::saddle) PetscFunctionReturn(PETSC_SUCCESS);
  if (record.saddles_left < most_saddles) {
    PetscCall(descend_from_saddle(record.energy_scale, found, state, &lower));
  }
  if (lower) {
    ++record.saddles_left;
    go_on(record, reason);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(stay(state));
  record.reason =
      "a stationary point that is no minimum: the Hessian has negative curvature there, but no "
      "step along it that decreases the energy was found";
  *reason = SNES_DIVERGED_LOCAL_MIN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
