#pragma once

#include "hook/filtered_jacobian.hpp"
#include "search/line_search_state.hpp"
#include "search/search_memory.hpp"

namespace trefoil {

/// Turns the direction d towards the energy's minimum in the plane of d and the previous step, so
/// that a full step reaches it; leaves it where the plane holds nothing better. Collective.
PetscErrorCode minimise_in_plane(const FilteredJacobian &jacobian, SearchMemory &memory,
                                 LineSearchState &state);

}  // namespace trefoil
