#pragma once

#include <petscvec.h>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

/// a'b of real vectors. Collective.
inline PetscErrorCode dot(Vec a, Vec b, double *product) {
  PetscScalar value = 0;
  PetscFunctionBeginUser;
  PetscCall(VecDot(a, b, &value));
  *product = PetscRealPart(value);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
