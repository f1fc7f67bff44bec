#pragma once

#include <petscksp.h>

namespace trefoil {

/// What a linear solver's factors say of the signs of their matrix's eigenvalues: nothing where it
/// makes no Cholesky factors or its package does not count negative pivots.
enum class Inertia { unknown, definite, indefinite };

/// Collective.
PetscErrorCode inertia_of_factors(KSP ksp, Inertia *inertia);

}  // namespace trefoil
