#include "simd/instruction_set.hpp"

#include <cstdlib>

namespace trefoil {
namespace {

struct Named {
  InstructionSet instructions;
  const char *name;
};
constexpr Named best_first[] = {{InstructionSet::avx512, "avx512"},
                                {InstructionSet::avx2, "avx2"},
                                {InstructionSet::baseline, "baseline"}};

/// What TREFOIL_SIMD says; empty where it is not set.
std::string wish() {
  const char *variable = std::getenv("TREFOIL_SIMD");
  return variable ? variable : "";
}

/// The one of that name, or the best where it is empty; null where this processor has none such.
const Named *find(const std::string &name) {
  for (const Named &each : best_first) {
    if ((name.empty() || name == each.name) && processor_has(each.instructions)) return &each;
  }
  return nullptr;
}

}  // namespace

bool processor_has(InstructionSet instructions) noexcept {
#if defined(__x86_64__)
  if (instructions == InstructionSet::avx512) {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("fma");
  }
  if (instructions == InstructionSet::avx2) {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  }
#endif
  return instructions == InstructionSet::baseline;
}

InstructionSet chosen_instruction_set() noexcept {
  static const Named *const chosen = [] {
    const Named *named = find(wish());
    return named ? named : find("");
  }();
  return chosen->instructions;
}

std::string instruction_set_error() {
  if (find(wish())) return "";
  std::string list;
  for (const Named &each : best_first) {
    if (processor_has(each.instructions))
      list += (list.empty() ? "" : ", ") + std::string(each.name);
  }
  return "the environment variable TREFOIL_SIMD is '" + wish() +
         "', which is no instruction set of this processor; it may be " + list +
         ", or not be set at all";
}

}  // namespace trefoil
