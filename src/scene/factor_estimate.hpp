#pragma once

#include "assembly/discretization.hpp"

namespace trefoil {

/// What a Cholesky factor of the Hessian would take.
struct FactorEstimate {
  double entries = 0;  ///< numbers in the factor
  double flops = 0;    ///< multiplications to make it, each with an addition
};

/// A symbolic factorisation of the vertex graph, ordered by METIS's nested dissection: a column of
/// c blocks takes c (c + 1) / 2 products of blocks. Each rank orders the vertices that it owns,
/// with those of others last; the vertices between the ranks are taken for the separators of a
/// binary tree. About 7 us a vertex. Collective; the same on all ranks.
PetscErrorCode estimate_factor(const Discretization &discretization, FactorEstimate *estimate);

}  // namespace trefoil
