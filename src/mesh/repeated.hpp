#pragma once

#include <string>
#include <vector>

#include "mesh/cell_list.hpp"

namespace trefoil {

/// For each cell the first one with the same corners, in whatever order; itself where it is that.
std::vector<PetscInt> first_with_same_corners(const CellList &mesh);

/// Takes once what the file has several times, as meshers write an element once for each physical
/// group that it is in: of cells with the same nodes one stays, in the groups of all. Likewise of
/// what else is in groups. A tetrahedron and the same turned round both stay, in the groups of
/// both, for repair_rest_shape() to judge.
/// @param name of the mesh, for errors
/// @return how many cells went
/// @throws InputError where two cells have the same corners but different midpoints
PetscInt take_once(CellList &mesh, const std::string &name);

}  // namespace trefoil
