#pragma once

#include <vector>

#include "mesh/mesh.hpp"
#include "scene/scene_options.hpp"

namespace trefoil {

/// The forces of all loads at time t on the vertices that this rank owns, 3 a local vertex.
/// Collective. Errors, one sentence on all ranks: a malformed expression, a load that takes no
/// facet, gravity on a body without mass.
/// @param density_of_cell mass per rest volume of each local cell
PetscErrorCode evaluate_loads(const Mesh &mesh, const LoadOptions &loads,
                              const std::vector<double> &density_of_cell, double time,
                              std::vector<double> *forces);

}  // namespace trefoil
