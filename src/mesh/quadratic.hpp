#pragma once

#include "mesh/cell_list.hpp"

namespace trefoil {

/// Makes a linear mesh quadratic: the midpoints of its edges become vertices, behind the others.
void promote_to_quadratic(CellList &mesh);

/// Leaves a quadratic mesh its corners only (the midpoints stay as vertices that no cell uses).
void drop_midpoints(CellList &mesh);

}  // namespace trefoil
