#pragma once

#include <petscsnes.h>

#include <string>
#include <vector>

namespace trefoil {

/// Marks the unknowns of named fields, by the division of the SNES's DM: one entry for each unknown
/// of all ranks. A name that the DM does not know is an error. Collective.
/// @param fields names or numbers, separated by commas
PetscErrorCode select_fields(SNES snes, Vec x, const std::string &fields,
                             std::vector<char> *in_field);

}  // namespace trefoil
