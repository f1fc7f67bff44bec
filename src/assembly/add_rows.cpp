#include "assembly/add_rows.hpp"

#include <petsc/private/petscimpl.h>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// The compressed rows of a sequential AIJ matrix while it lives.
struct Rows {
  PetscInt count = 0;
  const PetscInt *start = nullptr, *column = nullptr;
  PetscScalar *value = nullptr;

  PetscErrorCode get(Mat matrix) {
    PetscBool done = PETSC_FALSE;
    PetscFunctionBeginUser;
    PetscCall(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &count, &start, &column, &done));
    PetscCall(MatSeqAIJGetArray(matrix, &value));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscErrorCode restore(Mat matrix) {
    PetscBool done = PETSC_FALSE;
    PetscFunctionBeginUser;
    PetscCall(MatSeqAIJRestoreArray(matrix, &value));
    PetscCall(MatRestoreRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &count, &start, &column, &done));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};

/// Columns stand in ascending order in both.
/// @param from_number, to_number the matrices' own numbers of columns; null: they are the same
/// @param found false where `to` lacks a number
PetscErrorCode add_sequential_rows(Mat from, const PetscInt *from_number, Mat to,
                                   const PetscInt *to_number, bool *found) {
  Rows source, target;
  PetscFunctionBeginUser;
  PetscCall(source.get(from));
  PetscCall(target.get(to));
  for (PetscInt row = 0; row < source.count && *found; ++row) {
    PetscInt t = target.start[row];
    for (PetscInt s = source.start[row]; s < source.start[row + 1] && *found; ++s) {
      const PetscInt wanted = from_number ? from_number[source.column[s]] : source.column[s];
      const auto column = [&] {
        return to_number ? to_number[target.column[t]] : target.column[t];
      };
      while (t < target.start[row + 1] && column() < wanted) ++t;
      *found = t < target.start[row + 1] && column() == wanted;
      if (*found) target.value[t] += source.value[s];
    }
  }
  PetscCall(target.restore(to));
  PetscCall(source.restore(from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode add_rows(Mat from, Mat to) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(to));
  PetscBool sequential = PETSC_FALSE;
  bool found = true;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(to), MATSEQAIJ, &sequential));
  if (sequential) {
    PetscCall(add_sequential_rows(from, nullptr, to, nullptr, &found));
  } else {
    Mat source[2], target[2];
    const PetscInt *from_number = nullptr, *to_number = nullptr;
    PetscCall(MatMPIAIJGetSeqAIJ(from, &source[0], &source[1], &from_number));
    PetscCall(MatMPIAIJGetSeqAIJ(to, &target[0], &target[1], &to_number));
    PetscCall(add_sequential_rows(source[0], nullptr, target[0], nullptr, &found));
    PetscCall(add_sequential_rows(source[1], from_number, target[1], to_number, &found));
  }
  PetscMPIInt all = found;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, comm));
  PetscCheck(all, comm, PETSC_ERR_PLIB, "the pattern of one matrix lacks the other's");
  // Values written into the parts do not show on the whole, and a solver would keep its old factor.
  PetscCall(MatAssemblyBegin(to, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(to, MAT_FINAL_ASSEMBLY));
  PetscCall(PetscObjectStateIncrease(reinterpret_cast<PetscObject>(to)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
