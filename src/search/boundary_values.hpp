#pragma once

#include <petscmat.h>

namespace trefoil {

/// Whether the direction still moves unknowns whose rows of H are but a diagonal: Dirichlet values
/// that a host enforces by the first step. Collective.
PetscErrorCode moves_boundary_values(Mat H, Vec direction, bool *moves);

}  // namespace trefoil
