#pragma once

#include <petscsnes.h>

#include "hook/filtered_jacobian.hpp"
#include "rule/rule.hpp"
#include "search/line_search_state.hpp"
#include "search/search_memory.hpp"
#include "search/solve_record.hpp"

namespace trefoil {

/// Whether the direction may be searched along: finite, descending, and not from an indefinite
/// Hessian. Where the rule knows another weight for an indefinite one, the direction is replaced.
/// Otherwise the reason to end the solve; the record says it in words. Collective.
PetscErrorCode check_direction(SNES snes, Rule &rule, const SearchMemory &memory,
                               FilteredJacobian &jacobian, LineSearchState &state,
                               SolveRecord &record, SNESConvergedReason *reason);

}  // namespace trefoil
