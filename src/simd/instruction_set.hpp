#pragma once

#include <string>

#include "trefoil/instruction_set.hpp"

namespace trefoil {

/// Whether this processor has it.
[[nodiscard]] bool processor_has(InstructionSet instructions) noexcept;

/// What is wrong with the environment variable TREFOIL_SIMD, in one sentence; empty if nothing.
/// chosen_instruction_set() then is as if it were not set: whoever starts up asks here first.
[[nodiscard]] std::string instruction_set_error();

/// make.operator()<isa>() for an instruction set that is known at run time only.
template <class Make>
auto for_instruction_set(InstructionSet instructions, const Make &make) {
#if defined(__x86_64__)
  if (instructions == InstructionSet::avx512) {
    return make.template operator()<InstructionSet::avx512>();
  }
  if (instructions == InstructionSet::avx2) return make.template operator()<InstructionSet::avx2>();
#endif
  return make.template operator()<InstructionSet::baseline>();
}

}  // namespace trefoil
