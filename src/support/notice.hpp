#pragma once

#include <petscsys.h>

#include <string>

namespace trefoil {

/// Prints a sentence that a user should know, on the first rank, once between PetscInitialize() and
/// PetscFinalize() however often it is said. Collective.
PetscErrorCode say_once(MPI_Comm comm, const std::string &sentence);

/// Forgets what has been said.
void forget_notices();

}  // namespace trefoil
