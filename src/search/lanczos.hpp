#pragma once

#include <petscksp.h>

#include <vector>

#include "search/work_vectors.hpp"

namespace trefoil {

/// A few steps of Lanczos' method on S K^-1 S from a random vector, K the matrix that the linear
/// solver solves with and S the root of its diagonal: whether they meet negative curvature. The
/// smallest eigenvalues of K, which are the largest of its inverse, show first. A negative Ritz
/// value proves that K is indefinite; none is evidence that it is not, where nothing counts pivots.
/// Collective.
/// @param held rows of this rank that are held by Dirichlet conditions, where K may be
/// nonsymmetric; empty: none
/// @param like any vector of the solver
/// @param[out] solves with the linear solver are added to it
PetscErrorCode meets_negative_curvature(KSP ksp, const std::vector<char> &held, Vec like,
                                        WorkVectors &work, int *solves, bool *meets);

}  // namespace trefoil
