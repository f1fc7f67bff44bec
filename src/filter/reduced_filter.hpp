#pragma once

#include "filter/filter.hpp"
#include "simd/instruction_set.hpp"

namespace trefoil {

/// split() for many 9x9 matrices at once, in SIMD lanes.
///
/// A linear tetrahedron's 12x12 Hessian knows no translations: with the three non-constant Hadamard
/// vectors over two (times I3) as an orthonormal basis it is exactly a 9x9 matrix K, and its
/// negative part is that of K.
inline constexpr int reduced_rows = 9;
inline constexpr int reduced_entries = 45;  ///< lower triangle: (0,0), (1,0), (1,1), (2,0), ...

/// Negative parts N of packs of eight symmetric 9x9 matrices K.
///
/// The contract of split() with n = 9: error below split_accuracy(9) ||K||, rounding noise is no
/// negative eigenvalue, 2^k K gives 2^k N exactly. The threshold is -9 eps ||K|| with ||K|| known
/// to a factor sqrt(3) only. The result for a matrix does not depend on the matrices around it, to
/// the last bit; it does depend, in rounding, on the instruction set of the machine.
///
/// N is exactly 0 where `negative` is 0, and NaN where it is -1. Thread-safe; no allocation except
/// the workspace of split(), once a thread, when a matrix needs it.
///
/// @param packs     >= 0, number of packs
/// @param K         entry e of matrix 8 p + l at K[(45 p + e) * 8 + l]
/// @param N         like K; written; may not overlap K
/// @param negative  8 packs: number of negative eigenvalues; -1: the matrix is not finite
[[nodiscard]] SplitResult split_reduced(int packs, const double *K, double *N,
                                        int *negative) noexcept;

/// For tests and benchmarks: split_reduced() by one instruction set, which the processor must have.
struct ReducedSplitExperiment {
  InstructionSet instructions = InstructionSet::baseline;
  bool distrust = false;  ///< send every indefinite matrix to split()
  long fallbacks = 0;     ///< written: how many matrices were sent to split()
};
[[nodiscard]] SplitResult split_reduced(int packs, const double *K, double *N, int *negative,
                                        ReducedSplitExperiment &experiment) noexcept;

}  // namespace trefoil
