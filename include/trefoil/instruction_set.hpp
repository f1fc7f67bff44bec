#pragma once

namespace trefoil {

/// Elements, and matrices, that the batched kernels treat at once.
inline constexpr int lanes = 8;

/// What kernels are compiled for.
enum class InstructionSet { baseline, avx2, avx512 };

/// The one that all kernels of this process use: the best that the processor has, or, for tests,
/// the one that the environment variable TREFOIL_SIMD names (baseline, avx2 or avx512). Read once.
[[nodiscard]] InstructionSet chosen_instruction_set() noexcept;

}  // namespace trefoil
