#pragma once

#include <string>

#include "search/line_search_state.hpp"
#include "search/solve_record.hpp"

namespace trefoil {

/// Where no step along a descending direction lowers the objective: refuses an objective whose
/// slope is not that of the residual, of which one is then not the other's gradient. Collective.
PetscErrorCode refuse_foreign_objective(LineSearchState &state);

/// Whether, without an objective, the energy falls faster and faster while the residual grows: a
/// step leads past what bounds it, or signs are turned round and a minimum is a maximum.
/// @return why the solve ends, or nothing
std::string find_endless_descent(const SolveRecord &record);

}  // namespace trefoil
