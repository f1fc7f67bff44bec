#pragma once

#include <petscsys.h>

#include "rule/iteration_record.hpp"

namespace trefoil {

/// One line an iteration, with a heading before the first.
/// @param energy_offset that the objective leaves out
PetscErrorCode print_iteration(MPI_Comm comm, const IterationRecord &iteration,
                               double energy_offset);

}  // namespace trefoil
