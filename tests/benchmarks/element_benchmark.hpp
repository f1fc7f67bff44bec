#pragma once

#include <petscsys.h>

#include <string>

#include "term/element_term.hpp"

namespace trefoil {

/// Prints what energy, forces, H and N of an element cost, batched part by part and as a whole
/// against LAPACK and MatSetValues in the same run: nanoseconds an element.
/// @param resolution of the square (tri3, tri6) or of the knot (tet4, tet10)
PetscErrorCode benchmark_element(double poisson, PetscInt resolution, const std::string &element,
                                 FilterSpace space);

}  // namespace trefoil
