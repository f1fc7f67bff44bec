#pragma once

#include <petscsnes.h>

#include "search/line_search_state.hpp"
#include "snes/solver.hpp"

namespace trefoil {

/// The SNES's vectors, and the linear solver's direction at x; refuses SNES types and searches that
/// cannot be driven. Collective.
PetscErrorCode open_line(Solver &solver, SNESLineSearch search, LineSearchState &state);

/// Opens the record of the iteration: what is known at x before anything is tried. Collective.
PetscErrorCode open_iteration(Solver &solver, const LineSearchState &state);

}  // namespace trefoil
