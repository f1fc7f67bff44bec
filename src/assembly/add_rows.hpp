#pragma once

#include <petscmat.h>

namespace trefoil {

/// Adds the numbers of an AIJ matrix to one of the same rows and ranks whose pattern contains its
/// own. Collective.
PetscErrorCode add_rows(Mat from, Mat to);

}  // namespace trefoil
