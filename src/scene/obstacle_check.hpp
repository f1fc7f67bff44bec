#pragma once

#include <string>
#include <vector>

#include "mesh/io/surface_file.hpp"
#include "mesh/mesh.hpp"
#include "term/contact_surface.hpp"

namespace trefoil {

/// Throws InputError: a facet of another kind than those of the body's surface, or without extent,
/// from which no distance has a direction.
/// @param file where the surface was read from
/// @param is_plane whether bodies are in the plane, where they meet segments
void check_facets(const SurfaceMesh &surface, const std::string &file, bool is_plane);

/// No obstacle may lie within a body, where their surfaces do not meet: an error that names it, on
/// all ranks, where a point of one is in a cell at rest. Collective.
/// @param surfaces where they are at the start, the same on all ranks
PetscErrorCode check_outside(const Mesh &mesh, const std::vector<ObstacleSurface> &surfaces);

/// Nor may a body lie within another one: likewise. Collective.
PetscErrorCode check_bodies_apart(const Mesh &mesh, const ContactSurface &surface);

}  // namespace trefoil
