#include "assembly/hessian_assembler.hpp"

#include <petsctime.h>

#include "filter/filter.hpp"
#include "support/log_events.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode HessianAssembler::add(int n, const PetscInt *dofs, const double *H) {
  PetscFunctionBeginUser;
  if (n != n_ || batch_ == batch_size) PetscCall(flush());
  n_ = n;
  const auto &global = discretization_.global_dofs();
  for (int i = 0; i < n; ++i) global_.push_back(global[static_cast<std::size_t>(dofs[i])]);
  hessians_.insert(hessians_.end(), H, H + n * n);
  ++batch_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HessianAssembler::add_split(int n, const PetscInt *dofs, const double *H,
                                           const double *N, int negative) {
  PetscFunctionBeginUser;
  PetscCall(flush());
  n_ = n;
  const auto &global = discretization_.global_dofs();
  for (int i = 0; i < n; ++i) global_.push_back(global[static_cast<std::size_t>(dofs[i])]);
  if (H_) PetscCall(insert(H_, H, 0));
  if (negative_ && negative > 0) PetscCall(insert(negative_, N, 0));
  global_.clear();
  ++statistics_.elements;
  statistics_.indefinite += filtering_ && negative > 0;
  if (filtering_ && counts_) counts_->push_back(negative);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HessianAssembler::flush() {
  PetscFunctionBeginUser;
  statistics_.elements += batch_;
  if (filtering_ && batch_) {
    PetscLogDouble begin = 0, end = 0;
    negatives_.resize(hessians_.size());
    negative_counts_.resize(static_cast<std::size_t>(batch_));
    PetscCall(PetscLogEventBegin(event_filter, nullptr, nullptr, nullptr, nullptr));
    PetscCall(PetscTime(&begin));
    const SplitResult result = split_with_floor(n_, batch_, hessians_.data(), negatives_.data(),
                                                negative_counts_.data(), floor_);
    PetscCall(PetscTime(&end));
    PetscCall(PetscLogEventEnd(event_filter, nullptr, nullptr, nullptr, nullptr));
    PetscCheck(result.status == SplitStatus::ok || result.status == SplitStatus::not_finite,
               PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK found no eigenvalues of an element Hessian");
    statistics_.filter_seconds += end - begin;
    statistics_.indefinite += result.indefinite;
  }
  for (int e = 0; e < batch_; ++e) {
    if (H_) PetscCall(insert(H_, hessians_.data(), e));
    if (!filtering_) continue;
    const int count = negative_counts_[static_cast<std::size_t>(e)];
    if (negative_ && count > 0) PetscCall(insert(negative_, negatives_.data(), e));
    if (counts_) counts_->push_back(count);
  }
  batch_ = 0;
  global_.clear();
  hessians_.clear();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Negative indices, those of held dofs, are ignored by MatSetValues.
PetscErrorCode HessianAssembler::insert(Mat matrix, const double *values, int e) const {
  const PetscInt *index = global_.data() + static_cast<std::ptrdiff_t>(e) * n_;
  PetscFunctionBeginUser;
  PetscCall(MatSetValues(matrix, n_, index, n_, index,
                         values + static_cast<std::ptrdiff_t>(e) * n_ * n_, ADD_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
