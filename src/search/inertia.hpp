#pragma once

#include <petscksp.h>

namespace trefoil {

/// What a linear solver's factors say of the signs of their matrix's eigenvalues: nothing where it
/// makes no Cholesky factors or its package does not count negative pivots.
enum class Inertia { unknown, definite, indefinite };

/// Factors a preconditioner's matrix as it is now, also where the SNES lags its preconditioner.
/// CHOLMOD calls a matrix that is not positive definite an error; here it is an answer.
/// @param failure PETSc's code of the failure; PETSC_ERR_MAT_CH_ZRPVT: not positive definite; 0:
/// factored
/// Collective.
PetscErrorCode try_to_factor(PC solver, PetscErrorCode *failure);
/// Whether it is a package whose failure is an error, which would end the SNES. Not collective.
PetscErrorCode raises_indefiniteness(KSP ksp, bool *raises);

/// Collective.
PetscErrorCode inertia_of_factors(KSP ksp, Inertia *inertia);

}  // namespace trefoil
