#pragma once

#include "trefoil/material.hpp"

namespace trefoil {

/// A material's functions for the eight deformations of a pack, for the kernels. Arrays hold entry
/// k of lane e at k * lanes + e: the displacement gradient H and P 9 entries, A = dP/dF 81, psi
/// one.
struct PackedFunctions {
  void (*energy_density)(const void *material, const double *H, double *psi);
  void (*stress)(const void *material, const double *H, double *P);
  void (*tangent)(const void *material, const double *H, double *A);
};

namespace packed {

template <InstructionSet isa, std::size_t size>
std::array<Pack<isa>, size> load(const double *from) {
  std::array<Pack<isa>, size> entries;
  for (std::size_t k = 0; k < size; ++k) entries[k] = Pack<isa>::load(from + lanes * k);
  return entries;
}

template <InstructionSet isa, std::size_t size>
void store(const std::array<Pack<isa>, size> &entries, double *to) {
  for (std::size_t k = 0; k < size; ++k) entries[k].store(to + lanes * k);
}

template <InstructionSet isa>
Deformation<Pack<isa>> load_deformation(const double *H) {
  return Deformation<Pack<isa>>({load<isa, 9>(H)});
}

template <InstructionSet isa, class M>
[[gnu::flatten]] void energy_density(const void *material, const double *H, double *psi) {
  static_cast<const M *>(material)->energy_density(load_deformation<isa>(H)).store(psi);
}

template <InstructionSet isa, class M>
[[gnu::flatten]] void stress(const void *material, const double *H, double *P) {
  store<isa>(static_cast<const M *>(material)->stress(load_deformation<isa>(H)).entries, P);
}

template <InstructionSet isa, class M>
[[gnu::flatten]] void tangent(const void *material, const double *H, double *A) {
  Tangent<Pack<isa>> entries;
  static_cast<const M *>(material)->tangent(load_deformation<isa>(H), entries);
  store<isa>(entries, A);
}

}  // namespace packed

/// The functions of a material for an instruction set, compiled where this is instantiated.
template <class M, InstructionSet isa>
PackedFunctions make_packed_functions() {
  return {packed::energy_density<isa, M>, packed::stress<isa, M>, packed::tangent<isa, M>};
}

}  // namespace trefoil
