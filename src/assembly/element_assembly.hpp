#pragma once

#include <petscmat.h>

#include <array>
#include <vector>

#include "assembly/discretization.hpp"
#include "element/element_packs.hpp"

namespace trefoil {

/// Adds the blocks of elements of any kind straight into the compressed rows of AIJ matrices that
/// have the discretization's pattern: what DirectAssembly is to linear tetrahedra. Every place is
/// known beforehand; blocks of rows that another rank owns are collected and sent in one exchange.
/// Vertices may be held in part.
class ElementAssembly {
 public:
  ElementAssembly() = default;
  ElementAssembly(const ElementAssembly &) = delete;
  ElementAssembly &operator=(const ElementAssembly &) = delete;
  ~ElementAssembly();

  /// Finds all places in `matrix`, which is assembled. Collective.
  PetscErrorCode set_up(const Discretization &discretization, Mat matrix);

  /// A matrix that is open for adding.
  struct Target {
    Mat matrix = nullptr;
    double *arrays[3] = {};        ///< own columns, other ranks' columns, for others
    std::vector<double> outgoing;  ///< blocks for other ranks
  };
  /// Opens a matrix, zeroed; and ends it: sends what other ranks own, and tells PETSc that the
  /// values have changed. Collective. One matrix after the other or two at once.
  PetscErrorCode begin(Mat matrix, Target *target) const;
  PetscErrorCode end(Target *target) const;

  [[nodiscard]] const ElementPlaces &places() const { return places_; }
  [[nodiscard]] bool ready() const { return ready_; }
  [[nodiscard]] double bytes() const;

 private:
  /// Global dofs of a vertex, -1 where held; the third is unused in the plane.
  using Dofs = std::array<PetscInt, 3>;
  struct Block {
    Dofs rows, columns;
    bool operator<(const Block &other) const;
  };
  /// Where a block of this rank's rows goes.
  struct Place {
    std::int32_t code = ElementPlaces::nowhere, stride = 0;
  };
  [[nodiscard]] Dofs dofs_of(const Discretization &discretization, PetscInt vertex) const;
  [[nodiscard]] bool is_mine(PetscInt row) const { return row >= row_begin_ && row < row_end_; }
  PetscErrorCode find_rows(Mat matrix);
  void collect_outgoing(const Discretization &discretization);
  PetscErrorCode place_number(PetscInt row, PetscInt column, std::int32_t *code) const;
  PetscErrorCode place_block(const Block &block, Place *place);
  PetscErrorCode place_cells(const Discretization &discretization);
  PetscErrorCode connect(MPI_Comm comm);

  bool ready_ = false;
  std::size_t dim_ = 3;
  PetscInt row_begin_ = 0, row_end_ = 0;  ///< this rank's rows
  std::vector<PetscInt> row_ranges_;      ///< of all ranks
  // Needed while places are sought.
  std::vector<PetscInt> start_[2], column_[2], ghost_columns_;
  std::vector<Block> outgoing_;
  ElementPlaces places_;
  std::vector<Place> incoming_;  ///< where received blocks go
  std::size_t outgoing_count_ = 0;
  PetscSF exchange_ = nullptr;  ///< from blocks collected for others to their owners
  MPI_Datatype block_type_ = MPI_DATATYPE_NULL;
};

}  // namespace trefoil
