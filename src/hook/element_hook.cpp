#include "hook/element_hook.hpp"

#include <petsctime.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/filter.hpp"
#include "support/log_events.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// What can be said of an element block without its eigenvalues.
struct BlockProperties {
  bool finite = true;
  bool symmetric = true;
  /// A zero on the diagonal beside non-zeros in its row: the multiplier block of a saddle point,
  /// whose negative eigenvalues are meant.
  bool saddle = false;
};

/// In one pass, because it is a good part of what an element costs that is not indefinite.
BlockProperties properties_of(PetscInt n, const PetscScalar *H) {
  constexpr double huge = std::numeric_limits<double>::max();
  BlockProperties block;
  double largest = 0, difference = 0;
  for (PetscInt i = 0; i < n; ++i) {
    for (PetscInt j = 0; j <= i; ++j) {
      const double lower = H[n * i + j], upper = H[n * j + i];
      const double larger = std::max(std::abs(lower), std::abs(upper));
      block.finite &= std::abs(lower) <= huge && std::abs(upper) <= huge;
      largest = std::max(largest, larger);
      difference = std::max(difference, std::abs(lower - upper));
    }
    if (H[n * i + i] == 0) {
      block.saddle |=
          std::any_of(H + n * i, H + n * (i + 1), [](double value) { return value != 0; });
    }
  }
  // Hosts compute H_e by formulas or by automatic differentiation: equal up to their rounding.
  block.symmetric = difference <= 1e-8 * largest;
  return block;
}

}  // namespace

InsertionCounts &InsertionCounts::operator+=(const InsertionCounts &more) {
  elements += more.elements;
  indefinite += more.indefinite;
  rectangular += more.rectangular;
  partial += more.partial;
  nonsymmetric += more.nonsymmetric;
  saddle += more.saddle;
  not_finite += more.not_finite;
  too_large += more.too_large;
  return *this;
}

PetscErrorCode ElementHook::watch(PetscInt m, const PetscInt *rows, PetscInt n,
                                  const PetscInt *columns, const PetscScalar *values,
                                  InsertMode mode, PetscInt block_size) {
  PetscFunctionBegin;
  // Preallocation inserts zeros or nothing; boundary conditions insert or add single numbers.
  if (!active_ || mode != ADD_VALUES || !values || (m * block_size == 1 && n * block_size == 1)) {
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (m != n) {
    ++counts_.rectangular;
    counts_.partial += m > 1 && std::all_of(rows, rows + m, [&](PetscInt row) {
                         return std::find(columns, columns + n, row) != columns + n;
                       });
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (rows != columns && !std::equal(rows, rows + m, columns)) {
    ++counts_.rectangular;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (block_size == 1) {
    PetscCall(take_element(n, rows, values));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  index_.resize(static_cast<std::size_t>(n * block_size));
  for (PetscInt i = 0; i < n * block_size; ++i) {
    const PetscInt block = rows[i / block_size];
    index_[static_cast<std::size_t>(i)] = block < 0 ? -1 : block_size * block + i % block_size;
  }
  PetscCall(take_element(n * block_size, index_.data(), values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::take_element(PetscInt n, const PetscInt *index,
                                         const PetscScalar *values) {
  PetscFunctionBegin;
  if (!active_) PetscFunctionReturn(PETSC_SUCCESS);
  if (in_field_) {
    PetscCall(split_fields(n, index, values));
  } else {
    PetscCall(split_all(n, index, values));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// With -snes_trefoil_fields only the principal sub-block of the named unknowns is filtered.
PetscErrorCode ElementHook::split_fields(PetscInt n, const PetscInt *index,
                                         const PetscScalar *values) {
  PetscFunctionBegin;
  members_.clear();
  for (PetscInt i = 0; i < n; ++i) {
    if (index[i] >= 0 && (*in_field_)[static_cast<std::size_t>(index[i])]) members_.push_back(i);
  }
  const auto size = static_cast<PetscInt>(members_.size());
  if (size == 0) PetscFunctionReturn(PETSC_SUCCESS);
  block_.resize(static_cast<std::size_t>(size * size));
  std::vector<PetscInt> numbers(members_.size());
  for (PetscInt i = 0; i < size; ++i) {
    const PetscInt row = members_[static_cast<std::size_t>(i)];
    numbers[static_cast<std::size_t>(i)] = index[row];
    for (PetscInt j = 0; j < size; ++j) {
      block_[static_cast<std::size_t>(size * i + j)] =
          values[n * row + members_[static_cast<std::size_t>(j)]];
    }
  }
  PetscCall(split_all(size, numbers.data(), block_.data()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::split_all(PetscInt n, const PetscInt *index,
                                      const PetscScalar *values) {
  int negative = 0;
  PetscFunctionBegin;
  ++counts_.elements;
  if (n > largest_element_matrix) {
    ++counts_.too_large;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  // What cannot be filtered goes on as it is; after the callback all ranks learn of it together.
  const BlockProperties block = properties_of(n, values);
  counts_.not_finite += !block.finite;
  counts_.nonsymmetric += block.finite && !block.symmetric;
  counts_.saddle += block.finite && block.symmetric && block.saddle;
  if (!block.finite || !block.symmetric || block.saddle) PetscFunctionReturn(PETSC_SUCCESS);
  PetscLogDouble begin = 0, end = 0;
  SplitResult result;
  PetscCall(PetscTime(&begin));
  if (floor_.share > 0 || !is_positive_semidefinite(static_cast<int>(n), values)) {
    N_.resize(static_cast<std::size_t>(n * n));
    result = split_with_floor(static_cast<int>(n), 1, values, N_.data(), &negative, floor_);
  }
  PetscCall(PetscTime(&end));
  filter_seconds_ += end - begin;
  PetscCheck(result.status == SplitStatus::ok, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "LAPACK found no eigenvalues of an element block");
  if (negative > 0) {
    ++counts_.indefinite;
    PetscCall(keep(n, index, N_.data()));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::keep(PetscInt n, const PetscInt *index, const double *N) {
  PetscFunctionBegin;
  if (negative_) {
    PetscCall(MatSetValues(negative_, n, index, n, index, N, ADD_VALUES));
  } else {
    stashed_sizes_.push_back(n);
    stashed_indices_.insert(stashed_indices_.end(), index, index + n);
    stashed_values_.insert(stashed_values_.end(), N, N + n * n);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::begin(Mat negative, const std::vector<char> *in_field) {
  PetscFunctionBegin;
  in_field_ = in_field;
  negative_ = negative;
  if (negative_) PetscCall(MatZeroEntries(negative_));
  if (!always_) forget();
  active_ = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::end(Mat matrix, Mat *negative, InsertionCounts *total,
                                double *filter_seconds) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(matrix));
  PetscFunctionBegin;
  active_ = always_;
  *filter_seconds = filter_seconds_;
  PetscInt64 counts[] = {counts_.elements,   counts_.indefinite,   counts_.rectangular,
                         counts_.partial,    counts_.nonsymmetric, counts_.saddle,
                         counts_.not_finite, counts_.too_large};
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 8, MPIU_INT64, MPI_SUM, comm));
  *total = {counts[0], counts[1], counts[2], counts[3], counts[4], counts[5], counts[6], counts[7]};

  if (total->indefinite > 0 && !*negative) PetscCall(duplicate_pattern(matrix, negative));
  if (*negative) {
    PetscCall(flush_stash(*negative));
    PetscCall(zero_rows_of(*negative));
    PetscCall(follow_pattern(matrix, negative));
  }
  forget();
  negative_ = nullptr;
  in_field_ = nullptr;
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

PetscErrorCode ElementHook::flush_stash(Mat negative) {
  const PetscInt *index = stashed_indices_.data();
  const double *values = stashed_values_.data();
  PetscFunctionBegin;
  for (const PetscInt n : stashed_sizes_) {
    PetscCall(MatSetValues(negative, n, index, n, index, values, ADD_VALUES));
    index += n;
    values += n * n;
  }
  PetscCall(MatAssemblyBegin(negative, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(negative, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ElementHook::forget() {
  stashed_sizes_ = {};
  stashed_indices_ = {};
  stashed_values_ = {};
  counts_ = {};
  filter_seconds_ = 0;
  zeroed_.clear();
}

PetscErrorCode ElementHook::restart() {
  PetscFunctionBegin;
  if (!active_) PetscFunctionReturn(PETSC_SUCCESS);
  forget();
  if (negative_) PetscCall(MatZeroEntries(negative_));
  PetscFunctionReturn(PETSC_SUCCESS);
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

}  // namespace trefoil
