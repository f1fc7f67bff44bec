#pragma once

#include <petscmat.h>

#include <array>
#include <vector>

#include "assembly/discretization.hpp"
#include "element/block_sums.hpp"

namespace trefoil {

/// Adds element blocks straight into the compressed rows of AIJ matrices that have the
/// discretization's pattern: every place is known beforehand, nothing is searched, nothing
/// allocated. Blocks of rows that another rank owns are collected and sent in one exchange.
class DirectAssembly {
 public:
  DirectAssembly() = default;
  DirectAssembly(const DirectAssembly &) = delete;
  DirectAssembly &operator=(const DirectAssembly &) = delete;
  ~DirectAssembly();

  /// Finds all places in `matrix`, which is assembled. Collective.
  PetscErrorCode set_up(const Discretization &discretization, const Tet4Packs &tets, Mat matrix);

  /// Opens a matrix for adding, zeroed; and ends it: sends what other ranks own, and tells PETSc
  /// that the values have changed. Collective. One matrix after the other or two at once.
  struct Target {
    Mat matrix = nullptr;
    double *arrays[4] = {};        ///< own columns, other ranks' columns, for other ranks
    std::vector<double> outgoing;  ///< blocks for other ranks
  };
  PetscErrorCode begin(Mat matrix, Target *target) const;
  PetscErrorCode end(Target *target) const;

  /// What a kernel adds up, into the arrays of a target.
  [[nodiscard]] const BlockSums &sums() const { return sums_; }
  [[nodiscard]] bool ready() const { return ready_; }
  [[nodiscard]] double bytes() const {
    return sums_.bytes() + static_cast<double>(incoming_.capacity() * sizeof(BlockPlace));
  }

 private:
  using Dofs = std::array<PetscInt, 3>;  ///< global numbers of a vertex; -1: held
  /// A block of rows that another rank owns.
  struct Remote {
    Dofs rows, columns;
  };
  PetscErrorCode find_rows(Mat matrix);
  PetscErrorCode collect_remote(const Discretization &discretization);
  PetscErrorCode place_number(PetscInt row, PetscInt column, std::int32_t *code) const;
  PetscErrorCode place_block(const Dofs &rows, const Dofs &columns, BlockPlace *place);
  PetscErrorCode connect(MPI_Comm comm);
  [[nodiscard]] bool is_mine(const Dofs &rows) const;

  bool ready_ = false;
  PetscInt row_begin_ = 0, row_end_ = 0;  ///< this rank's rows
  std::vector<PetscInt> row_ranges_;      ///< of all ranks
  // Needed while places are sought: copies of the rows' structure, and the blocks for other ranks.
  std::vector<PetscInt> start_[2], column_[2], ghost_columns_;
  std::vector<Remote> outgoing_;
  BlockSums sums_;
  std::vector<BlockPlace> incoming_;  ///< where received blocks go
  std::size_t outgoing_count_ = 0;
  PetscSF exchange_ = nullptr;  ///< from blocks collected for others to their owners
  MPI_Datatype block_type_ = MPI_DATATYPE_NULL;
};

}  // namespace trefoil
