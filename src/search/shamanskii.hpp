#pragma once

#include "hook/filtered_jacobian.hpp"
#include "search/line_search_state.hpp"
#include "search/search_memory.hpp"
#include "search/search_options.hpp"
#include "search/solve_record.hpp"

namespace trefoil {

/// Shamanskii's steps after the one taken (Shamanskii 1967, "A modification of Newton's method"):
/// up to -snes_trefoil_corrections further directions from the factors of the same Jacobian, at the
/// gradient where the last one led, each searched in the plane with the step before. A
/// factorisation costs many solves, so these directions are nearly free. They end with the first
/// that the host truncates. Collective.
PetscErrorCode take_shamanskii_steps(const SearchOptions &options, SNESLineSearch search,
                                     const FilteredJacobian &jacobian, SearchMemory &memory,
                                     LineSearchState &state, SolveRecord &record);

}  // namespace trefoil
