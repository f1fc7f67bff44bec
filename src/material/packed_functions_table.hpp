#pragma once

// Included only by the files that are compiled for one instruction set each.

#include "material/library_material.hpp"
#include "material/material_list.hpp"

namespace trefoil {
namespace {

template <InstructionSet isa, class... M>
const PackedFunctions *table_of(std::tuple<M...> *) {
  static const PackedFunctions table[] = {make_packed_functions<M, isa>()...};
  return table;
}

}  // namespace

template <InstructionSet isa>
const PackedFunctions *packed_functions_table() {
  return table_of<isa>(static_cast<MaterialList *>(nullptr));
}

}  // namespace trefoil
