#pragma once

#include <vector>

#include "mesh/boundary.hpp"
#include "mesh/mesh.hpp"

namespace trefoil {

/// Whether each local cell is in a group of cells.
/// @param group place in mesh.groups.list(), as find_group() gives it
std::vector<char> cells_of_group(const Mesh &mesh, int group);

/// Whether each local vertex, midpoints of edges included, is a node of what is in a group of any
/// dimension. Ghosts know it too. Collective.
PetscErrorCode vertices_of_group(const Mesh &mesh, int group, std::vector<char> *taken);

/// The facets in a group of surfaces (of a plane mesh: of curves) that are on the surface of the
/// body, each on one rank. Collective.
/// @param inner how many others, between two cells, are in it; on all ranks
PetscErrorCode facets_of_group(const Mesh &mesh, int group, std::vector<Facet> *facets,
                               PetscInt *inner);

}  // namespace trefoil
