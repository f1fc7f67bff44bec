#pragma once

#include <petscsnes.h>

#include "snes/solver.hpp"

namespace trefoil {

/// One iteration, from the direction on: the solve ends where the SNES's reason is set. Collective.
PetscErrorCode iterate(Solver &solver, SNESLineSearch search);

}  // namespace trefoil
