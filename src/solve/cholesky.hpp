#pragma once

#include <petscpc.h>

namespace trefoil {

/// Cholesky factors of a definite matrix by the fastest package that is there: CHOLMOD on one rank,
/// MUMPS on several. Not collective.
PetscErrorCode set_cholesky(PC pc);

}  // namespace trefoil
