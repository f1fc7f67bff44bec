#include "filter/filter.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <new>
#include <vector>

extern "C" void dsyev_(const char *vectors, const char *triangle, const int *n, double *a,
                       const int *leading_dimension, double *eigenvalues, double *work,
                       const int *work_size, int *info, std::size_t, std::size_t);

namespace trefoil {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

struct Workspace {
  std::vector<double> matrix;       ///< n x n: the scaled symmetric part, then its eigenvectors
  std::vector<double> factor;       ///< n x n: the lower triangle is overwritten by L
  std::vector<double> eigenvalues;  ///< n, ascending
  std::vector<double> lapack;

  bool reserve(int n) noexcept {
    const auto rows = static_cast<std::size_t>(n);
    if (lapack_size(n) <= static_cast<int>(lapack.size())) return true;
    try {
      matrix.resize(rows * rows);
      factor.resize(rows * rows);
      eigenvalues.resize(rows);
      lapack.resize(static_cast<std::size_t>(lapack_size(n)));  // last: tells that all are there
    } catch (const std::bad_alloc &) {
      return false;
    }
    return true;
  }
  /// dsyev wants (block size + 2) n to work in blocks; LAPACK's block size is at most 64.
  static int lapack_size(int n) { return 66 * n; }
};

Workspace &workspace_of_thread() {
  thread_local Workspace workspace;
  return workspace;
}

/// 2^exponent as two factors: one double reaches neither 2^1074 nor 2^-1074 with all its digits.
class PowerOfTwo {
 public:
  explicit PowerOfTwo(int exponent)
      : half_(std::ldexp(1.0, exponent / 2)),
        other_half_(std::ldexp(1.0, exponent - exponent / 2)) {}
  double times(double x) const { return x * half_ * other_half_; }

 private:
  double half_, other_half_;
};

/// The largest |H_ij|; Inf if H has an entry that is NaN or Inf.
double largest_entry(int n, const double *H) {
  double largest = 0;
  for (int i = 0; i < n * n; ++i) {
    if (!std::isfinite(H[i])) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, std::abs(H[i]));
  }
  return largest;
}

/// A = (H + H')/2 / 2^exponent, where 2^exponent is just above the largest entry of H.
/// Squares and products of entries of A can then neither overflow nor matter if they underflow.
void scaled_symmetric_part(int n, const double *H, int exponent, double *A) {
  const PowerOfTwo shrink(-exponent);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      A[i * n + j] = A[j * n + i] = 0.5 * (shrink.times(H[i * n + j]) + shrink.times(H[j * n + i]));
    }
  }
}

/// Whether A + shift I = L D L' with D > 0; reads and overwrites the lower triangle of A (by rows).
/// Stops at the first pivot that is not positive, which for an indefinite element comes early.
bool has_positive_pivots(int n, double shift, double *A) {
  double column[largest_element_matrix];
  for (int k = 0; k < n; ++k) {
    const double pivot = A[k * n + k] + shift;
    if (!(pivot > 0)) return false;
    const double inverse = 1 / pivot;  // divisions are what would take the time
    for (int i = k + 1; i < n; ++i) column[i] = A[i * n + k];
    for (int i = k + 1; i < n; ++i) {
      const double multiplier = column[i] * inverse;
      for (int j = k + 1; j <= i; ++j) A[i * n + j] -= multiplier * column[j];
    }
  }
  return true;
}

/// is_positive_semidefinite() of a scaled symmetric matrix A.
///
/// If the computed factorisation of A + shift I ends with positive pivots, it is the exact one of a
/// matrix at most (n+1) u trace(A) away [Higham, Theorem 10.3], hence
///     lambda_min(A) > -shift - (n+1) u trace(A),  u = eps/2.
/// A shift of n eps ||A|| makes singular matrices pass; where the trace is so large that the bound
/// would exceed the contract, the shift is smaller, or negative.
bool is_proven_semidefinite(int n, const double *A, double *factor) {
  double trace = 0, squared_norm = 0;
  for (int i = 0; i < n; ++i) {
    double squared_row = 0;
    for (int j = 0; j < n; ++j) squared_row += A[i * n + j] * A[i * n + j];
    squared_norm = std::max(squared_norm, squared_row);
    trace += A[i * n + i];
  }
  if (squared_norm == 0) return true;
  const double norm = std::sqrt(squared_norm);  // of the longest row: at most ||A||
  // n + 4: three operations more than in the theorem, to add the shift, to form the trace, and to
  // multiply by the inverse of a pivot.
  const double rounding = (n + 4) * (eps / 2) * trace;
  const double shift = std::min(n * eps * norm, split_accuracy(n) * norm - rounding);
  std::copy(A, A + n * n, factor);
  return has_positive_pivots(n, shift, factor);
}

/// Eigenpairs of A, ascending; eigenvector k overwrites A[k*n .. k*n + n-1].
bool eigenpairs(int n, double *A, double *eigenvalues, std::vector<double> &lapack) {
  const int work_size = Workspace::lapack_size(n);
  int info = 0;
  dsyev_("V", "L", &n, A, &n, eigenvalues, lapack.data(), &work_size, &info, 1, 1);
  return info == 0;
}

/// How many of n ascending eigenvalues are negative beyond rounding noise.
int count_negative(int n, const double *eigenvalues) {
  const double largest = std::max(std::abs(eigenvalues[0]), std::abs(eigenvalues[n - 1]));
  const double *end = std::lower_bound(eigenvalues, eigenvalues + n, -n * eps * largest);
  return static_cast<int>(end - eigenvalues);
}

/// N = 2^exponent * sum over the first `count` eigenpairs of |lambda| v v'.
void sum_of_negative_eigenpairs(int n, int count, const double *eigenvalues,
                                const double *eigenvectors, int exponent, double *N) {
  std::fill(N, N + n * n, 0.0);
  for (int k = 0; k < count; ++k) {
    const double *v = eigenvectors + k * n;
    for (int i = 0; i < n; ++i) {
      const double lambda_v = -eigenvalues[k] * v[i];
      for (int j = 0; j <= i; ++j) N[i * n + j] += lambda_v * v[j];
    }
  }
  const PowerOfTwo grow(exponent);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) N[i * n + j] = N[j * n + i] = grow.times(N[i * n + j]);
  }
}

/// Replaces eigenvalues by minus what N has to add of them under a floor, 0 where nothing.
/// @return how many change; *end the number of the last of them, plus one
int lift(int n, const EigenvalueFloor &floor, double *eigenvalues, int *end) {
  const double largest = std::max(std::abs(eigenvalues[0]), std::abs(eigenvalues[n - 1]));
  const double least = floor.share * largest, noise = n * eps * largest;
  int changed = *end = 0;
  for (int k = 0; k < n; ++k) {
    double &lambda = eigenvalues[k];
    const double filtered = lambda < 0 ? -(2 * floor.weight - 1) * lambda : lambda;
    const bool zero = std::abs(lambda) <= noise;
    const double added = zero ? 0 : std::max(filtered, least) - lambda;
    lambda = -added / (2 * floor.weight);
    if (!(added > 0)) continue;
    ++changed;
    *end = k + 1;
  }
  return changed;
}

/// split() of one matrix; N is left alone unless the status is ok.
SplitStatus split_one(int n, const double *H, double *N, int &negative,
                      const EigenvalueFloor &floor, Workspace &workspace) {
  negative = 0;
  const double largest = largest_entry(n, H);
  if (std::isinf(largest)) return SplitStatus::not_finite;
  int exponent = 0;
  std::frexp(largest, &exponent);
  double *A = workspace.matrix.data();
  double *eigenvalues = workspace.eigenvalues.data();
  scaled_symmetric_part(n, H, exponent, A);

  int end = 0;
  if (floor.share > 0 || !is_proven_semidefinite(n, A, workspace.factor.data())) {
    if (!eigenpairs(n, A, eigenvalues, workspace.lapack)) return SplitStatus::no_convergence;
    if (floor.share > 0) {
      negative = lift(n, floor, eigenvalues, &end);
    } else {
      negative = end = count_negative(n, eigenvalues);
    }
  }
  sum_of_negative_eigenpairs(n, end, eigenvalues, A, exponent, N);
  return SplitStatus::ok;
}

bool is_size(int n) {
  return 1 <= n && n <= largest_element_matrix;
}

}  // namespace

SplitResult split(int n, int batch, const double *H, double *N, int *negative) noexcept {
  return split_with_floor(n, batch, H, N, negative, {});
}

SplitResult split_with_floor(int n, int batch, const double *H, double *N, int *negative,
                             const EigenvalueFloor &floor) noexcept {
  SplitResult result;
  if (!is_size(n) || batch < 0) {
    result.status = SplitStatus::bad_size;
    return result;
  }
  Workspace &workspace = workspace_of_thread();
  if (!workspace.reserve(n)) {
    result.status = SplitStatus::out_of_memory;
    return result;
  }
  const std::ptrdiff_t entries = std::ptrdiff_t{n} * n;
  for (int b = 0; b < batch; ++b) {
    double *N_b = N + b * entries;
    int negative_b = 0;
    const SplitStatus status = split_one(n, H + b * entries, N_b, negative_b, floor, workspace);
    if (status != SplitStatus::ok) {
      std::fill(N_b, N_b + entries, std::numeric_limits<double>::quiet_NaN());
      negative_b = -1;
      if (result.first_bad < 0) {
        result.first_bad = b;
        result.status = status;
      }
    }
    if (negative_b > 0) ++result.indefinite;
    if (negative) negative[b] = negative_b;
  }
  return result;
}

bool is_positive_semidefinite(int n, const double *H) noexcept {
  if (!is_size(n)) return false;
  Workspace &workspace = workspace_of_thread();
  if (!workspace.reserve(n)) return false;
  const double largest = largest_entry(n, H);
  if (std::isinf(largest)) return false;
  int exponent = 0;
  std::frexp(largest, &exponent);
  scaled_symmetric_part(n, H, exponent, workspace.matrix.data());
  return is_proven_semidefinite(n, workspace.matrix.data(), workspace.factor.data());
}

}  // namespace trefoil
