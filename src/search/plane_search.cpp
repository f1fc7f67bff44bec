#include <petscksp.h>

#include <algorithm>
#include <cmath>

#include "search/line.hpp"
#include "search/polynomial.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Points x + a d + b p of a plane in the coordinates of Polynomial, [-1, 1] x [-1, 1] where the
/// energy is sampled: a from 0 to 2 and b from -1 to 1, in units of the scaled p.
constexpr double middle = 1, reach = 1;
constexpr Polynomial::Point full_step{(1 - middle) / reach, 0};
/// How far outside of the sampled square a minimum is looked for: a from -2 to 4. An energy that is
/// a polynomial is known there as well, and what is found is verified.
constexpr double bound = 3;

/// The plane through x of the direction d and the previous step p, scaled to be as long as d in the
/// norm of the filtered Hessian; a line where there is no previous step.
struct Plane {
  int dimension = 1;
  Vec directions[2] = {nullptr, nullptr};
  double previous_scale = 0;
};

PetscErrorCode open_plane(SolveContext &context, const Line &line, Plane *plane) {
  Mat filtered = nullptr;
  PetscScalar product = 0;
  PetscFunctionBegin;
  plane->directions[0] = line.point;
  plane->directions[1] = line.point_residual;
  if (context.previous_step_known) {
    PetscCall(SNESGetJacobian(context.snes, nullptr, &filtered, nullptr, nullptr));
    PetscCall(MatMult(filtered, context.previous_step, line.point));
    PetscCall(VecDot(line.point, context.previous_step, &product));
    // d'Hd is -g'd where the linear system is solved; an indefinite H has no such norm.
    const double ratio = -line.slope / PetscRealPart(product);
    if (std::isfinite(ratio) && ratio > 0) {
      plane->dimension = 2;
      plane->previous_scale = std::sqrt(ratio);
      PetscCall(VecAXPBY(line.point_residual, plane->previous_scale, 0, context.previous_step));
    }
  }
  PetscCall(VecAXPBY(line.point, -1, 0, line.minus_d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Energies at points of the plane, less that of x: all in one pass where the SNES has been given a
/// callback for that, else from the objective.
PetscErrorCode sample(SolveContext &context, const Line &line, const Plane &plane,
                      const std::vector<Polynomial::Point> &points, std::vector<double> *changes) {
  const int m = plane.dimension;
  std::vector<PetscReal> coefficients;
  PetscFunctionBegin;
  for (const Polynomial::Point &point : points) {
    coefficients.push_back(middle + reach * point[0]);
    if (m > 1) coefficients.push_back(reach * point[1]);
  }
  changes->assign(points.size(), 0);
  if (context.energy_changes) {
    PetscCall(context.energy_changes(context.snes, line.x, m, plane.directions,
                                     static_cast<PetscInt>(points.size()), coefficients.data(),
                                     changes->data(), context.energy_changes_context));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double *c = &coefficients[k * static_cast<std::size_t>(m)];
    PetscReal energy = 0;
    PetscCall(VecWAXPY(line.trial, c[0], plane.directions[0], line.x));
    if (m > 1) PetscCall(VecAXPY(line.trial, c[1], plane.directions[1]));
    PetscCall(SNESComputeObjective(context.snes, line.trial, &energy));
    (*changes)[k] = energy - line.energy;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

bool searches_plane(SolveContext &context, const Line &line) {
  if (context.options.search != "subspace" || line.lifted) return false;
  context.trusted = context.trusted ||
                    (!context.history.empty() &&
                     std::abs(context.history.back().rho - 1) < context.options.rule.rho_tolerance);
  return context.trusted;
}

PetscErrorCode steer_direction(SolveContext &context, Line &line) {
  // The energy of a stable Neo-Hookean body is a polynomial of degree 6 along every line; for
  // others this is a fit. Without the callback six evaluations must do.
  const int degree = context.energy_changes ? 6 : 2;
  Plane plane;
  std::vector<double> changes;
  PetscScalar slope = 0;
  PetscFunctionBegin;
  line.share = 1;
  PetscCall(open_plane(context, line, &plane));
  PetscCall(sample(context, line, plane, Polynomial::nodes(plane.dimension, degree), &changes));
  // Points of infinite energy fit no polynomial: then the line search goes along d alone.
  for (double change : changes) {
    if (!std::isfinite(change)) PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Polynomial energy(plane.dimension, degree, changes);
  const Polynomial::Point best = energy.minimum_from(full_step, bound);
  const double a = middle + reach * best[0], b = reach * best[1] * plane.previous_scale;

  PetscCall(VecDot(line.residual, line.minus_d, &slope));
  double steered_slope = -a * PetscRealPart(slope);
  if (plane.dimension > 1) {
    PetscCall(VecDot(line.residual, context.previous_step, &slope));
    steered_slope += b * PetscRealPart(slope);
  }
  if (!(steered_slope < 0)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecScale(line.minus_d, a));
  if (plane.dimension > 1) PetscCall(VecAXPY(line.minus_d, -b, context.previous_step));
  line.slope = steered_slope;
  line.share = a;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// How many corrections pay: many from factors, none from an iterative solver.
static PetscErrorCode most_corrections(const SolveContext &context, KSP ksp, int *most) {
  constexpr int from_factors = 8;
  PetscBool direct = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &direct));
  *most = context.options.corrections >= 0 ? context.options.corrections
          : direct                         ? from_factors
                                           : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode correct_step(SolveContext &context, SNESLineSearch search, Line &line) {
  constexpr PetscInt most_trials = 5;
  IterationRecord &current = context.current;
  const double first_decrease = line.energy - line.trial_energy;
  KSP ksp = nullptr;
  PetscFunctionBegin;
  int most = 0;
  PetscCall(SNESGetKSP(context.snes, &ksp));
  PetscCall(most_corrections(context, ksp, &most));
  for (int k = 0; k < most; ++k) {
    PetscScalar slope = 0;
    bool accepted = false;
    const Phase phase = context.clock.switch_to(Phase::linear_solve);
    PetscCall(KSPSolve(ksp, line.residual, line.minus_d));
    context.clock.switch_to(phase);
    ++context.summary.linear_solves;
    PetscCall(VecCopy(line.solution, line.x));
    line.energy = line.trial_energy;
    PetscCall(VecDot(line.residual, line.minus_d, &slope));
    line.slope = -PetscRealPart(slope);
    if (!(line.slope < 0)) break;
    PetscCall(steer_direction(context, line));
    PetscCall(backtrack(context, line, 1, most_trials, &accepted));
    current.trials += line.trials;
    if (!accepted) {
      PetscCall(stay(context, line));
      break;
    }
    PetscCall(take_step(context, search, line));
    ++current.corrections;
    // Once they gain little, a new Jacobian is worth its price.
    if (line.energy - line.trial_energy < context.options.correction_gain * first_decrease) break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
