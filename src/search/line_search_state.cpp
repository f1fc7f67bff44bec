#include "search/line_search_state.hpp"

#include <algorithm>
#include <cmath>

#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

namespace trefoil {
namespace {

/// The slope g(x + s d)'d at a point of the line.
PetscErrorCode slope_at(LineSearchState &state, double s, double *slope) {
  Vec point = nullptr, residual = nullptr;
  PetscFunctionBegin;
  PetscCall(state.work.get(Work::slope_point, state.x, &point));
  PetscCall(state.work.get(Work::slope_residual, state.x, &residual));
  PetscCall(VecWAXPY(point, s, state.d, state.x));
  PetscCall(state.f.gradient(point, residual));
  PetscCall(dot(residual, state.d, slope));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Integral of the slope from a to b by the Gauss-Lobatto rule with five points (exact for
/// polynomials of degree 7, so for a stable Neo-Hookean energy). Where Simpson's rule on three of
/// these points disagrees by a tenth, in halves.
PetscErrorCode integrate_slope(LineSearchState &state, double a, double b, double slope_a,
                               double slope_b, int halvings, double *integral) {
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a), node = std::sqrt(3.0 / 7.0);
  double left = 0, centre = 0, right = 0;
  PetscFunctionBegin;
  PetscCall(slope_at(state, middle - node * half, &left));
  PetscCall(slope_at(state, middle, &centre));
  PetscCall(slope_at(state, middle + node * half, &right));
  *integral = half * ((slope_a + slope_b) / 10 + (left + right) * 49 / 90 + centre * 32 / 45);
  const double simpson = half * (slope_a + 4 * centre + slope_b) / 3;
  if (halvings > 0 && std::abs(*integral - simpson) > 0.1 * std::abs(*integral)) {
    double first = 0, second = 0;
    PetscCall(integrate_slope(state, a, middle, slope_a, centre, halvings - 1, &first));
    PetscCall(integrate_slope(state, middle, b, centre, slope_b, halvings - 1, &second));
    *integral = first + second;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

bool is_lost_in_rounding(const LineSearchState &state, double change) {
  // Of a sum over many elements of terms of f's size.
  const double noise =
      8 * PETSC_MACHINE_EPSILON * std::max(std::abs(state.energy), std::abs(state.trial_energy));
  return std::abs(change) < 1e3 * noise;
}

PetscErrorCode take_solvers_direction(LineSearchState &state) {
  Vec direction = nullptr;
  double slope = 0;
  PetscFunctionBegin;
  PetscCall(state.work.get(Work::direction, state.x, &direction));
  PetscCall(VecAXPBY(direction, -1, 0, state.update));
  PetscCall(dot(state.residual, direction, &slope));
  state.aim(direction, slope);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode evaluate_trial(LineSearchState &state, double step, bool *finite) {
  constexpr int most_halvings = 3;
  PetscFunctionBegin;
  state.step = step;
  state.trial_residual_known = false;
  PetscCall(VecWAXPY(state.trial, step, state.d, state.x));
  if (state.has_objective) {
    PetscCall(state.f.evaluate(state.trial, &state.trial_energy));
    state.trial_change = state.trial_energy - state.energy;
  } else {
    state.trial_change = 0;
    PetscCall(evaluate_trial_residual(state));
    if (!std::isfinite(state.trial_slope)) {
      state.trial_change = state.trial_slope;
    } else if (!state.lifted) {
      PetscCall(integrate_slope(state, 0, step, state.slope, state.trial_slope, most_halvings,
                                &state.trial_change));
    }
    state.trial_energy = state.energy + state.trial_change;
  }
  *finite = std::isfinite(state.trial_energy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode evaluate_trial_residual(LineSearchState &state) {
  PetscFunctionBegin;
  if (state.trial_residual_known) PetscFunctionReturn(PETSC_SUCCESS);
  const Phase phase = state.clock.switch_to(Phase::assembly);
  PetscCall(state.f.gradient(state.trial, state.trial_residual));
  PetscCall(dot(state.trial_residual, state.d, &state.trial_slope));
  state.clock.switch_to(phase);  // after the dot product, in which ranks wait for each other
  state.trial_residual_known = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode energy_change(LineSearchState &state, double predicted, double *change) {
  PetscFunctionBegin;
  *change = state.trial_change;
  // The slopes at both ends keep their digits (trapezoidal rule, exact to third order in the step).
  if (state.has_objective && is_lost_in_rounding(state, predicted)) {
    PetscCall(evaluate_trial_residual(state));
    *change = 0.5 * state.step * (state.slope + state.trial_slope);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
