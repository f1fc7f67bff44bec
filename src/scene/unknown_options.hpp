#pragma once

#include <petscsys.h>

#include <set>
#include <string>
#include <vector>

namespace trefoil {

/// Refuses options that nothing can read: neither one of `known` nor one of PETSc's, whose names
/// begin with what their classes are called (snes_, ksp_, log_, ...). The sentence suggests what
/// may be meant. Before the mesh is read. Collective.
PetscErrorCode refuse_unknown(MPI_Comm comm, const std::set<std::string> &known);

/// Refuses options that begin with one of `prefixes` and that nothing has asked for, where all that
/// may have done so is set up. Collective.
PetscErrorCode refuse_unused(MPI_Comm comm, const std::vector<std::string> &prefixes);

/// Refuses options of the solver that nothing has asked for, once the first iteration has set up
/// all that may have done so. What PETSc reads at its own time is excepted: -log_*, -malloc_*,
/// views and the like. Collective.
PetscErrorCode refuse_unused_of_solver(MPI_Comm comm);

}  // namespace trefoil
