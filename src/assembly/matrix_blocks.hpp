#pragma once

#include <petscmat.h>

#include <algorithm>
#include <array>
#include <vector>

#include "assembly/block_sums.hpp"
#include "assembly/discretization.hpp"

namespace trefoil {

/// The dim x dim blocks of AIJ matrices that have a discretization's pattern, one for each pair of
/// vertices: where they lie in the compressed rows is found beforehand, so that kernels add to them
/// with nothing searched and nothing allocated. Blocks of rows that another rank owns are collected
/// and sent in one exchange.
class MatrixBlocks {
 public:
  MatrixBlocks() = default;
  MatrixBlocks(const MatrixBlocks &) = delete;
  MatrixBlocks &operator=(const MatrixBlocks &) = delete;
  ~MatrixBlocks();

  /// Begins to find places in `matrix`, which is assembled. Collective; end_placing() follows.
  PetscErrorCode begin_placing(const Discretization &discretization, Mat matrix);
  /// Where the block of two local vertices that share a cell lies; nowhere if all its rows or all
  /// its columns are held.
  /// @param numbers single places are appended: of a block that is held in part
  PetscErrorCode place(PetscInt row, PetscInt column, std::vector<std::int32_t> *numbers,
                       BlockPlace *place) const;
  /// Tells the owners which blocks come to them; they find the places. Collective.
  PetscErrorCode end_placing();

  /// A matrix that is open for adding.
  struct Target {
    Mat matrix = nullptr;
    double *arrays[3] = {};        ///< own columns, other ranks' columns, for other ranks
    std::vector<double> outgoing;  ///< blocks for other ranks
  };
  /// Opens a matrix, zeroed; and ends it: sends what other ranks own, and tells PETSc that the
  /// values have changed. Collective. One matrix after the other or two at once.
  PetscErrorCode begin(Mat matrix, Target *target) const;
  PetscErrorCode end(Target *target) const;

  [[nodiscard]] bool ready() const { return exchange_; }
  [[nodiscard]] double bytes() const;

 private:
  using Dofs = std::array<PetscInt, 3>;  ///< of a vertex, as Discretization::dofs_of_vertex()
  /// Any of a vertex's dofs that is free; -1 if all are held.
  static PetscInt free_dof(const Dofs &dofs) { return *std::max_element(dofs.begin(), dofs.end()); }
  struct Block {
    Dofs rows, columns;
    bool operator<(const Block &other) const;  ///< by the rows' owner first
  };
  [[nodiscard]] bool is_mine(PetscInt row) const { return row >= row_begin_ && row < row_end_; }
  PetscErrorCode find_rows(Mat matrix);
  void collect_outgoing();
  PetscErrorCode place_number(PetscInt row, PetscInt column, std::int32_t *code) const;
  PetscErrorCode place_own(const Block &block, std::vector<std::int32_t> *numbers,
                           BlockPlace *place) const;
  PetscErrorCode connect(const std::vector<PetscMPIInt> &sent,
                         const std::vector<PetscMPIInt> &first_at_owner);

  std::size_t dim_ = 3;
  double numbers_ = 0;  ///< of this rank's rows
  MPI_Comm comm_ = MPI_COMM_NULL;
  PetscInt row_begin_ = 0, row_end_ = 0;  ///< this rank's rows
  std::vector<PetscInt> row_ranges_;      ///< of all ranks
  // Needed while places are sought: copies of the rows' structure, and the blocks for other ranks.
  const Discretization *discretization_ = nullptr;
  std::vector<PetscInt> start_[2], column_[2], ghost_columns_;
  std::vector<Block> outgoing_;

  std::size_t outgoing_count_ = 0;
  std::vector<BlockPlace> incoming_;  ///< where received blocks go
  std::vector<std::int32_t> incoming_numbers_;
  PetscSF exchange_ = nullptr;  ///< from blocks collected for others to their owners
  MPI_Datatype block_type_ = MPI_DATATYPE_NULL;
};

}  // namespace trefoil
