#pragma once

#include <petscsnes.h>

namespace trefoil {

/// Prints the options of the solver, with its defaults in a scene: those of the plugin, and PETSc's
/// of SNES, line search, KSP and PC. For -help, without a scene. Collective.
PetscErrorCode print_solver_help(MPI_Comm comm);

}  // namespace trefoil
