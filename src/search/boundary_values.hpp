#pragma once

#include <petscmat.h>

#include <vector>

#include "search/line_search_state.hpp"

namespace trefoil {

/// Whether the direction still moves Dirichlet values that a host enforces by the first step:
/// unknowns whose rows of H are but a diagonal, and whose residual a full step takes away. An
/// unknown that hangs on none other, but not linearly, is none of these. Collective.
/// @param[out] held rows of this rank that are but a diagonal, moved or not
PetscErrorCode moves_boundary_values(Mat H, LineSearchState &state, std::vector<char> *held,
                                     bool *moves);

}  // namespace trefoil
