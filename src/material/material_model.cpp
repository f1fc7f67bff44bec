#include "material/material_model.hpp"

#include <cstdlib>
#include <cstring>
#include <utility>

namespace trefoil {

MaterialModel::~MaterialModel() = default;

InstructionSet chosen_instruction_set() {
  static const InstructionSet chosen = [] {
    const char *wish = std::getenv("TREFOIL_SIMD");
    for (const auto &[set, name] :
         {std::pair{InstructionSet::avx512, "avx512"}, std::pair{InstructionSet::avx2, "avx2"}}) {
      if (processor_has(set) && (!wish || std::strcmp(wish, name) == 0)) return set;
    }
    return InstructionSet::baseline;
  }();
  return chosen;
}

const PackedFunctions *find_packed_functions_table(InstructionSet instructions) {
  return for_instruction_set(instructions,
                             []<InstructionSet isa>() { return packed_functions_table<isa>(); });
}

}  // namespace trefoil
