#pragma once

#include <petscksp.h>

#include <string>

namespace trefoil {

/// Why the last linear solve failed, by PETSc's reasons or for want of memory, and the way out.
/// @param[in,out] sentence what was tried beside: "the linear solver failed, with ..."; goes on
PetscErrorCode explain_linear_failure(KSP ksp, std::string *sentence);

}  // namespace trefoil
