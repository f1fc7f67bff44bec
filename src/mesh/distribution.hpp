#pragma once

#include <petscsf.h>

#include <numeric>

#include "mesh/mesh.hpp"
#include "support/petsc_compatibility.hpp"

/// The steps of distribute_mesh(), which see parts of a mesh that is not complete yet.
namespace trefoil {

/// Sends rank r `counts[r]` consecutive entries of `all`, which only the first rank has.
/// Collective.
template <class T>
PetscErrorCode scatter(MPI_Comm comm, MPI_Datatype type, const std::vector<T> &all,
                       const std::vector<PetscMPIInt> &counts, std::vector<T> *mine) {
  PetscMPIInt rank = 0, count = 0;
  std::vector<PetscMPIInt> offsets(counts.size(), 0);
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  PetscCallMPI(MPI_Scatter(counts.data(), 1, MPI_INT, &count, 1, MPI_INT, 0, comm));
  mine->resize(static_cast<std::size_t>(count));
  PetscCallMPI(MPI_Scatterv(all.data(), counts.data(), offsets.data(), type, mine->data(), count,
                            type, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Tells every rank which groups there are, and sends it those of its cells' points, edges and
/// faces that are in groups, each to one rank. Collective.
/// @param whole_number of each local vertex, in the whole mesh
PetscErrorCode distribute_groups(MPI_Comm comm, const CellList &whole, const Partition &partition,
                                 const std::vector<PetscInt> &whole_number, Mesh *mesh);

/// Counts what is in each group. Collective.
PetscErrorCode count_groups(MPI_Comm comm, Mesh *mesh);

/// Refines the DMPlex of linear cells, and what the mesh knows of groups and of the file's numbers.
/// Collective.
PetscErrorCode refine_distributed(PetscInt levels, Mesh *mesh);

/// Fills the flat arrays of coordinates, vertices and cells from the DMPlex, and counts.
/// Collective.
PetscErrorCode take_arrays(Mesh *mesh);

}  // namespace trefoil
