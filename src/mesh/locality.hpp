#pragma once

#include "mesh/cell_list.hpp"

namespace trefoil {

/// Renumbers vertices and sorts cells so that neighbours in space are neighbours in memory: along
/// Morton's curve through the mesh's box. Element loops then work in the cache; the mesh stays the
/// same.
void order_along_curve(CellList &mesh);

}  // namespace trefoil
