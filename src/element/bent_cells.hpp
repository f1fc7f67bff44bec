#pragma once

#include <petscsystypes.h>

#include <vector>

#include "element/reference_element.hpp"

namespace trefoil {

/// The first of quadratic cells that is bent so far that the Jacobian determinant of the map from
/// the reference cell is not positive at a quadrature point.
/// @param coordinates vertices x 3
/// @param cells cells x nodes of the reference element, vertex numbers
/// @return its place among the cells; -1: there is none
PetscInt first_bent_cell(const ReferenceElement &reference, const std::vector<double> &coordinates,
                         const std::vector<PetscInt> &cells);

}  // namespace trefoil
