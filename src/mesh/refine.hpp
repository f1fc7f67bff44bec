#pragma once

#include "mesh/cell_list.hpp"

namespace trefoil {

/// Cuts every linear cell into eight tetrahedra, or four triangles, at the midpoints of its edges;
/// a cell's children follow each other. What is in groups is cut likewise.
void refine_uniformly(CellList &mesh);

}  // namespace trefoil
