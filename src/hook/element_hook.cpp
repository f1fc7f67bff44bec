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

static bool is_diagonal(PetscInt n, const PetscScalar *block) {
  for (PetscInt i = 0; i < n * n; ++i) {
    if (i % (n + 1) != 0 && block[i] != 0) return false;
  }
  return true;
}

/// Numbers of single rows from those of blocks.
static void expand(PetscInt n, const PetscInt *blocks, PetscInt block_size,
                   std::vector<PetscInt> *index) {
  index->resize(static_cast<std::size_t>(n * block_size));
  for (PetscInt i = 0; i < n * block_size; ++i) {
    const PetscInt block = blocks[i / block_size];
    (*index)[static_cast<std::size_t>(i)] = block < 0 ? -1 : block_size * block + i % block_size;
  }
}

PetscErrorCode ElementHook::watch(PetscInt m, const PetscInt *rows, PetscInt n,
                                  const PetscInt *columns, const PetscScalar *values,
                                  InsertMode mode, PetscInt block_size) {
  PetscFunctionBegin;
  if (!active_ || !values) PetscFunctionReturn(PETSC_SUCCESS);
  if (block_size > 1) {
    const bool same = rows == columns;
    expand(m, rows, block_size, &index_);
    if (!same) expand(n, columns, block_size, &columns_);
    rows = index_.data();
    columns = same ? rows : columns_.data();
    m *= block_size;
    n *= block_size;
  }
  if (mode != ADD_VALUES) {
    // Preallocation inserts zeros; boundary conditions insert numbers on the diagonal.
    if (m == n && std::equal(rows, rows + m, columns) && is_diagonal(n, values)) {
      for (PetscInt i = 0; i < n; ++i) {
        if (values[n * i + i] != 0) seen_.exclude(rows[i]);
      }
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (m == 1 && n == 1) {
    PetscCall(take_single(rows[0], columns[0], values[0]));
  } else if (m == n && (rows == columns || std::equal(rows, rows + m, columns))) {
    PetscCall(take_element(n, rows, values));
  } else {
    ++counts_.rectangular;
    counts_.partial += m > 1 && m != n && std::all_of(rows, rows + m, [&](PetscInt row) {
                         return std::find(columns, columns + n, row) != columns + n;
                       });
    seen_.add(m, rows, n, columns, values);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A number on the diagonal is an element of one unknown: a spring to the ground, or what boundary
/// conditions add. One beside it is a part of an element that is added number by number.
PetscErrorCode ElementHook::take_single(PetscInt row, PetscInt column, PetscScalar value) {
  const auto is_left_out = [this](PetscInt i) {
    return i < 0 || (in_field_ && !(*in_field_)[static_cast<std::size_t>(i)]);
  };
  PetscFunctionBegin;
  seen_.add(1, &row, 1, &column, &value);
  if (value == 0 || is_left_out(row) || is_left_out(column)) PetscFunctionReturn(PETSC_SUCCESS);
  if (row != column) {
    ++counts_.singles;
  } else if (PetscRealPart(value) < 0) {
    const double negative = -PetscRealPart(value);
    ++counts_.negative_diagonals;
    PetscCall(keep(1, &row, &negative));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementHook::take_element(PetscInt n, const PetscInt *index,
                                         const PetscScalar *values) {
  PetscFunctionBegin;
  if (!active_) PetscFunctionReturn(PETSC_SUCCESS);
  seen_.add(n, index, n, index, values);
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
  const bool saddle = block.saddle || all_are_of_saddle_;
  counts_.saddle += block.finite && block.symmetric && saddle;
  if (!block.finite || !block.symmetric || saddle) PetscFunctionReturn(PETSC_SUCCESS);
  if (!pattern_is_known_) pattern_.add(n, values);
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
  double traces = 0;  // of H_e + N_e: the sum of the positive eigenvalues
  if (negative > 0) {
    ++counts_.indefinite;
    for (PetscInt i = 0; i < n; ++i) traces += N_[static_cast<std::size_t>(n * i + i)];
    PetscCall(keep(n, index, N_.data()));
  }
  const double rounding = 1e-14 * static_cast<double>(n) * traces;
  for (PetscInt i = 0; i < n; ++i) traces += PetscRealPart(values[n * i + i]);
  rising_ += traces > rounding;
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
  PetscFunctionBegin;
  active_ = always_;
  *filter_seconds = filter_seconds_;
  PetscCall(find_saddle_pattern(matrix));
  PetscCall(compare(matrix));
  PetscCall(seen_.finish(matrix));
  PetscCall(assemble_negative(matrix, false));
  if (negative_) {
    PetscCall(zero_rows_of(negative_));
    PetscCall(follow_pattern(matrix, &negative_));
  }
  *negative = negative_;
  *total = counts_;
  PetscCall(total->sum_over_ranks(PetscObjectComm(reinterpret_cast<PetscObject>(matrix))));
  forget();
  negative_ = nullptr;
  in_field_ = nullptr;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether the matrix, as it is now, is what was seen.
PetscErrorCode ElementHook::compare(Mat matrix) {
  PetscMPIInt rank = 0;
  bool differs = false;
  PetscFunctionBegin;
  PetscCall(seen_.differs(matrix, &differs));
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), &rank));
  counts_.changed += differs && rank == 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The first Jacobian tells whether its elements are those of a saddle point; then nothing of it is
/// filtered.
PetscErrorCode ElementHook::find_saddle_pattern(Mat matrix) {
  PetscInt64 blocks = 0;
  PetscMPIInt rank = 0;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(matrix));
  PetscFunctionBegin;
  if (pattern_is_known_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(pattern_.count_saddle_blocks(comm, &blocks));
  pattern_is_known_ = true;
  pattern_ = {};
  if (blocks == 0) PetscFunctionReturn(PETSC_SUCCESS);
  all_are_of_saddle_ = true;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) counts_.saddle += blocks;
  counts_.indefinite = counts_.negative_diagonals = 0;
  forget_stash();
  if (negative_) PetscCall(MatZeroEntries(negative_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ElementHook::forget_stash() {
  stashed_sizes_ = {};
  stashed_indices_ = {};
  stashed_values_ = {};
}

void ElementHook::forget() {
  forget_stash();
  counts_ = {};
  rising_ = 0;
  filter_seconds_ = 0;
  zeroed_.clear();
  seen_.restart();
  pattern_ = {};
}

}  // namespace trefoil
