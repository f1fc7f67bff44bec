// What a host does to its whole Mat when the elements are in, done to N as well.

#include <algorithm>
#include <cmath>
#include <utility>

#include "hook/element_hook.hpp"
#include "hook/matrix_operations.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode ElementHook::restart() {
  PetscFunctionBegin;
  if (!active_) PetscFunctionReturn(PETSC_SUCCESS);
  forget();
  if (negative_) PetscCall(MatZeroEntries(negative_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ElementHook::note_zeroed(PetscInt count, const PetscInt *rows, bool columns_too) {
  if (!active_) return;
  zeroed_.push_back({columns_too, {rows, rows + count}});
  for (PetscInt i = 0; i < count; ++i) seen_.exclude(rows[i]);
}

PetscErrorCode ElementHook::zero_rows_of(Mat negative) {
  PetscFunctionBegin;
  for (const ZeroedRows &zeroed : zeroed_) {
    const auto count = static_cast<PetscInt>(zeroed.rows.size());
    if (zeroed.columns_too) {
      PetscCall(MatZeroRowsColumns(negative, count, zeroed.rows.data(), 0, nullptr, nullptr));
    } else {
      PetscCall(MatSetOption(negative, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
      PetscCall(MatZeroRows(negative, count, zeroed.rows.data(), 0, nullptr, nullptr));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::scale(Mat matrix, double factor) {
  PetscFunctionBegin;
  if (!active_) PetscFunctionReturn(PETSC_SUCCESS);
  if (factor == 0) {  // another way to begin anew
    PetscCall(restart());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  seen_.scale(factor);
  PetscCall(assemble_negative(matrix, factor < 0));
  // The negative part of -H_e is the positive part of H_e, which is H_e + N_e.
  if (factor < 0) {
    PetscCheck(floor_.share == 0, PetscObjectComm(reinterpret_cast<PetscObject>(matrix)),
               PETSC_ERR_SUP,
               "the Jacobian was multiplied by %g after its elements were added, which goes not "
               "together with -snes_trefoil_floor",
               factor);
    PetscCall(follow_pattern(matrix, &negative_));
    PetscCall(add_multiple(negative_, 1, matrix));
    std::swap(counts_.indefinite, rising_);
    counts_.negative_diagonals += 1;  // N is there now
  }
  if (negative_) PetscCall(MatScale(negative_, std::abs(factor)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::scale_diagonally(Mat matrix, Vec left, Vec right) {
  PetscBool equal = left == right ? PETSC_TRUE : PETSC_FALSE;
  PetscMPIInt rank = 0;
  PetscFunctionBegin;
  if (!active_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(compare(matrix));
  if (left && right && !equal) PetscCall(VecEqual(left, right, &equal));
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), &rank));
  counts_.one_sided += !equal && rank == 0;
  PetscCall(assemble_negative(matrix, false));
  if (negative_) PetscCall(MatDiagonalScale(negative_, left, right));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::add_to_diagonal(Mat matrix, Vec diagonal, double constant) {
  PetscReal least = constant;
  PetscFunctionBegin;
  if (!active_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(seen_.add_to_diagonal(matrix, diagonal, constant));
  if (diagonal) PetscCall(VecMin(diagonal, nullptr, &least));
  if (least >= 0) PetscFunctionReturn(PETSC_SUCCESS);
  // Elements of one unknown each, with negative curvature.
  PetscCall(assemble_negative(matrix, true));
  ++counts_.negative_diagonals;
  if (!diagonal) {
    PetscCall(MatShift(negative_, -constant));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  Vec positive = nullptr;
  PetscCall(VecDuplicate(diagonal, &positive));
  PetscCall(VecSet(positive, 0));
  PetscCall(VecAXPY(positive, -1, diagonal));
  PetscInt size = 0;
  PetscScalar *values = nullptr;
  PetscCall(VecGetLocalSize(positive, &size));
  PetscCall(VecGetArray(positive, &values));
  for (PetscInt i = 0; i < size; ++i) values[i] = std::max(PetscRealPart(values[i]), 0.0);
  PetscCall(VecRestoreArray(positive, &values));
  PetscCall(MatDiagonalSet(negative_, positive, ADD_VALUES));
  PetscCall(VecDestroy(&positive));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::take_as_seen(Mat matrix) {
  PetscFunctionBegin;
  if (active_) PetscCall(seen_.take(matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
