// The blocks that ranks send to the owners of their rows.

#include <petscsf.h>

#include <algorithm>
#include <numeric>

#include "assembly/matrix_blocks.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode MatrixBlocks::end_placing() {
  const std::size_t ranks = row_ranges_.size() - 1;
  std::vector<PetscMPIInt> send(ranks, 0), receive(ranks, 0), send_at(ranks, 0),
      receive_at(ranks, 0), first_at_owner(ranks, 0);
  MPI_Datatype block_dofs = MPI_DATATYPE_NULL;
  PetscFunctionBeginUser;
  for (const Block &block : outgoing_) {
    const auto owner =
        std::upper_bound(row_ranges_.begin(), row_ranges_.end(), free_dof(block.rows)) -
        row_ranges_.begin() - 1;
    ++send[static_cast<std::size_t>(owner)];
  }
  PetscCallMPI(MPI_Alltoall(send.data(), 1, MPI_INT, receive.data(), 1, MPI_INT, comm_));
  std::exclusive_scan(send.begin(), send.end(), send_at.begin(), 0);
  std::exclusive_scan(receive.begin(), receive.end(), receive_at.begin(), 0);
  std::vector<Block> arrived(static_cast<std::size_t>(receive_at.back() + receive.back()));
  static_assert(sizeof(Block) == 6 * sizeof(PetscInt));
  PetscCallMPI(MPI_Type_contiguous(6, MPIU_INT, &block_dofs));
  PetscCallMPI(MPI_Type_commit(&block_dofs));
  PetscCallMPI(MPI_Alltoallv(outgoing_.data(), send.data(), send_at.data(), block_dofs,
                             arrived.data(), receive.data(), receive_at.data(), block_dofs, comm_));
  PetscCallMPI(MPI_Type_free(&block_dofs));
  for (const Block &block : arrived) {
    PetscCall(place_own(block, &incoming_numbers_, &incoming_.emplace_back()));
  }
  // A sender's first block lies at the owner behind those of the ranks before it.
  PetscCallMPI(
      MPI_Alltoall(receive_at.data(), 1, MPI_INT, first_at_owner.data(), 1, MPI_INT, comm_));
  PetscCall(connect(send, first_at_owner));
  for (int p = 0; p < 2; ++p) start_[p] = column_[p] = {};
  ghost_columns_ = {};
  outgoing_ = {};
  discretization_ = nullptr;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Makes the exchange of blocks.
/// @param sent blocks for each rank
/// @param first_at_owner where the first of them lies there
PetscErrorCode MatrixBlocks::connect(const std::vector<PetscMPIInt> &sent,
                                     const std::vector<PetscMPIInt> &first_at_owner) {
  std::vector<PetscSFNode> destination;
  PetscFunctionBeginUser;
  for (std::size_t rank = 0; rank < sent.size(); ++rank) {
    for (PetscMPIInt i = 0; i < sent[rank]; ++i) {
      PetscSFNode node;
      node.rank = static_cast<decltype(node.rank)>(rank);
      node.index = first_at_owner[rank] + i;
      destination.push_back(node);
    }
  }
  PetscCall(PetscSFCreate(comm_, &exchange_));
  PetscCall(PetscSFSetGraph(exchange_, static_cast<PetscInt>(incoming_.size()),
                            static_cast<PetscInt>(destination.size()), nullptr, PETSC_COPY_VALUES,
                            destination.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(exchange_));
  PetscCallMPI(MPI_Type_contiguous(static_cast<int>(dim_ * dim_), MPI_DOUBLE, &block_type_));
  PetscCallMPI(MPI_Type_commit(&block_type_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
