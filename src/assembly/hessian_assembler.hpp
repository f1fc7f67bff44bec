#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "assembly/discretization.hpp"
#include "assembly/packed_assembler.hpp"
#include "filter/filter.hpp"
#include "term/term.hpp"
#include "trefoil.h"

namespace trefoil {

/// How Hessians are filtered.
struct HessianFilter {
  double weight = 1;      ///< w > 0 of the H + 2 w N that will be made
  EigenvalueFloor floor;  ///< under the filtered eigenvalues; elements then go one by one
  bool at_once = false;   ///< H becomes H + 2 w N; see HessianAssembler::filters_at_once()
};

/// Assembles the Hessian of a sum of terms and its negative part, each term by its own path, see
/// HessianKind. Constant parts are made once and added as matrices. Where terms couple vertices
/// without a common cell, the pattern of H follows them, and what the cells contribute is summed
/// up in matrices of its own pattern.
class HessianAssembler {
 public:
  using Terms = std::vector<std::unique_ptr<Term>>;

  /// Keeps references to both.
  HessianAssembler(const Discretization &discretization, const Terms &terms)
      : discretization_(discretization), terms_(terms) {}
  HessianAssembler(const HessianAssembler &) = delete;
  HessianAssembler &operator=(const HessianAssembler &) = delete;
  ~HessianAssembler();

  /// No batches: every matrix on its own, by LAPACK and MatSetValues.
  void go_one_by_one(bool one_by_one) { one_by_one_ = one_by_one; }
  /// Uses the places that another assembler has found for the same packs.
  void share_places(const HessianAssembler &other) {
    if (other.packed_->ready()) packed_ = other.packed_;
  }

  /// Finds the places of the elements in matrices of the cells' pattern, such as H; done with the
  /// first matrix if not here. Collective.
  PetscErrorCode prepare(Mat H);

  /// Sets H and N, either of which may be null, at local displacements u.
  /// @param filter null: nothing is split
  /// Collective.
  PetscErrorCode assemble(const double *u, Mat H, Mat N, const HessianFilter *filter,
                          TrefoilSplitStatistics *statistics);

  /// Whether H + 2 w N can be formed at once, and H multiplied by without a matrix: all elements go
  /// in batches, and the filter sees nothing but them.
  [[nodiscard]] bool filters_at_once() const;
  /// Adds H p to `product`, both 3 a local vertex; where filters_at_once().
  PetscErrorCode add_product(const double *u, const double *p, double *product) const;

  /// Sets P to the constant parts of H alone. Collective.
  PetscErrorCode assemble_constants(Mat P);

  /// Where terms couple pairs of vertices: chooses the pairs for u, and where they are others than
  /// before gives H their pattern. Destroys N unless make_negative() has made it since: one that
  /// was made before a step without N does not fit. Before assemble(). Collective.
  PetscErrorCode update_pattern(const double *u, Mat H, Mat *N);
  /// Makes N with the pattern of H. Collective.
  PetscErrorCode make_negative(Mat H, Mat *N);

  /// Number of negative eigenvalues of each cell's element. Collective.
  PetscErrorCode count_negative(const double *u, std::vector<double> *counts) const;

  [[nodiscard]] double bytes() const { return packed_->bytes(); }

 private:
  [[nodiscard]] bool goes_in_batches(const Term &term, const HessianFilter *filter) const;
  PetscErrorCode assemble_in_batches(const double *u, Mat H, Mat N, const HessianFilter *filter,
                                     TrefoilSplitStatistics *statistics);
  PetscErrorCode assemble_one_by_one(const double *u, Mat H, Mat N, const HessianFilter *filter,
                                     TrefoilSplitStatistics *statistics) const;
  PetscErrorCode add_constants(Mat H);
  void shift_filter(const ElementPacks &cells, PetscInt first, PetscInt count, double *K) const;
  void shift_stencil(const Term &term, const Stencil &stencil, double *H) const;

  const Discretization &discretization_;
  const Terms &terms_;
  bool one_by_one_ = false;
  std::shared_ptr<PackedAssembler> packed_ = std::make_shared<PackedAssembler>();
  struct Constant {
    const Term *term;
    Mat matrix;
    int version;
  };
  std::vector<Constant> constants_;
  bool has_pairs_ = false;  ///< H has places for pairs of vertices without a common cell
  PetscObjectId fitting_negative_ = 0;  ///< of the N with the pattern of the present pairs
  Mat cells_[2] = {nullptr, nullptr};   ///< the cells' part of H and N then
};

}  // namespace trefoil
