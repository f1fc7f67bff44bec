#pragma once

#include "assembly/matrix_blocks.hpp"
#include "element/element_packs.hpp"
#include "term/term.hpp"
#include "trefoil.h"

namespace trefoil {

/// H and N of a term whose elements come in packs: reduced Hessians in batches, filtered in
/// batches, added straight into the matrices. The plain path next to it, HessianAssembler, tests
/// it.
class BatchedHessian {
 public:
  /// Prepares for matrices with the pattern of H. Collective.
  PetscErrorCode set_up(const Discretization &discretization, const Term &term, Mat H);
  [[nodiscard]] bool ready() const { return blocks_.ready(); }
  [[nodiscard]] double bytes() const { return blocks_.bytes() + sums_.bytes() + places_.bytes(); }

  /// Where it adds; for those who add in another way and compare.
  [[nodiscard]] const MatrixBlocks &blocks() const { return blocks_; }
  [[nodiscard]] const BlockSums &sums() const { return sums_; }
  [[nodiscard]] const ElementPlaces &places() const { return places_; }

  /// Sets H (may be null: left alone) and N (may be null: not wanted) at the local displacements u.
  /// @param filtering false: H only, nothing is split
  /// @param statistics counts and seconds are added
  /// Collective.
  PetscErrorCode assemble(const Term &term, const double *u, Mat H, Mat N, bool filtering,
                          TrefoilSplitStatistics *statistics) const;

  /// Number of negative eigenvalues of each element's Hessian at u, in the order of the cells.
  static PetscErrorCode count_negative(const Term &term, const double *u,
                                       std::vector<double> *counts);

 private:
  MatrixBlocks blocks_;
  BlockSums sums_;        ///< of Tet4Packs
  ElementPlaces places_;  ///< of PackedElements
};

}  // namespace trefoil
