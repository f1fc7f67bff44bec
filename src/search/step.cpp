#include "search/step.hpp"

#include <petsc/private/linesearchimpl.h>

#include <cmath>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode backtrack(const SearchOptions &options, LineSearchState &state, double first_step,
                         PetscInt most_trials, bool *accepted) {
  double step = first_step;
  PetscFunctionBeginUser;
  *accepted = false;
  PetscCall(state.f.limit_step(state.x, state.d, &step, &state.truncated));
  state.trials = 0;
  if (step == 0) PetscFunctionReturn(PETSC_SUCCESS);
  for (state.trials = 1; state.trials <= most_trials; ++state.trials) {
    bool finite = false;
    PetscCall(evaluate_trial(state, step, &finite));
    if (finite) {
      double change = 0;
      PetscCall(energy_change(state, step * state.slope, &change));
      *accepted = state.lifted || change <= options.armijo * step * state.slope;
      // An energy may be finite where the residual is not, and a lifted step's is not compared.
      if (*accepted) PetscCall(evaluate_trial_residual(state));
      *accepted = *accepted && std::isfinite(state.trial_slope);
      if (*accepted) PetscFunctionReturn(PETSC_SUCCESS);
    }
    step *= options.shrink;
  }
  state.trials = static_cast<int>(most_trials);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode trust_region_ratio(LineSearchState &state, double curvature, double *rho) {
  const double s = state.step;
  const double predicted = s * state.slope + 0.5 * s * s * curvature;
  double change = 0;
  PetscFunctionBeginUser;
  PetscCall(energy_change(state, predicted, &change));
  *rho = predicted != 0 ? change / predicted : IterationRecord::none;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// SNES has the update that its post-check and its monitors may ask for.
static PetscErrorCode set_update(LineSearchState &state) {
  Vec direction = nullptr;
  PetscFunctionBeginUser;
  PetscCall(state.work.get(Work::direction, state.x, &direction));
  if (state.d != direction) PetscCall(VecAXPBY(state.update, -1, 0, state.d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The host's post-check, which may change the direction or the trial point.
static PetscErrorCode post_check(SNESLineSearch search, LineSearchState &state, bool *changed) {
  PetscBool changed_direction = PETSC_FALSE, changed_point = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(SNESLineSearchPostCheck(search, state.x, state.update, state.trial, &changed_direction,
                                    &changed_point));
  *changed = changed_direction || changed_point;
  if (!*changed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!state.f.max_step_callback, PetscObjectComm(reinterpret_cast<PetscObject>(search)),
             PETSC_ERR_ARG_INCOMP,
             "the post-check of the line search has changed a step that TrefoilSNESSetMaxStep()'s "
             "callback has limited: shorten steps in that callback");
  if (!changed_point) PetscCall(VecWAXPY(state.trial, -state.step, state.update, state.x));
  state.trial_residual_known = false;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// SNES wants the norm of the step taken, not of the full direction.
static PetscErrorCode set_norms(SNESLineSearch search, double step) {
  PetscReal x_norm = 0, residual_norm = 0, d_norm = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESLineSearchSetLambda(search, step));
  PetscCall(SNESLineSearchComputeNorms(search));
  PetscCall(SNESLineSearchGetNorms(search, &x_norm, &residual_norm, &d_norm));
  PetscCall(SNESLineSearchSetNorms(search, x_norm, residual_norm, step * d_norm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode take_step(SNESLineSearch search, LineSearchState &state, SearchMemory &memory) {
  bool changed = false;
  Vec previous_step = nullptr;
  PetscFunctionBeginUser;
  PetscCall(set_update(state));
  PetscCall(post_check(search, state, &changed));
  PetscCall(evaluate_trial_residual(state));
  PetscCall(VecCopy(state.trial, state.solution));
  PetscCall(VecCopy(state.trial_residual, state.residual));
  if (!changed) PetscCall(state.f.remember(state.solution, state.trial_energy));
  PetscCall(set_norms(search, state.step));
  if (memory.keeps_steps) {
    PetscCall(memory.vectors.get(Work::previous_step, state.x, &previous_step));
    PetscCall(VecWAXPY(previous_step, -1, state.x, state.solution));
    memory.previous_step_known = !state.lifted;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode stay(LineSearchState &state) {
  PetscFunctionBeginUser;
  PetscCall(VecCopy(state.x, state.solution));
  PetscCall(state.f.remember(state.solution, state.energy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
