#pragma once

#include <petscmat.h>

#include <vector>

#include "assembly/discretization.hpp"
#include "element/tet4_packs.hpp"

namespace trefoil {

/// Adds element blocks straight into the compressed rows of AIJ matrices that have the
/// discretization's pattern: every place is known beforehand, nothing is searched, nothing
/// allocated. Blocks of rows that another rank owns are collected and sent in one exchange.
///
/// For block size 3, where every vertex is wholly free or wholly held.
class DirectAssembly {
 public:
  DirectAssembly() = default;
  DirectAssembly(const DirectAssembly &) = delete;
  DirectAssembly &operator=(const DirectAssembly &) = delete;
  ~DirectAssembly();

  /// Finds all places in `matrix`, which is assembled. Collective.
  PetscErrorCode set_up(const Discretization &discretization, Mat matrix);

  /// Opens a matrix for adding, zeroed; and ends it: sends what other ranks own, and tells PETSc
  /// that the values have changed. Collective. One matrix after the other or two at once.
  struct Target {
    Mat matrix = nullptr;
    double *arrays[4] = {};        ///< own columns, other ranks' columns, for others, held
    std::vector<double> outgoing;  ///< blocks for other ranks
  };
  PetscErrorCode begin(Mat matrix, Target *target) const;
  PetscErrorCode end(Target *target) const;

  [[nodiscard]] const BlockPlaces &places() const { return places_; }
  [[nodiscard]] bool ready() const { return ready_; }
  [[nodiscard]] double bytes() const {
    return static_cast<double>((places_.code.capacity() + places_.stride.capacity()) *
                               sizeof(std::int32_t));
  }

 private:
  /// A block of rows that another rank owns, by first row and first column.
  struct Remote {
    PetscInt row, column;
    bool operator<(const Remote &other) const {
      return row != other.row ? row < other.row : column < other.column;
    }
  };
  PetscErrorCode find_rows(Mat matrix);
  PetscErrorCode place_block(PetscInt row, PetscInt column, std::int32_t *code) const;
  PetscErrorCode connect(MPI_Comm comm, const std::vector<Remote> &outgoing);

  bool ready_ = false;
  PetscInt row_begin_ = 0, row_end_ = 0;  ///< this rank's rows
  std::vector<PetscInt> row_ranges_;      ///< of all ranks
  // Copies of the rows' structure, needed while places are sought.
  std::vector<PetscInt> start_[2], column_[2], ghost_columns_;
  BlockPlaces places_;
  std::vector<std::int32_t> incoming_;  ///< where received blocks go, coded as in BlockPlaces
  std::vector<std::int32_t> incoming_stride_;
  std::size_t outgoing_count_ = 0;
  PetscSF exchange_ = nullptr;  ///< from blocks collected for others to their owners
  MPI_Datatype block_type_ = MPI_DATATYPE_NULL;
};

}  // namespace trefoil
