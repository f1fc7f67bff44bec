#pragma once

#include <petscksp.h>

namespace trefoil {

/// What a linear solver's factors say of the signs of their matrix's eigenvalues: nothing where
/// their package does not count negative pivots.
enum class Inertia { unknown, definite, indefinite };

/// Factors a preconditioner's matrix as it is now, also where the SNES lags its preconditioner.
/// CHOLMOD calls a matrix that is not positive definite an error; here it is an answer.
/// @param failure PETSc's code of the failure; PETSC_ERR_MAT_CH_ZRPVT: not positive definite; 0:
/// factored
/// Collective.
PetscErrorCode try_to_factor(PC solver, PetscErrorCode *failure);

/// Whether the linear solver makes factors of the present matrix, and not keeps those of an older
/// one, whose pivots have the signs of its eigenvalues: Cholesky's, and PETSc's own LU. Not
/// collective.
PetscErrorCode makes_signed_factors(KSP ksp, bool *makes);

/// What such factors say, where their package counts. Collective.
PetscErrorCode inertia_of_factors(KSP ksp, Inertia *inertia);

}  // namespace trefoil
