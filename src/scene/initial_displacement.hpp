#pragma once

#include <string>

#include "assembly/discretization.hpp"

namespace trefoil {

/// Sets the unknowns x to the displacement that an expression with three values says at the rest
/// positions of the vertices, in units of length; held components keep what they are held at.
/// A malformed expression, a value that is not finite or `free` is an error with one sentence on
/// all ranks. Collective.
PetscErrorCode set_initial_displacement(const std::string &expression,
                                        const Discretization &discretization, Vec x);

}  // namespace trefoil
