#pragma once

#include <petscsnes.h>

#include <string>

#include "hook/filtered_jacobian.hpp"
#include "search/solve_record.hpp"

namespace trefoil {

/// The JSON record of a finished solve. Collective: phases and counts are reduced over the ranks.
/// @param filter by name, "none" where another method drives
/// @param energy_offset that the objective leaves out
PetscErrorCode make_json_record(SNES snes, const std::string &filter,
                                const FilteredJacobian &jacobian, const SolveRecord &record,
                                double energy_offset, std::string *json);

}  // namespace trefoil
