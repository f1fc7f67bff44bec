#pragma once

#include <string>

#include "mesh/cell_list.hpp"

namespace trefoil {

/// Makes a linear mesh quadratic: the midpoints of its edges become vertices, behind the others.
void promote_to_quadratic(CellList &mesh);

/// Leaves a quadratic mesh its corners only (the midpoints stay as vertices that no cell uses).
void drop_midpoints(CellList &mesh);

/// Cuts every linear cell into eight tetrahedra, or four triangles, at the midpoints of its edges.
void refine_uniformly(CellList &mesh);

/// Refuses a quadratic mesh that is bent so far that the Jacobian determinant of the map from the
/// reference cell is not positive at a quadrature point of a cell.
/// @throws InputError that calls the mesh `name` and numbers the first such cell from 1
void check_curved_cells(const CellList &mesh, const std::string &name);

}  // namespace trefoil
