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
  double share = 1;              ///< of the linear solver's direction in d, which may be steered
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

/// Backtracks from `first_step` until the energy has decreased enough; infinite or undefined
/// energies count as no decrease. A step that only meets lifted boundary values is not judged.
/// Collective.
PetscErrorCode backtrack(SolveContext &context, Line &line, double first_step, PetscInt most_trials,
                         bool *accepted);

/// u'Hu of the unfiltered Hessian for the full direction d; the Mats still hold it at the old x.
/// Collective.
PetscErrorCode unfiltered_curvature(SolveContext &context, const Line &line, Vec work,
                                    double *curvature);

/// How well the unfiltered quadratic model at x predicted the energy of the step taken. Collective.
PetscErrorCode trust_region_ratio(SolveContext &context, Line &line, double curvature, double *rho);

/// Goes to the accepted trial: x, energy, residual and the norms that SNES asks for. Collective.
PetscErrorCode take_step(SolveContext &context, SNESLineSearch search, Line &line);
/// Goes back to x, after trials that were all refused. Collective.
PetscErrorCode stay(SolveContext &context, const Line &line);

/// Whether this iteration searches the plane of the direction and the previous step: with search
/// `subspace`, and once the quadratic model can be trusted. From a start with crushed elements the
/// plane's minimum keeps some of them so, in another minimum of the energy than the best (measured
/// on the paper's scenes); there backtracking goes first, until |rho - 1| <
/// -snes_trefoil_rho_tolerance.
bool searches_plane(SolveContext &context, const Line &line);

/// Turns the direction d towards the energy's minimum in the plane of d and the previous step, so
/// that a full step reaches it; leaves it where the plane holds nothing better. Collective.
PetscErrorCode steer_direction(SolveContext &context, Line &line);

/// Corrects the step taken: up to -snes_trefoil_corrections further directions from the factors of
/// the same Jacobian, at the gradient where the last one led, each searched in the plane with the
/// step before. A factorisation costs many solves, so these directions are nearly free. Collective.
PetscErrorCode correct_step(SolveContext &context, SNESLineSearch search, Line &line);

/// Where the stop test is met: verifies, with -snes_trefoil_verify_minimum, that the point is a
/// minimum, and leaves a saddle along its negative curvature. Where the unfiltered Hessian has been
/// factored for that, its Newton decrement is the error estimate; a step of it is taken where that
/// is more than a hundred times the energy tolerance.
/// @param[out] reason why the solve ends; SNES_CONVERGED_ITERATING where it goes on from line.trial
/// Collective.
PetscErrorCode verify_minimum(SolveContext &context, Line &line, SNESConvergedReason *reason);

/// What the linear solver's factors say of the matrix: nothing where it makes no Cholesky factors
/// or its package does not count negative pivots.
enum class FactorSays { nothing, definite, indefinite };
/// Collective.
PetscErrorCode ask_factor(SNES snes, FactorSays *says);

/// Whether the direction still moves unknowns whose rows of H are but a diagonal: Dirichlet values
/// that a host enforces by the first step. Collective.
PetscErrorCode moves_boundary_values(Mat H, Vec direction, bool *moves);

/// Whether the direction may be searched along: finite, descending, and not from an indefinite
/// Hessian. Where the rule knows another weight for an indefinite one, the direction is replaced.
/// Otherwise the reason to end the solve; the summary says it in words. Collective.
PetscErrorCode judge_direction(SolveContext &context, Line &line, SNESConvergedReason *reason);

}  // namespace trefoil
