#pragma once

#include <petscmat.h>

#include "hook/element_hook.hpp"

namespace trefoil {

using SetValuesFunction = PetscErrorCode (*)(Mat, PetscInt, const PetscInt[], PetscInt,
                                             const PetscInt[], const PetscScalar[], InsertMode);
using ZeroRowsFunction = PetscErrorCode (*)(Mat, PetscInt, const PetscInt[], PetscScalar, Vec, Vec);

using ZeroEntriesFunction = PetscErrorCode (*)(Mat);

/// A Mat's own operations, which the hook's call after recording.
struct ElementHook::Operations {
  explicit Operations(Mat watched) : matrix(watched) {}

  Mat matrix;  ///< borrowed: it says when it is destroyed
  ElementHook hook;
  SetValuesFunction set_values = nullptr, set_values_blocked = nullptr;
  SetValuesFunction set_values_local = nullptr, set_values_blocked_local = nullptr;
  ZeroRowsFunction zero_rows = nullptr, zero_rows_columns = nullptr;
  ZeroEntriesFunction zero_entries = nullptr;

  /// Replaces those operations of the Mat that exist and are not ours yet.
  PetscErrorCode install();
  /// Gives the Mat its own operations back.
  PetscErrorCode remove();

  PetscErrorCode watch(PetscInt m, const PetscInt *rows, PetscInt n, const PetscInt *columns,
                       const PetscScalar *values, InsertMode mode, PetscInt block_size) {
    return hook.watch(m, rows, n, columns, values, mode, block_size);
  }
  void note_zeroed(PetscInt count, const PetscInt *rows, bool columns_too) {
    if (hook.active_) hook.zeroed_.push_back({columns_too, {rows, rows + count}});
  }
};

/// matrix += factor negative, both of the same nonzero pattern; not recorded. Collective.
PetscErrorCode add_multiple(Mat matrix, double factor, Mat negative);

/// Insertion that is not recorded, of a block that the hook has been shown already.
PetscErrorCode set_values_unrecorded(Mat matrix, PetscInt n, const PetscInt *index,
                                     const PetscScalar *values);

}  // namespace trefoil
