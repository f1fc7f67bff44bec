#pragma once

#include <petscsnes.h>

#include "search/energy.hpp"
#include "search/work_vectors.hpp"
#include "support/phase_clock.hpp"

namespace trefoil {

/// The search along x + s d: its start, its direction, and its trial point.
struct LineSearchState {
  LineSearchState(Energy &energy_to_lower, WorkVectors &work_vectors, PhaseClock &phase_clock)
      : f(energy_to_lower), work(work_vectors), clock(phase_clock) {}

  Energy &f;
  WorkVectors &work;
  PhaseClock &clock;

  Vec solution = nullptr;  ///< the SNES's own, which a host's callbacks may overwrite meanwhile
  Vec update = nullptr;    ///< the SNES's own direction, with its sign: x - s update
  Vec x = nullptr;         ///< a copy of the solution that they do not know
  Vec residual = nullptr;  ///< g(x)
  double energy = 0;       ///< f(x)
  bool has_objective = false;
  /// The boundary values that the host lifts are not met at x: its residual is no gradient there.
  bool lifted = false;

  Vec d = nullptr;          ///< the direction searched along
  double slope = 0;         ///< g(x)'d
  double newton_share = 1;  ///< of the linear solver's direction in d, which may be turned

  Vec trial = nullptr, trial_residual = nullptr;  ///< x + s d and, once known, g there
  double step = 0;                                ///< s
  double trial_energy = 0, trial_slope = 0;       ///< f and g'd at the trial point
  /// f(x + s d) - f(x): where the slope was integrated the integral itself, which keeps its digits
  /// when the energy gained since the start is much larger.
  double trial_change = 0;
  bool trial_residual_known = false;
  bool truncated = false;  ///< the host allowed no longer step
  int trials = 0;

  /// Goes on along another direction.
  void aim(Vec direction, double slope_along_it, double share = 1) {
    d = direction;
    slope = slope_along_it;
    newton_share = share;
  }
};

/// Whether so small a change of the energy has not the three digits, as a difference of energies,
/// that a ratio to it or a minimum of it asks for.
bool is_lost_in_rounding(const LineSearchState &state, double change);

/// Takes over the direction that the linear solver left in the SNES's update. Collective.
PetscErrorCode take_solvers_direction(LineSearchState &state);

/// Goes to x + step d: its energy, and whether it is finite. Without an objective the change of the
/// energy is the integral of the slope g'd along the line. Collective.
PetscErrorCode evaluate_trial(LineSearchState &state, double step, bool *finite);

/// The residual and the slope at the trial point, once. Collective.
PetscErrorCode evaluate_trial_residual(LineSearchState &state);

/// f(x + s d) - f(x) at the trial point, where `predicted` is what a model says it should be.
/// Collective.
PetscErrorCode energy_change(LineSearchState &state, double predicted, double *change);

}  // namespace trefoil
