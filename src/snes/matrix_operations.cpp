#include "snes/matrix_operations.hpp"

#include <memory>

#include "petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr const char *key = "trefoil_element_hook";

PetscErrorCode operations_of(Mat matrix, ElementHook::Operations **operations) {
  PetscContainer container = nullptr;
  void *stored = nullptr;
  PetscFunctionBegin;
  PetscCall(PetscObjectQuery(reinterpret_cast<PetscObject>(matrix), key,
                             reinterpret_cast<PetscObject *>(&container)));
  if (container) PetscCall(PetscContainerGetPointer(container, &stored));
  *operations = static_cast<ElementHook::Operations *>(stored);
  PetscFunctionReturn(PETSC_SUCCESS);
}

TREFOIL_CONTEXT_DESTROY(destroy_operations, operations) {
  PetscFunctionBegin;
  delete TREFOIL_CONTEXT_OF(ElementHook::Operations, operations);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Operations of one and the same shape differ in which of the Mat's own they pass on to, and in
/// whether their indices are of blocks and of the whole matrix.
using Original = SetValuesFunction ElementHook::Operations::*;

template <Original original, bool blocked>
PetscErrorCode watched_set_values(Mat matrix, PetscInt m, const PetscInt rows[], PetscInt n,
                                  const PetscInt columns[], const PetscScalar values[],
                                  InsertMode mode) {
  ElementHook::Operations *operations = nullptr;
  PetscInt block_size = 1;
  PetscFunctionBegin;
  PetscCall(operations_of(matrix, &operations));
  if (blocked && operations->hook.active()) PetscCall(MatGetBlockSize(matrix, &block_size));
  PetscCall(operations->watch(matrix, m, rows, n, columns, values, mode, block_size));
  PetscCall((operations->*original)(matrix, m, rows, n, columns, values, mode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Local indices, which a type that has this operation does not pass through set_values.
template <Original original, bool blocked>
PetscErrorCode watched_set_values_local(Mat matrix, PetscInt m, const PetscInt rows[], PetscInt n,
                                        const PetscInt columns[], const PetscScalar values[],
                                        InsertMode mode) {
  ElementHook::Operations *operations = nullptr;
  ISLocalToGlobalMapping row_map = nullptr, column_map = nullptr;
  PetscInt block_size = 1;
  PetscFunctionBegin;
  PetscCall(operations_of(matrix, &operations));
  if (operations->hook.active()) {
    if (blocked) PetscCall(MatGetBlockSize(matrix, &block_size));
    PetscCall(MatGetLocalToGlobalMapping(matrix, &row_map, &column_map));
    std::vector<PetscInt> global_rows(static_cast<std::size_t>(m));
    std::vector<PetscInt> global_columns(static_cast<std::size_t>(n));
    const auto apply =
        blocked ? ISLocalToGlobalMappingApplyBlock : ISLocalToGlobalMappingApply;
    PetscCall(apply(row_map, m, rows, global_rows.data()));
    PetscCall(apply(column_map, n, columns, global_columns.data()));
    PetscCall(operations->watch(matrix, m, global_rows.data(), n, global_columns.data(), values,
                                mode, block_size));
  }
  PetscCall((operations->*original)(matrix, m, rows, n, columns, values, mode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

template <ZeroRowsFunction ElementHook::Operations::*original, bool columns_too>
PetscErrorCode watched_zero_rows(Mat matrix, PetscInt count, const PetscInt rows[],
                                 PetscScalar diagonal, Vec x, Vec b) {
  ElementHook::Operations *operations = nullptr;
  PetscFunctionBegin;
  PetscCall(operations_of(matrix, &operations));
  operations->note_zeroed(count, rows, columns_too);
  PetscCall((operations->*original)(matrix, count, rows, diagonal, x, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode watched_zero_entries(Mat matrix) {
  ElementHook::Operations *operations = nullptr;
  PetscFunctionBegin;
  PetscCall(operations_of(matrix, &operations));
  PetscCall(operations->hook.restart());
  PetscCall(operations->zero_entries(matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

using Operations = ElementHook::Operations;

template <class Function>
PetscErrorCode exchange(Mat matrix, MatOperation operation, Function ours, Function *original) {
  void (*present)(void) = nullptr;
  PetscFunctionBegin;
  PetscCall(MatGetOperation(matrix, operation, &present));
  const auto own = reinterpret_cast<Function>(present);
  if (own && own != ours) {
    *original = own;
    PetscCall(MatSetOperation(matrix, operation, reinterpret_cast<void (*)(void)>(ours)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

template <class Function>
PetscErrorCode restore(Mat matrix, MatOperation operation, Function ours, Function original) {
  void (*present)(void) = nullptr;
  PetscFunctionBegin;
  PetscCall(MatGetOperation(matrix, operation, &present));
  if (reinterpret_cast<Function>(present) == ours) {
    PetscCall(MatSetOperation(matrix, operation, reinterpret_cast<void (*)(void)>(original)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Calls `visit` with each operation that is watched: its number, ours, and where the Mat's own is.
template <class Visit>
PetscErrorCode for_each_operation(Operations &own, Visit visit) {
  PetscFunctionBegin;
  PetscCall(visit(MATOP_SET_VALUES, &watched_set_values<&Operations::set_values, false>,
                  &own.set_values));
  PetscCall(visit(MATOP_SET_VALUES_BLOCKED,
                  &watched_set_values<&Operations::set_values_blocked, true>,
                  &own.set_values_blocked));
  PetscCall(visit(MATOP_SET_VALUES_LOCAL,
                  &watched_set_values_local<&Operations::set_values_local, false>,
                  &own.set_values_local));
  PetscCall(visit(MATOP_SET_VALUES_BLOCKEDLOCAL,
                  &watched_set_values_local<&Operations::set_values_blocked_local, true>,
                  &own.set_values_blocked_local));
  PetscCall(visit(MATOP_ZERO_ROWS, &watched_zero_rows<&Operations::zero_rows, false>,
                  &own.zero_rows));
  PetscCall(visit(MATOP_ZERO_ROWS_COLUMNS,
                  &watched_zero_rows<&Operations::zero_rows_columns, true>,
                  &own.zero_rows_columns));
  PetscCall(visit(MATOP_ZERO_ENTRIES, &watched_zero_entries, &own.zero_entries));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode ElementHook::Operations::install(Mat matrix) {
  PetscFunctionBegin;
  PetscCall(for_each_operation(*this, [matrix](MatOperation operation, auto ours, auto *original) {
    return exchange(matrix, operation, ours, original);
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::Operations::remove(Mat matrix) {
  PetscFunctionBegin;
  PetscCall(for_each_operation(*this, [matrix](MatOperation operation, auto ours, auto *original) {
    return restore(matrix, operation, ours, *original);
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::attach(Mat matrix, ElementHook **hook) {
  Operations *operations = nullptr;
  PetscFunctionBegin;
  PetscCall(operations_of(matrix, &operations));
  if (!operations) {
    PetscContainer container = nullptr;
    operations = new Operations;
    PetscCall(PetscContainerCreate(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)),
                                   &container));
    PetscCall(PetscContainerSetPointer(container, operations));
    PetscCall(PetscContainerSetCtxDestroy(container, destroy_operations));
    PetscCall(PetscObjectCompose(reinterpret_cast<PetscObject>(matrix), key,
                                 reinterpret_cast<PetscObject>(container)));
    PetscCall(PetscContainerDestroy(&container));
  }
  PetscCall(operations->install(matrix));
  *hook = &operations->hook;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::detach(Mat matrix) {
  Operations *operations = nullptr;
  PetscFunctionBegin;
  PetscCall(operations_of(matrix, &operations));
  if (operations) {
    PetscCall(operations->remove(matrix));
    PetscCall(PetscObjectCompose(reinterpret_cast<PetscObject>(matrix), key, nullptr));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::find(Mat matrix, ElementHook **hook) {
  Operations *operations = nullptr;
  PetscFunctionBegin;
  PetscCall(operations_of(matrix, &operations));
  *hook = operations ? &operations->hook : nullptr;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_values_unwatched(Mat matrix, PetscInt n, const PetscInt *index,
                                    const PetscScalar *values) {
  ElementHook::Operations *operations = nullptr;
  PetscFunctionBegin;
  PetscCall(operations_of(matrix, &operations));
  const bool was_active = operations && operations->hook.active();
  if (was_active) operations->hook.pause(true);
  PetscCall(MatSetValues(matrix, n, index, n, index, values, ADD_VALUES));
  if (was_active) operations->hook.pause(false);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
