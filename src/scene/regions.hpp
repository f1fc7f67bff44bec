#pragma once

#include <vector>

#include "mesh/mesh.hpp"
#include "output/run_report.hpp"
#include "scene/cell_states.hpp"
#include "scene/scene_options.hpp"

namespace trefoil {

/// @param where_tolerance share of the box's diagonal, see Choice
/// For each local cell 0, or 1 + the number of the region that takes it. Collective. Errors, one
/// sentence on all ranks: a malformed expression, a group that the mesh has not, a region that
/// takes no cell, two regions that take the same one.
PetscErrorCode assign_regions(const Mesh &mesh, const std::vector<RegionOptions> &regions,
                              double where_tolerance, std::vector<int> *region_of_cell);

/// What each region has at rest, the body that is left first if there is any. Collective.
PetscErrorCode measure_regions(const Mesh &mesh, const SceneOptions &options,
                               const CellStates &cells, std::vector<RegionReport> *reports);

}  // namespace trefoil
