#pragma once

#include "mesh/mesh.hpp"

/// The partition of a mesh of which every rank has an even share; no rank sees the whole.
namespace trefoil {

/// Sends rows of `width` numbers to ranks: rank 0's come first, each rank's in their order.
/// Collective.
PetscErrorCode send_rows(MPI_Comm comm, const std::vector<PetscInt> &rows, int width,
                         const std::vector<PetscInt> &rank_of_row, std::vector<PetscInt> *received);

/// The rank that has `place` of `total`, evenly shared as PetscLayout does.
PetscInt rank_of_place(PetscInt place, PetscInt total, PetscInt ranks);

/// Divides the cells' dual graph into as many parts as there are ranks; no part is empty.
/// @param cells this rank's even share, cells x nodes, by the whole mesh's vertex numbers
/// @param vertices of the whole mesh
/// @param partitioner one of PETSc's, "ptscotch"
/// Collective. An unknown partitioner or more ranks than cells is an error on all ranks.
PetscErrorCode partition_shares(MPI_Comm comm, const std::vector<PetscInt> &cells,
                                const CellShape &shape, PetscInt vertices,
                                const std::string &partitioner, Partition *partition);

}  // namespace trefoil
