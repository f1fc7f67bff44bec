#include "mesh/dual_graph.hpp"

#include <petscpartitioner.h>

#include <cstdlib>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode divide(MPI_Comm comm, const std::string &name, const DualGraph &graph,
                      std::vector<PetscInt> *part) {
  PetscPartitioner partitioner = nullptr;
  PetscSection sizes = nullptr;
  IS order = nullptr;
  const PetscInt *cell = nullptr;
  std::vector<PetscInt> rows(graph.start), columns(graph.neighbour);
  const auto cells = static_cast<PetscInt>(rows.size()) - 1;
  PetscMPIInt ranks = 0;
  PetscErrorCode (*create)(PetscPartitioner) = nullptr;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(PetscPartitionerInitializePackage());
  PetscCall(PetscFunctionListFind(PetscPartitionerList, name.c_str(), &create));
  PetscCheck(create, comm, PETSC_ERR_USER_INPUT,
             "there is no partitioner '%s' (-mesh_partitioner); use metis or ptscotch",
             name.c_str());
  // With threads PT-Scotch 7.0.3 divides otherwise each time, and in one of some ten runs on 6
  // ranks its ranks wait for each other for ever, or crash; with one thread none of 60 did.
  setenv("SCOTCH_PTHREAD_NUMBER", "1", 0);
  PetscCall(PetscPartitionerCreate(comm, &partitioner));
  PetscCall(PetscPartitionerSetType(partitioner, name.c_str()));
  PetscCall(PetscPartitionerSetFromOptions(partitioner));
  PetscCall(PetscSectionCreate(comm, &sizes));
#if PETSC_VERSION_LT(3, 21, 0)
  PetscCall(PetscPartitionerPartition(partitioner, ranks, cells, rows.data(), columns.data(),
                                      nullptr, nullptr, sizes, &order));
#else
  PetscCall(PetscPartitionerPartition(partitioner, ranks, cells, rows.data(), columns.data(),
                                      nullptr, nullptr, nullptr, sizes, &order));
#endif
  part->assign(static_cast<std::size_t>(cells), 0);
  PetscCall(ISGetIndices(order, &cell));
  for (PetscInt p = 0; p < ranks; ++p) {
    PetscInt count = 0, offset = 0;
    PetscCall(PetscSectionGetDof(sizes, p, &count));
    PetscCall(PetscSectionGetOffset(sizes, p, &offset));
    for (PetscInt i = 0; i < count; ++i) (*part)[static_cast<std::size_t>(cell[offset + i])] = p;
  }
  PetscCall(ISRestoreIndices(order, &cell));
  PetscCall(ISDestroy(&order));
  PetscCall(PetscSectionDestroy(&sizes));
  PetscCall(PetscPartitionerDestroy(&partitioner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
