#pragma once

#include <petscmat.h>

#include "hook/element_hook.hpp"

namespace trefoil {

using SetValuesFunction = PetscErrorCode (*)(Mat, PetscInt, const PetscInt[], PetscInt,
                                             const PetscInt[], const PetscScalar[], InsertMode);
using ZeroRowsFunction = PetscErrorCode (*)(Mat, PetscInt, const PetscInt[], PetscScalar, Vec, Vec);

using ZeroEntriesFunction = PetscErrorCode (*)(Mat);
using ScaleFunction = PetscErrorCode (*)(Mat, PetscScalar);
using DiagonalScaleFunction = PetscErrorCode (*)(Mat, Vec, Vec);
using DiagonalSetFunction = PetscErrorCode (*)(Mat, Vec, InsertMode);

/// A Mat's own operations, which the hook's call after recording.
struct ElementHook::Operations {
  explicit Operations(Mat watched) : matrix(watched) {}

  Mat matrix;  ///< borrowed: it says when it is destroyed
  ElementHook hook;
  SetValuesFunction set_values = nullptr, set_values_blocked = nullptr;
  SetValuesFunction set_values_local = nullptr, set_values_blocked_local = nullptr;
  ZeroRowsFunction zero_rows = nullptr, zero_rows_columns = nullptr;
  ZeroEntriesFunction zero_entries = nullptr;
  ScaleFunction scale = nullptr, shift = nullptr;
  DiagonalScaleFunction diagonal_scale = nullptr;
  DiagonalSetFunction diagonal_set = nullptr;

  /// Replaces those operations of the Mat that exist and are not ours yet.
  PetscErrorCode install();
  /// Gives the Mat its own operations back.
  PetscErrorCode remove();

  PetscErrorCode watch(PetscInt m, const PetscInt *rows, PetscInt n, const PetscInt *columns,
                       const PetscScalar *values, InsertMode mode, PetscInt block_size) {
    return hook.watch(m, rows, n, columns, values, mode, block_size);
  }
};

/// matrix += factor negative, both of the same nonzero pattern; not recorded. Collective.
PetscErrorCode add_multiple(Mat matrix, double factor, Mat negative);

/// Whether a Mat has no entries to see into.
bool is_matrix_free(Mat matrix);

/// Insertion that is not recorded, of a block that the hook has been shown already.
PetscErrorCode set_values_unrecorded(Mat matrix, PetscInt n, const PetscInt *index,
                                     const PetscScalar *values);

}  // namespace trefoil
