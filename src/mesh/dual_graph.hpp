#pragma once

#include <petscsys.h>

#include <string>
#include <vector>

namespace trefoil {

/// Which cells share a facet, as compressed rows: those of this rank's cells, with neighbours by
/// their numbers in the whole mesh.
struct DualGraph {
  std::vector<PetscInt> start{0}, neighbour;
};

/// Divides the cells into as many parts as there are ranks, by one of PETSc's partitioners; the
/// rows may lie on the ranks in any shares, all on one as well. Collective; an unknown partitioner
/// is an error with a sentence.
/// @param[out] part the part of each of this rank's cells
PetscErrorCode divide(MPI_Comm comm, const std::string &partitioner, const DualGraph &graph,
                      std::vector<PetscInt> *part);

}  // namespace trefoil
