#pragma once

#include <petscsnes.h>

#include "snes/solve_context.hpp"

namespace trefoil {

/// What the search knows of the line x + s d, d = -minus_d.
struct Line {
  Vec solution = nullptr;  ///< the SNES's own, which a host's callbacks may overwrite meanwhile
  Vec x = nullptr;         ///< a copy of it that they do not know
  Vec residual = nullptr, minus_d = nullptr;      ///< residual = g(x)
  Vec trial = nullptr, trial_residual = nullptr;  ///< x + s d and, once known, g there
  Vec point = nullptr, point_residual = nullptr;  ///< work: other points of the line
  bool has_objective = false;
  /// The boundary values that the host lifts are not met at x: its residual is no gradient there.
  bool lifted = false;
  double energy = 0, slope = 0;  ///< f(x), g(x)'d
  double step = 0, trial_energy = 0;
  double trial_slope = 0;  ///< g(x + s d)'d, once known
  bool trial_residual_known = false;
  int trials = 0;
};

/// Goes to x + step d: its energy, and whether it is finite. Without an objective the energy is
/// f(x) plus the integral of the slope g'd along the line. Collective.
PetscErrorCode evaluate_trial(SolveContext &context, Line &line, double step, bool *finite);

/// The residual and the slope at the trial point, once. Collective.
PetscErrorCode evaluate_trial_residual(SolveContext &context, Line &line);

/// f(x + s d) - f(x) at the trial point, where `predicted` is what a model says it should be.
/// Collective.
PetscErrorCode energy_change(SolveContext &context, Line &line, double predicted, double *change);

PetscErrorCode steer_direction(SolveContext &context, Line &line, bool *steered);

/// Whether the direction still moves unknowns whose rows of H are but a diagonal: Dirichlet values
/// that a host enforces by the first step. Collective.
PetscErrorCode moves_boundary_values(Mat H, Vec direction, bool *moves);

/// Whether the direction may be searched along: finite, descending, and not from an indefinite
/// Hessian. Otherwise the reason to end the solve; the summary says it in words. Collective.
PetscErrorCode judge_direction(SolveContext &context, const Line &line,
                               SNESConvergedReason *reason);

}  // namespace trefoil
