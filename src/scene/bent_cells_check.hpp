#pragma once

#include <string>

#include "mesh/cell_list.hpp"

namespace trefoil {

/// Refuses a mesh of quadratic cells of which one is bent so far that the Jacobian determinant of
/// the map from the reference cell is not positive at a quadrature point.
/// @throws InputError that calls the mesh `name` and the first such cell as the file counts it
void check_bent_cells(const CellList &mesh, const std::string &name);

}  // namespace trefoil
