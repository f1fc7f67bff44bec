#pragma once

#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "assembly/block_sums.hpp"
#include "assembly/matrix_blocks.hpp"
#include "term/packed_elements.hpp"
#include "trefoil.h"

namespace trefoil {

/// H and N of elements that come in packs: reduced Hessians in batches, filtered in batches, added
/// straight into the matrices. The slow path next to it, StencilAssembler, tests it.
class PackedAssembler {
 public:
  /// The elements of one term.
  struct Part {
    const PackedElements *elements = nullptr;
    double negative_factor = 1;  ///< what its N is multiplied by
  };
  /// What the filter sees beside an element's own Hessian, see Term::shift_filter(); may be empty.
  using Shift =
      std::function<void(const ElementPacks &cells, PetscInt first, PetscInt count, double *K)>;

  /// Prepares for matrices with the pattern of H and for these packs. Collective.
  PetscErrorCode set_up(const Discretization &discretization,
                        std::span<const ElementPacks *const> packs, Mat H);
  /// Packs worked on at a time, whole tiles: their matrices stay in the second-level cache, or not
  /// far from it, and the filter has enough of them to sort by the number of negative eigenvalues.
  static PetscInt chunk_of(const ElementPacks &packs);

  [[nodiscard]] bool ready() const { return blocks_.ready(); }
  [[nodiscard]] double bytes() const;

  /// Where it adds; for those who add in another way and compare.
  [[nodiscard]] const MatrixBlocks &blocks() const { return blocks_; }
  [[nodiscard]] const BlockSums &sums_of(const ElementPacks &packs) const;

  /// What is to be set.
  struct Wanted {
    Mat H = nullptr;           ///< null: left alone
    Mat N = nullptr;           ///< null: not wanted
    bool filtering = false;    ///< without, H only: nothing is split
    double negative_in_H = 0;  ///< H becomes H plus this times N
  };
  /// Sets matrices at the local displacements u. Without a shift where negative_in_H is not 0.
  /// @param statistics counts and seconds are added
  /// Collective.
  PetscErrorCode assemble(std::span<const Part> parts, const double *u, const Shift &shift,
                          const Wanted &wanted, TrefoilSplitStatistics *statistics) const;

  /// Adds H p at u to `product`, local arrays of 3 numbers a local vertex, without a matrix.
  static PetscErrorCode add_product(const PackedElements &elements, const double *u,
                                    const double *p, double *product);

  /// Number of negative eigenvalues of each element's Hessian at u, in the order of the elements.
  static PetscErrorCode count_negative(const PackedElements &elements, const double *u,
                                       std::vector<double> *counts);

 private:
  MatrixBlocks blocks_;
  std::vector<std::pair<const ElementPacks *, BlockSums>> sums_;
};

}  // namespace trefoil
