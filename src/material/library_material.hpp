#pragma once

#include "trefoil/packed_functions.hpp"

namespace trefoil {

/// The base of the library's own materials: their packed functions are compiled once, for every
/// instruction set, see packed_functions_of(). Each is in MaterialList.
template <class M>
struct LibraryMaterial {
  static PackedFunctions packed_functions(InstructionSet instructions);
};

/// The functions of all materials of MaterialList, in its order; defined in the file that is
/// compiled for the instruction set.
template <InstructionSet isa>
const PackedFunctions *packed_functions_table();

}  // namespace trefoil
