#include "material/library_material.hpp"

#include <type_traits>

#include "material/material_list.hpp"
#include "simd/instruction_set.hpp"

namespace trefoil {
namespace {

/// Position of a type in a tuple's list.
template <class M, class... Others>
constexpr std::size_t position_in(std::tuple<Others...> *) {
  std::size_t position = 0;
  static_cast<void>(((std::is_same_v<M, Others> ? false : (++position, true)) && ...));
  static_assert((std::is_same_v<M, Others> || ...), "the material is missing in the list");
  return position;
}

}  // namespace

template <class M>
PackedFunctions LibraryMaterial<M>::packed_functions(InstructionSet instructions) {
  return for_instruction_set(instructions, []<InstructionSet isa>() {
    return packed_functions_table<isa>()[position_in<M>(static_cast<MaterialList *>(nullptr))];
  });
}

template struct LibraryMaterial<Arap>;
template struct LibraryMaterial<Corotated>;
template struct LibraryMaterial<HarmonicSpreading>;
template struct LibraryMaterial<MooneyRivlin>;
template struct LibraryMaterial<NeoHookean>;
template struct LibraryMaterial<RigidSpreading>;
template struct LibraryMaterial<StableNeoHookean>;
template struct LibraryMaterial<StVenantKirchhoff>;
template struct LibraryMaterial<SymmetricDirichlet>;

}  // namespace trefoil
