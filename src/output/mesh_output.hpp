#pragma once

#include "mesh/mesh.hpp"
#include "output/snapshot.hpp"

namespace trefoil {

/// This rank's part of a distributed mesh, in the order of the file that it came from.
OutputMesh output_of(const Mesh &mesh);

/// The rows of the vertices that this rank owns.
/// @param values local vertices x components
std::vector<double> values_of_owned(const Mesh &mesh, const double *values, int components);

/// Adds the field `original_vertex`, the 0-based number of each vertex in the mesh file or -1,
/// where vertices of the output are not one by one those of the file: some were dropped, or came by
/// refinement or as midpoints of edges. Collective.
PetscErrorCode add_original_vertices(const Mesh &mesh, std::vector<Field> *fields);

}  // namespace trefoil
