#pragma once

#include "element/reference_element.hpp"

namespace trefoil {

/// The consistent mass matrix of an element of density one at rest, nodes x nodes row by row:
/// integrals of the products of two shape functions, exact for straight and bent elements. It is
/// the same for every component of the displacement.
/// @param positions nodes x 3, in the order of the reference element
void mass_matrix(const ReferenceElement &reference, const double *positions, double *M);

}  // namespace trefoil
