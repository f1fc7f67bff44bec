#include "assembly/stencil_assembler.hpp"

#include <petsctime.h>

#include "filter/filter.hpp"
#include "support/log_events.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

void StencilAssembler::append_dofs(const Stencil &stencil) {
  const auto &numbers = discretization_.global_dofs();
  for (int i = 0; i < stencil.n; ++i) {
    const PetscInt dof = stencil.dofs[i];
    global_.push_back(stencil.global ? dof : numbers[static_cast<std::size_t>(dof)]);
  }
}

PetscErrorCode StencilAssembler::add(const Stencil &stencil, const double *H) {
  PetscFunctionBeginUser;
  if (stencil.n != n_ || batch_ == batch_size) PetscCall(flush());
  n_ = stencil.n;
  append_dofs(stencil);
  const auto begin = static_cast<std::ptrdiff_t>(hessians_.size());
  hessians_.insert(hessians_.end(), H, H + n_ * n_);
  if (filtering_ && shift_) {
    to_split_.insert(to_split_.end(), H, H + n_ * n_);
    shift_(stencil, to_split_.data() + begin);
  }
  ++batch_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StencilAssembler::add_split(const Stencil &stencil, const double *H, const double *N,
                                           int negative) {
  PetscFunctionBeginUser;
  PetscCall(flush());
  n_ = stencil.n;
  append_dofs(stencil);
  if (H_) PetscCall(insert(H_, H, 0));
  if (negative_ && negative > 0) {
    negatives_.assign(N, N + n_ * n_);
    for (double &entry : negatives_) entry *= negative_factor_;
    PetscCall(insert(negative_, negatives_.data(), 0));
  }
  global_.clear();
  ++statistics_.elements;
  statistics_.indefinite += filtering_ && negative > 0;
  if (filtering_ && counts_) counts_->push_back(negative);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StencilAssembler::flush() {
  PetscFunctionBeginUser;
  statistics_.elements += batch_;
  if (filtering_ && batch_) {
    PetscLogDouble begin = 0, end = 0;
    negatives_.resize(hessians_.size());
    negative_counts_.resize(static_cast<std::size_t>(batch_));
    PetscCall(PetscLogEventBegin(event_filter, nullptr, nullptr, nullptr, nullptr));
    PetscCall(PetscTime(&begin));
    const double *H = shift_ ? to_split_.data() : hessians_.data();
    const SplitResult result =
        split_with_floor(n_, batch_, H, negatives_.data(), negative_counts_.data(), floor_);
    PetscCall(PetscTime(&end));
    PetscCall(PetscLogEventEnd(event_filter, nullptr, nullptr, nullptr, nullptr));
    PetscCheck(result.status == SplitStatus::ok || result.status == SplitStatus::not_finite,
               PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK found no eigenvalues of an element Hessian");
    statistics_.filter_seconds += end - begin;
    statistics_.indefinite += result.indefinite;
    for (double &entry : negatives_) entry *= negative_factor_;
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
  to_split_.clear();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Negative indices, those of held dofs, are ignored by MatSetValues.
PetscErrorCode StencilAssembler::insert(Mat matrix, const double *values, int e) const {
  const PetscInt *index = global_.data() + static_cast<std::ptrdiff_t>(e) * n_;
  PetscFunctionBeginUser;
  PetscCall(MatSetValues(matrix, n_, index, n_, index,
                         values + static_cast<std::ptrdiff_t>(e) * n_ * n_, ADD_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
