// N beside a host's Mat: made when it is needed, with the host's nonzero pattern.

#include "hook/element_hook.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode ElementHook::flush_stash(Mat negative) {
  const PetscInt *index = stashed_indices_.data();
  const double *values = stashed_values_.data();
  PetscFunctionBegin;
  for (const PetscInt n : stashed_sizes_) {
    PetscCall(MatSetValues(negative, n, index, n, index, values, ADD_VALUES));
    index += n;
    values += n * n;
  }
  forget_stash();
  PetscCall(MatAssemblyBegin(negative, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(negative, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Brings N up to what was seen, made where any rank has an element with a negative part, or where
/// it is `needed`.
PetscErrorCode ElementHook::assemble_negative(Mat matrix, bool needed) {
  int any = needed || counts_.indefinite + counts_.negative_diagonals > 0;
  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_LOR,
                             PetscObjectComm(reinterpret_cast<PetscObject>(matrix))));
  if (any && !negative_) PetscCall(duplicate_pattern(matrix, &negative_));
  if (negative_) PetscCall(flush_stash(negative_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Makes an empty N with the host's nonzero pattern, so that H + 2 w N can be a sum of arrays.
PetscErrorCode ElementHook::duplicate_pattern(Mat matrix, Mat *negative) {
  PetscBool upper_only = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(MatDuplicate(matrix, MAT_DO_NOT_COPY_VALUES, negative));
  // A host may widen its pattern from one callback to the next.
  PetscCall(MatSetOption(*negative, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  PetscCall(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(*negative), &upper_only,
                                      MATSEQSBAIJ, MATMPISBAIJ, ""));
  if (upper_only) PetscCall(MatSetOption(*negative, MAT_IGNORE_LOWER_TRIANGULAR, PETSC_TRUE));
  // Types in parallel count changes of their pattern from the first assembly on.
  PetscCall(MatAssemblyBegin(*negative, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*negative, MAT_FINAL_ASSEMBLY));
  PetscCall(PetscObjectGetId(reinterpret_cast<PetscObject>(*negative), &duplicate_));
  PetscCall(MatGetNonzeroState(matrix, &pattern_of_matrix_));
  PetscCall(MatGetNonzeroState(*negative, &pattern_of_negative_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether neither pattern has changed since N was duplicated. BAIJ in parallel does not say when
/// it widens; but then it has more entries than N.
PetscErrorCode ElementHook::has_pattern(Mat matrix, Mat negative, bool *same) {
  PetscObjectId id = 0;
  PetscObjectState of_matrix = 0, of_negative = 0;
  MatInfo matrix_info, negative_info;
  PetscFunctionBegin;
  PetscCall(PetscObjectGetId(reinterpret_cast<PetscObject>(negative), &id));
  PetscCall(MatGetNonzeroState(matrix, &of_matrix));
  PetscCall(MatGetNonzeroState(negative, &of_negative));
  PetscCall(MatGetInfo(matrix, MAT_GLOBAL_SUM, &matrix_info));
  PetscCall(MatGetInfo(negative, MAT_GLOBAL_SUM, &negative_info));
  *same = id == duplicate_ && of_matrix == pattern_of_matrix_ &&
          of_negative == pattern_of_negative_ && matrix_info.nz_used == negative_info.nz_used;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Moves N to the host's nonzero pattern where that has changed.
PetscErrorCode ElementHook::follow_pattern(Mat matrix, Mat *negative) {
  bool same = false;
  PetscFunctionBegin;
  PetscCall(has_pattern(matrix, *negative, &same));
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  Mat former = *negative;
  PetscCall(duplicate_pattern(matrix, negative));
  // Rows that were zeroed may have lost their entries.
  PetscCall(MatSetOption(*negative, MAT_IGNORE_ZERO_ENTRIES, PETSC_TRUE));
  PetscCall(MatAXPY(*negative, 1, former, SUBSET_NONZERO_PATTERN));
  PetscCall(MatDestroy(&former));
  PetscCall(has_pattern(matrix, *negative, &same));
  PetscCheck(same, PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), PETSC_ERR_SUP,
             "the Jacobian has no room for the negative part of its elements: keep its nonzero "
             "pattern whole (no MAT_IGNORE_ZERO_ENTRIES, and MAT_KEEP_NONZERO_PATTERN before "
             "MatZeroRows())");
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
