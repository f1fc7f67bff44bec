#pragma once

#include <petscmat.h>

#include <vector>

#include "assembly/discretization.hpp"
#include "filter/filter.hpp"
#include "term/term.hpp"
#include "trefoil.h"

namespace trefoil {

/// Filters element Hessians in batches and inserts H_e and N_e into two matrices with MatSetValues;
/// rows and columns of held dofs drop out. Either matrix may be null: then it is not filled.
class HessianAssembler final : public ElementHessianSink {
 public:
  HessianAssembler(const Discretization &discretization, Mat H, Mat negative,
                   TrefoilSplitStatistics *statistics)
      : discretization_(discretization), H_(H), negative_(negative), statistics_(*statistics) {}

  PetscErrorCode add(int n, const PetscInt *dofs, const double *H) override;
  PetscErrorCode add_split(int n, const PetscInt *dofs, const double *H, const double *N,
                           int negative) override;
  /// Works off what the last batch still holds. Not collective.
  PetscErrorCode flush();

  /// Number of negative eigenvalues of each element, in the order of add(); kept if asked for.
  void keep_counts(std::vector<double> *counts) { counts_ = counts; }
  /// With false, H is inserted as it is and nothing is filtered.
  void set_filtering(bool filtering) { filtering_ = filtering; }
  /// Keeps the filtered eigenvalues of the elements above a floor.
  void set_floor(const EigenvalueFloor &floor) { floor_ = floor; }

 private:
  static constexpr int batch_size = 64;
  PetscErrorCode insert(Mat matrix, const double *values, int e) const;

  const Discretization &discretization_;
  Mat H_, negative_;
  TrefoilSplitStatistics &statistics_;
  bool filtering_ = true;
  EigenvalueFloor floor_;
  std::vector<double> *counts_ = nullptr;
  int n_ = 0, batch_ = 0;
  std::vector<PetscInt> global_;
  std::vector<double> hessians_, negatives_;
  std::vector<int> negative_counts_;
};

}  // namespace trefoil
