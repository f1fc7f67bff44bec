#pragma once

#include "mesh/cell_list.hpp"

namespace trefoil {

/// Renumbers vertices and sorts cells so that neighbours in space are neighbours in memory: along
/// Morton's curve through the mesh's box. Element loops then work in the cache; the mesh stays the
/// same.
void order_along_curve(CellList &mesh);

/// How many vertices of a mesh that is ordered along the curve lie where one before them does,
/// within 1e-9 of the diagonal of the box.
PetscInt coincident_vertices(const CellList &mesh);

}  // namespace trefoil
