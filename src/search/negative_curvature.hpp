#pragma once

#include <petscksp.h>

#include "hook/filtered_jacobian.hpp"
#include "search/solve_record.hpp"
#include "search/work_vectors.hpp"

namespace trefoil {

/// A direction p of negative curvature, where there is one.
struct NegativeCurvature {
  Vec direction = nullptr;  ///< one of the work vectors
  double squared_norm = 0;  ///< p'Mp of the preconditioner M, the filtered Jacobian or near it
};

/// Conjugate gradients on the unfiltered Hessian H from a random right-hand side, preconditioned by
/// the solver of the filtered one, which must be positive definite:
///
/// - p'Hp < 0 of a search direction p proves that H is indefinite, whatever the preconditioner;
/// - a residual below 1e-4 / sqrt(n) of the first one proves that it is definite, but for a chance
///   of about 1e-4. As long as no p'Hp was negative, the residual is q(M^-1 H) times the first one
///   for a polynomial with q(0) = 1 and positive roots, so |q| > 1 at negative arguments: the part
///   of the residual in an eigenvector of negative curvature grows. It began at about 1 / sqrt(n),
///   unless the random vector happened to have nearly no part in that eigenvector.
///
/// Collective.
/// @param most solves with the preconditioner; after so many nothing is known
/// @param like any vector of the SNES
/// @param[out] solves with the preconditioner are added to it
/// @param[out] found the direction where `kind` is a saddle; it belongs to `work`
PetscErrorCode probe_curvature(const FilteredJacobian &jacobian, PC solver, int most, Vec like,
                               WorkVectors &work, int *solves, StationaryPoint *kind,
                               NegativeCurvature *found);

}  // namespace trefoil
