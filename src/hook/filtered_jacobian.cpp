#include "hook/filtered_jacobian.hpp"

#include <utility>

#include "hook/matrix_operations.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

namespace trefoil {

FilteredJacobian::~FilteredJacobian() {
  static_cast<void>(MatDestroy(&negative_));  // errors have nowhere to go
}

void FilteredJacobian::begin_solve() {
  imposed_weight.reset();
  unfiltered_ = {};
}

PetscErrorCode FilteredJacobian::forget_negative() {
  PetscFunctionBeginUser;
  PetscCall(MatDestroy(&negative_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FilteredJacobian::form(Mat matrix, double weight, bool filtered,
                                      const InsertionCounts &counts) {
  PetscFunctionBeginUser;
  matrix_ = matrix;
  weight_ = weight;
  if (counts.elements > 0) elements_ = counts.elements;  // H itself is not watched
  unfiltered_ += counts;
  negative_present_ = false;
  unfiltered_product_ = nullptr;
  if (filtered && negative_ && counts.indefinite + counts.negative_diagonals > 0)
    PetscCall(restore_filter());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FilteredJacobian::take_formed(Mat matrix, double weight,
                                             const InsertionCounts &counts, Product unfiltered) {
  PetscFunctionBeginUser;
  PetscCall(forget_negative());
  PetscCall(form(matrix, weight, false, counts));
  negative_present_ = counts.indefinite > 0;
  if (negative_present_) unfiltered_product_ = std::move(unfiltered);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FilteredJacobian::multiply_unfiltered(Vec p, Vec Hp) const {
  PetscFunctionBeginUser;
  if (unfiltered_product_) {
    PetscCall(unfiltered_product_(p, Hp));
  } else if (negative_present_) {
    PetscCall(MatMult(negative_, p, Hp));
    PetscCall(VecScale(Hp, -2 * weight_));
    PetscCall(MatMultAdd(matrix_, p, Hp, Hp));
  } else {
    PetscCall(MatMult(matrix_, p, Hp));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FilteredJacobian::unfiltered_curvature(Vec d, Vec Hd, double *curvature) const {
  PetscFunctionBeginUser;
  PetscCall(multiply_unfiltered(d, Hd));
  PetscCall(dot(d, Hd, curvature));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FilteredJacobian::remove_filter() {
  PetscFunctionBeginUser;
  PetscCall(add_multiple(matrix_, -2 * weight_, negative_));
  negative_present_ = false;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FilteredJacobian::restore_filter() {
  PetscFunctionBeginUser;
  PetscCall(add_multiple(matrix_, 2 * weight_, negative_));
  negative_present_ = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
