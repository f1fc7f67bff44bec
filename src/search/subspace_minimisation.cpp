#include "search/subspace_minimisation.hpp"

#include <algorithm>
#include <cmath>

#include "search/polynomial.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

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
  Vec previous_step = nullptr;
  double previous_scale = 0;
};

PetscErrorCode open_plane(const FilteredJacobian &jacobian, SearchMemory &memory,
                          const LineSearchState &state, Plane *plane) {
  Vec product = nullptr;
  double curvature = 0;
  PetscFunctionBegin;
  plane->directions[0] = state.d;
  if (!memory.previous_step_known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(memory.vectors.get(Work::previous_step, state.x, &plane->previous_step));
  PetscCall(memory.vectors.get(Work::product, state.x, &product));
  PetscCall(MatMult(jacobian.matrix(), plane->previous_step, product));
  PetscCall(dot(product, plane->previous_step, &curvature));
  // d'Hd is -g'd where the linear system is solved; an indefinite H has no such norm.
  const double ratio = -state.slope / curvature;
  if (std::isfinite(ratio) && ratio > 0) {
    plane->dimension = 2;
    plane->previous_scale = std::sqrt(ratio);
    PetscCall(memory.vectors.get(Work::scaled_previous, state.x, &plane->directions[1]));
    PetscCall(VecAXPBY(plane->directions[1], plane->previous_scale, 0, plane->previous_step));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Energies at points of the plane, less that of x: all in one pass where the SNES has been given a
/// callback for that, else from the objective.
PetscErrorCode sample(LineSearchState &state, const Plane &plane,
                      const std::vector<Polynomial::Point> &points, std::vector<double> *changes) {
  const int m = plane.dimension;
  std::vector<double> coefficients;
  PetscFunctionBegin;
  for (const Polynomial::Point &point : points) {
    coefficients.push_back(middle + reach * point[0]);
    if (m > 1) coefficients.push_back(reach * point[1]);
  }
  changes->assign(points.size(), 0);
  if (state.f.changes_callback) {
    PetscCall(state.f.changes(state.x, m, plane.directions, static_cast<PetscInt>(points.size()),
                              coefficients.data(), changes->data()));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double *c = &coefficients[k * static_cast<std::size_t>(m)];
    double energy = 0;
    PetscCall(VecWAXPY(state.trial, c[0], plane.directions[0], state.x));
    if (m > 1) PetscCall(VecAXPY(state.trial, c[1], plane.directions[1]));
    PetscCall(state.f.evaluate(state.trial, &energy));
    (*changes)[k] = energy - state.energy;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The same changes as the quadratic model has them, with H unfiltered. Differences of energies
/// lose their digits near a solution; slopes and products keep theirs.
PetscErrorCode model(const FilteredJacobian &jacobian, SearchMemory &memory,
                     const LineSearchState &state, const Plane &plane,
                     const std::vector<Polynomial::Point> &points, std::vector<double> *changes) {
  Vec product = nullptr;
  double slopes[2] = {state.slope, 0}, H[2][2] = {};
  PetscFunctionBegin;
  PetscCall(memory.vectors.get(Work::product, state.x, &product));
  for (int i = 0; i < plane.dimension; ++i) {
    PetscCall(jacobian.multiply_unfiltered(plane.directions[i], product));
    for (int j = 0; j <= i; ++j) PetscCall(dot(product, plane.directions[j], &H[i][j]));
    if (i > 0) PetscCall(dot(state.residual, plane.directions[i], &slopes[i]));
  }
  changes->clear();
  for (const Polynomial::Point &point : points) {
    const double a = middle + reach * point[0], b = plane.dimension > 1 ? reach * point[1] : 0;
    changes->push_back(slopes[0] * a + slopes[1] * b +
                       0.5 * (H[0][0] * a * a + 2 * H[1][0] * a * b + H[1][1] * b * b));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Aims at x + a d + b p, where that descends.
PetscErrorCode turn(double a, double b, const Plane &plane, SearchMemory &memory,
                    LineSearchState &state) {
  Vec minimiser = nullptr;
  double slope = 0;
  PetscFunctionBegin;
  if (plane.dimension > 1) PetscCall(dot(state.residual, plane.previous_step, &slope));
  const double turned_slope = a * state.slope + b * slope;
  if (!(turned_slope < 0)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(memory.vectors.get(Work::plane_minimiser, state.x, &minimiser));
  PetscCall(VecAXPBY(minimiser, a, 0, state.d));
  if (plane.dimension > 1) PetscCall(VecAXPY(minimiser, b, plane.previous_step));
  state.aim(minimiser, turned_slope, a);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode minimise_in_plane(const FilteredJacobian &jacobian, SearchMemory &memory,
                                 LineSearchState &state) {
  // The energy of a stable Neo-Hookean body is a polynomial of degree 6 along every line; for
  // others this is a fit. Without the callback six evaluations must do.
  const int degree = state.f.changes_callback ? 6 : 2;
  Plane plane;
  std::vector<double> changes;
  PetscFunctionBegin;
  PetscCall(open_plane(jacobian, memory, state, &plane));
  const auto nodes = Polynomial::nodes(plane.dimension, degree);
  if (is_lost_in_rounding(state, state.slope)) {
    PetscCall(model(jacobian, memory, state, plane, nodes, &changes));
  } else {
    PetscCall(sample(state, plane, nodes, &changes));
  }
  // Points of infinite energy fit no polynomial: then the line search goes along d alone.
  for (double change : changes) {
    if (!std::isfinite(change)) PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Polynomial energy(plane.dimension, degree, changes);
  const Polynomial::Point best = energy.minimum_from(full_step, bound);
  // Where rounding of the samples could be all that the minimum is better by, the full step is as
  // good, and better known: near a solution it errs by its square, the minimum's place by the root
  // of rounding.
  constexpr double samples_noise = 1e-12;
  const double least = energy.at(best);
  if (energy.at(full_step) - least <= samples_noise * std::abs(least)) {
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const double a = middle + reach * best[0], b = reach * best[1] * plane.previous_scale;
  PetscCall(turn(a, b, plane, memory, state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
