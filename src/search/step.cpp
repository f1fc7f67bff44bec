#include <petsc/private/linesearchimpl.h>

#include <cmath>

#include "search/line.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode backtrack(SolveContext &context, Line &line, double first_step, PetscInt most_trials,
                         bool *accepted) {
  const SolverOptions &options = context.options;
  double step = first_step;
  PetscFunctionBeginUser;
  *accepted = false;
  for (line.trials = 1; line.trials <= most_trials; ++line.trials) {
    bool finite = false;
    PetscCall(evaluate_trial(context, line, step, &finite));
    if (finite) {
      double change = 0;
      PetscCall(energy_change(context, line, step * line.slope, &change));
      *accepted = line.lifted || change <= options.armijo * step * line.slope;
      if (*accepted) PetscFunctionReturn(PETSC_SUCCESS);
    }
    step *= options.shrink;
  }
  line.trials = static_cast<int>(most_trials);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode unfiltered_curvature(SolveContext &context, const Line &line, Vec work,
                                    double *curvature) {
  Mat filtered = nullptr;
  PetscScalar product = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESGetJacobian(context.snes, nullptr, &filtered, nullptr, nullptr));
  PetscCall(MatMult(filtered, line.minus_d, work));
  PetscCall(VecDot(work, line.minus_d, &product));
  *curvature = PetscRealPart(product);
  if (context.negative_present) {
    PetscCall(MatMult(context.negative, line.minus_d, work));
    PetscCall(VecDot(work, line.minus_d, &product));
    *curvature -= 2 * context.current.weight * PetscRealPart(product);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode trust_region_ratio(SolveContext &context, Line &line, double curvature,
                                  double *rho) {
  const double s = line.step;
  const double predicted = s * line.slope + 0.5 * s * s * curvature;
  double change = 0;
  PetscFunctionBeginUser;
  PetscCall(energy_change(context, line, predicted, &change));
  *rho = predicted != 0 ? change / predicted : IterationRecord::none;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Keeps the step from x for the next plane, where the search has planes.
static PetscErrorCode remember_step(SolveContext &context, const Line &line) {
  PetscFunctionBeginUser;
  if (context.options.search != "subspace") PetscFunctionReturn(PETSC_SUCCESS);
  if (!context.previous_step) PetscCall(VecDuplicate(line.x, &context.previous_step));
  PetscCall(VecWAXPY(context.previous_step, -1, line.x, line.solution));
  context.previous_step_known = !line.lifted;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode take_step(SolveContext &context, SNESLineSearch search, Line &line) {
  PetscBool changed_direction = PETSC_FALSE, changed_point = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(SNESLineSearchPostCheck(search, line.x, line.minus_d, line.trial, &changed_direction,
                                    &changed_point));
  if (changed_direction && !changed_point) {
    PetscCall(VecWAXPY(line.trial, -line.step, line.minus_d, line.x));
  }
  if (changed_direction || changed_point) line.trial_residual_known = false;
  PetscCall(evaluate_trial_residual(context, line));
  PetscCall(VecCopy(line.trial, line.solution));
  PetscCall(VecCopy(line.trial_residual, line.residual));
  if (!changed_direction && !changed_point) {
    PetscCall(remember_energy(context, line.solution, line.trial_energy));
  }
  PetscCall(SNESLineSearchSetLambda(search, line.step));
  PetscCall(SNESLineSearchComputeNorms(search));
  // SNES wants the norm of the step taken, not of the full direction.
  PetscReal x_norm = 0, residual_norm = 0, d_norm = 0;
  PetscCall(SNESLineSearchGetNorms(search, &x_norm, &residual_norm, &d_norm));
  PetscCall(SNESLineSearchSetNorms(search, x_norm, residual_norm, line.step * d_norm));
  PetscCall(remember_step(context, line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode stay(SolveContext &context, const Line &line) {
  PetscFunctionBeginUser;
  PetscCall(VecCopy(line.x, line.solution));
  PetscCall(remember_energy(context, line.solution, line.energy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
