#pragma once

#include <string>

#include "mesh/mesh.hpp"

/// Meshes in PETSc's HDF5 format, for sizes that one rank should not hold.
///
/// Cells and points lie where DMPlexTopologyView() and DMPlexCoordinatesView() of PETSc 3.18 have
/// them (/topology/cells, cones, order, orientation; /geometry/vertices). The group /trefoil has
/// what a DMPlex does not: the element, the original file's numbers, and the groups. Every rank
/// reads an even share.
namespace trefoil {

/// Whether a file begins as HDF5 does.
bool is_hdf5_file(const std::string &path);

/// Writes a mesh beside `path` and renames. Collective, an error is one on all ranks.
PetscErrorCode write_hdf5_mesh(MPI_Comm comm, const std::string &path, const Mesh &mesh);

/// Reads a mesh that write_hdf5_mesh() has written, on any number of ranks, and distributes it.
/// @param partitioner one of PETSc's; "metis", which knows one rank only, is "ptscotch" here
/// @param refine how often linear cells are refined
/// Collective; what is no such file, or a damaged one, is an error with one sentence on all ranks.
PetscErrorCode read_hdf5_mesh(MPI_Comm comm, const std::string &path,
                              const std::string &partitioner, PetscInt refine, Mesh *mesh);

}  // namespace trefoil
