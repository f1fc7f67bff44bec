#pragma once

#include <petscmat.h>

#include <functional>
#include <utility>
#include <vector>

#include "assembly/discretization.hpp"
#include "filter/filter.hpp"
#include "term/stencil_sink.hpp"
#include "trefoil.h"

namespace trefoil {

/// Filters the matrices of stencils in batches and inserts H and N into two matrices with
/// MatSetValues; rows and columns of held dofs drop out. Either matrix may be null: then it is not
/// filled.
class StencilAssembler final : public StencilSink {
 public:
  StencilAssembler(const Discretization &discretization, Mat H, Mat negative,
                   TrefoilSplitStatistics *statistics)
      : discretization_(discretization), H_(H), negative_(negative), statistics_(*statistics) {}

  PetscErrorCode add(const Stencil &stencil, const double *H) override;
  PetscErrorCode add_split(const Stencil &stencil, const double *H, const double *N,
                           int negative) override;
  /// Works off what the last batch still holds. Not collective.
  PetscErrorCode flush();

  /// Number of negative eigenvalues of each matrix, in the order of add(); kept if asked for.
  void keep_counts(std::vector<double> *counts) { counts_ = counts; }
  /// With false, H is inserted as it is and nothing is filtered.
  void set_filtering(bool filtering) { filtering_ = filtering; }
  /// Multiplies the N of what follows.
  void set_negative_factor(double factor) { negative_factor_ = factor; }
  /// Adds to the n x n matrix of a cell's element what the filter sees beside it.
  using Shift = std::function<void(const Stencil &stencil, double *H)>;
  void set_shift(Shift shift) { shift_ = std::move(shift); }
  /// Keeps the filtered eigenvalues of the elements above a floor.
  void set_floor(const EigenvalueFloor &floor) { floor_ = floor; }

 private:
  static constexpr int batch_size = 64;
  void append_dofs(const Stencil &stencil);
  PetscErrorCode insert(Mat matrix, const double *values, int e) const;

  const Discretization &discretization_;
  Mat H_, negative_;
  TrefoilSplitStatistics &statistics_;
  bool filtering_ = true;
  double negative_factor_ = 1;
  Shift shift_;
  EigenvalueFloor floor_;
  std::vector<double> *counts_ = nullptr;
  int n_ = 0, batch_ = 0;
  std::vector<PetscInt> global_;
  std::vector<double> hessians_;  ///< to be inserted
  std::vector<double> to_split_;  ///< with what the filter sees beside them; empty: the same
  std::vector<double> negatives_;
  std::vector<int> negative_counts_;
};

}  // namespace trefoil
