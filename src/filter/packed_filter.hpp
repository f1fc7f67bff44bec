#pragma once

#include "filter/reduced_filter.hpp"

namespace trefoil {

/// split_reduced() for the sizes that other elements have after their translations are taken out:
/// 4 (linear triangle), 9 (linear tetrahedron), 10 (quadratic triangle), 27 (quadratic
/// tetrahedron). The same contract, with n and n (n + 1) / 2 entries of the lower triangle in place
/// of 9 and 45. Other sizes are SplitStatus::bad_size.
[[nodiscard]] SplitResult split_packed(int n, int packs, const double *K, double *N,
                                       int *negative) noexcept;

/// For tests and benchmarks, see split_reduced().
[[nodiscard]] SplitResult split_packed(int n, int packs, const double *K, double *N, int *negative,
                                       ReducedSplitExperiment &experiment) noexcept;

/// One size, in a file of its own.
template <int n>
SplitResult split_packs_of(int packs, const double *K, double *N, int *negative,
                           ReducedSplitExperiment &experiment) noexcept;

}  // namespace trefoil
