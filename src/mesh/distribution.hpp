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

/// This rank's cells, by the whole mesh's vertex numbers, and its even share of the vertices.
struct Share {
  std::vector<PetscInt> cells;  ///< cells x nodes
  std::vector<PetscInt> sets;   ///< of groups, of each cell; empty: no cell is in one
  std::vector<double> coordinates;
  bool is_numbered = false;  ///< the two lists below are there
  std::vector<PetscInt> cell_number, vertex_number;
  PetscInt file_vertices = 0;
};

/// Fetches entries of a list of which every rank has an even share, as PetscLayout divides it.
/// @param share this rank's
/// @param places of the entries wanted
/// Collective.
PetscErrorCode fetch_from_shares(MPI_Comm comm, const std::vector<PetscInt> &share,
                                 const std::vector<PetscInt> &places, std::vector<PetscInt> *mine);

/// Makes the DMPlex, the file's numbers and the cells' sets of groups.
/// @param whole_number of each local vertex, in the whole mesh
/// Collective; mesh->shape is known.
PetscErrorCode make_from_shares(MPI_Comm comm, const Share &share, Mesh *mesh,
                                std::vector<PetscInt> *whole_number);

/// Refines, then fills the flat arrays and counts. Collective.
PetscErrorCode complete_mesh(MPI_Comm comm, PetscInt refine, Mesh *mesh);

/// Which groups and which sets of groups there are, as numbers and as names.
struct GroupTables {
  std::vector<PetscInt> numbers;
  std::string names;  ///< each ends in a zero; of several bodies one's own and \x1f come before
};
GroupTables pack_groups(const Groups &groups);
/// The other way round. Throws InputError where the tables make no sense.
void unpack_groups(const GroupTables &tables, Groups *groups);

/// Takes a rank's entities below the cells: for each dimension a number of them, their sets and
/// their corners' numbers in the whole mesh. Throws InputError where a corner is no local vertex.
void take_entities(const std::vector<PetscInt> &share, const std::vector<PetscInt> &whole_number,
                   const CellShape &shape, Groups *groups);

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
