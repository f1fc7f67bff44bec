#include "hook/matrix_operations.hpp"

#include <memory>
#include <vector>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr const char *key = "trefoil_element_hook";

using Operations = ElementHook::Operations;

/// Every hook there is, a handful. Not only composed with its Mat, because MatHeaderMerge(), in
/// MatAXPY() with another nonzero pattern say, keeps a Mat's operations and forgets the rest. Never
/// destroyed: a host may finalise PETSc, and destroy Mats, from a destructor of its own after ours.
std::vector<std::unique_ptr<Operations>> &hooks() {
  static auto &all = *new std::vector<std::unique_ptr<Operations>>;
  return all;
}

Operations *operations_of(Mat matrix) {
  for (const auto &operations : hooks()) {
    if (operations->matrix == matrix) return operations.get();
  }
  return nullptr;
}

void forget_operations(Mat matrix) {
  std::erase_if(hooks(), [matrix](const auto &own) { return own->matrix == matrix; });
}

/// The Mat destroys what is composed with it, and may live on.
TREFOIL_CONTEXT_DESTROY(matrix_is_destroyed, stored) {
  const Mat matrix = TREFOIL_CONTEXT_OF(Operations, stored)->matrix;
  PetscInt references = 0;
  PetscFunctionBegin;
  PetscCall(PetscObjectGetReference(reinterpret_cast<PetscObject>(matrix), &references));
  if (references == 0) forget_operations(matrix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Lets the Mat say when it is destroyed.
PetscErrorCode compose(Operations &operations) {
  const auto matrix = reinterpret_cast<PetscObject>(operations.matrix);
  PetscObject present = nullptr;
  PetscContainer container = nullptr;
  PetscFunctionBegin;
  PetscCall(PetscObjectQuery(matrix, key, &present));
  if (present) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscContainerCreate(PetscObjectComm(matrix), &container));
  PetscCall(PetscContainerSetPointer(container, &operations));
  PetscCall(PetscContainerSetCtxDestroy(container, matrix_is_destroyed));
  PetscCall(PetscObjectCompose(matrix, key, reinterpret_cast<PetscObject>(container)));
  PetscCall(PetscContainerDestroy(&container));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Operations of one and the same shape differ in which of the Mat's own they pass on to, and in
/// whether their indices are of blocks and of the whole matrix.
using Original = SetValuesFunction Operations::*;

template <Original original, bool blocked>
PetscErrorCode watched_set_values(Mat matrix, PetscInt m, const PetscInt rows[], PetscInt n,
                                  const PetscInt columns[], const PetscScalar values[],
                                  InsertMode mode) {
  Operations *operations = operations_of(matrix);
  PetscInt block_size = 1;
  PetscFunctionBegin;
  if (blocked && operations->hook.active()) PetscCall(MatGetBlockSize(matrix, &block_size));
  PetscCall(operations->watch(m, rows, n, columns, values, mode, block_size));
  PetscCall((operations->*original)(matrix, m, rows, n, columns, values, mode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Local indices, which a type that has this operation does not pass through set_values.
template <Original original, bool blocked>
PetscErrorCode watched_set_values_local(Mat matrix, PetscInt m, const PetscInt rows[], PetscInt n,
                                        const PetscInt columns[], const PetscScalar values[],
                                        InsertMode mode) {
  Operations *operations = operations_of(matrix);
  ISLocalToGlobalMapping row_map = nullptr, column_map = nullptr;
  PetscInt block_size = 1;
  PetscFunctionBegin;
  if (operations->hook.active()) {
    if (blocked) PetscCall(MatGetBlockSize(matrix, &block_size));
    PetscCall(MatGetLocalToGlobalMapping(matrix, &row_map, &column_map));
    std::vector<PetscInt> global_rows(static_cast<std::size_t>(m));
    std::vector<PetscInt> global_columns(static_cast<std::size_t>(n));
    const auto apply = blocked ? ISLocalToGlobalMappingApplyBlock : ISLocalToGlobalMappingApply;
    PetscCall(apply(row_map, m, rows, global_rows.data()));
    PetscCall(apply(column_map, n, columns, global_columns.data()));
    PetscCall(operations->watch(m, global_rows.data(), n, global_columns.data(), values, mode,
                                block_size));
  }
  PetscCall((operations->*original)(matrix, m, rows, n, columns, values, mode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

template <ZeroRowsFunction Operations::*original, bool columns_too>
PetscErrorCode watched_zero_rows(Mat matrix, PetscInt count, const PetscInt rows[],
                                 PetscScalar diagonal, Vec x, Vec b) {
  Operations *operations = operations_of(matrix);
  PetscFunctionBegin;
  operations->hook.note_zeroed(count, rows, columns_too);
  PetscCall((operations->*original)(matrix, count, rows, diagonal, x, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode watched_zero_entries(Mat matrix) {
  Operations *operations = operations_of(matrix);
  PetscFunctionBegin;
  PetscCall(operations->hook.restart());
  PetscCall(operations->zero_entries(matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode watched_scale(Mat matrix, PetscScalar factor) {
  Operations *operations = operations_of(matrix);
  PetscFunctionBegin;
  PetscCall(operations->hook.scale(matrix, PetscRealPart(factor)));
  PetscCall(operations->scale(matrix, factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode watched_diagonal_scale(Mat matrix, Vec left, Vec right) {
  Operations *operations = operations_of(matrix);
  PetscFunctionBegin;
  PetscCall(operations->hook.scale_diagonally(matrix, left, right));
  PetscCall(operations->diagonal_scale(matrix, left, right));
  PetscCall(operations->hook.take_as_seen(matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Types may do these by inserting numbers, which are none of the host's.
PetscErrorCode watched_shift(Mat matrix, PetscScalar constant) {
  Operations *operations = operations_of(matrix);
  const bool was_active = operations->hook.active();
  PetscFunctionBegin;
  PetscCall(operations->hook.add_to_diagonal(matrix, nullptr, PetscRealPart(constant)));
  if (was_active) operations->hook.pause(true);
  PetscCall(operations->shift(matrix, constant));
  if (was_active) operations->hook.pause(false);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode watched_diagonal_set(Mat matrix, Vec diagonal, InsertMode mode) {
  Operations *operations = operations_of(matrix);
  const bool was_active = operations->hook.active();
  PetscFunctionBegin;
  if (mode == ADD_VALUES) PetscCall(operations->hook.add_to_diagonal(matrix, diagonal, 0));
  if (was_active) operations->hook.pause(true);
  PetscCall(operations->diagonal_set(matrix, diagonal, mode));
  if (was_active) operations->hook.pause(false);
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
  PetscCall(
      visit(MATOP_ZERO_ROWS, &watched_zero_rows<&Operations::zero_rows, false>, &own.zero_rows));
  PetscCall(visit(MATOP_ZERO_ROWS_COLUMNS, &watched_zero_rows<&Operations::zero_rows_columns, true>,
                  &own.zero_rows_columns));
  PetscCall(visit(MATOP_ZERO_ENTRIES, &watched_zero_entries, &own.zero_entries));
  PetscCall(visit(MATOP_SCALE, &watched_scale, &own.scale));
  PetscCall(visit(MATOP_SHIFT, &watched_shift, &own.shift));
  PetscCall(visit(MATOP_DIAGONAL_SCALE, &watched_diagonal_scale, &own.diagonal_scale));
  PetscCall(visit(MATOP_DIAGONAL_SET, &watched_diagonal_set, &own.diagonal_set));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode ElementHook::Operations::install() {
  PetscFunctionBegin;
  PetscCall(for_each_operation(*this, [this](MatOperation operation, auto ours, auto *original) {
    return exchange(matrix, operation, ours, original);
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::Operations::remove() {
  PetscFunctionBegin;
  PetscCall(for_each_operation(*this, [this](MatOperation operation, auto ours, auto *original) {
    return restore(matrix, operation, ours, *original);
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::attach(Mat matrix, ElementHook **hook) {
  Operations *operations = operations_of(matrix);
  PetscFunctionBegin;
  if (!operations) {
    operations = hooks().emplace_back(std::make_unique<Operations>(matrix)).get();
  }
  PetscCall(compose(*operations));
  PetscCall(operations->install());
  *hook = &operations->hook;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::detach(Mat matrix) {
  Operations *operations = operations_of(matrix);
  PetscFunctionBegin;
  if (operations) {
    PetscCall(operations->remove());
    PetscCall(PetscObjectCompose(reinterpret_cast<PetscObject>(matrix), key, nullptr));
    forget_operations(matrix);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

ElementHook *ElementHook::find(Mat matrix) {
  Operations *operations = operations_of(matrix);
  return operations ? &operations->hook : nullptr;
}

PetscErrorCode add_multiple(Mat matrix, double factor, Mat negative) {
  ElementHook *hook = ElementHook::find(matrix);
  const bool was_active = hook && hook->active();
  PetscInt block_size = 1;
  PetscBool symmetric = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(MatGetBlockSize(matrix, &block_size));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(matrix), MATMPISBAIJ, &symmetric));
  if (was_active) hook->pause(true);
  // With the same pattern, PETSc 3.18's MatAXPY_MPISBAIJ() adds one number a block.
  PetscCall(MatAXPY(matrix, factor, negative,
                    symmetric && block_size > 1 ? SUBSET_NONZERO_PATTERN : SAME_NONZERO_PATTERN));
  if (was_active) hook->pause(false);
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool is_matrix_free(Mat matrix) {
  PetscBool free = PETSC_FALSE;
  const PetscErrorCode error = PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(matrix),
                                                         &free, MATMFFD, MATSHELL, "");
  return error || free;
}

PetscErrorCode set_values_unrecorded(Mat matrix, PetscInt n, const PetscInt *index,
                                     const PetscScalar *values) {
  ElementHook *hook = ElementHook::find(matrix);
  const bool was_active = hook && hook->active();
  PetscFunctionBegin;
  if (was_active) hook->pause(true);
  PetscCall(MatSetValues(matrix, n, index, n, index, values, ADD_VALUES));
  if (was_active) hook->pause(false);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
