#pragma once

#include <petscmat.h>

#include <vector>

namespace trefoil {

/// Makes the modes orthonormal, in order, and tells algebraic multigrid that they cost next to
/// nothing in `matrix`. Those that the ones before them span are left out. Collective.
/// @param[in,out] modes vectors of the matrix; destroyed
PetscErrorCode attach_near_null_space(Mat matrix, std::vector<Vec> *modes);

}  // namespace trefoil
