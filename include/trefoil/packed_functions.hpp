#pragma once

#include "trefoil/material.hpp"
#include "trefoil/pack.hpp"

namespace trefoil {

/// A material's three functions for the eight deformation gradients of a pack, for the kernels.
/// Arrays hold entry k of lane e at k * lanes + e: F and P 9 entries, the tangent 81, psi one.
struct PackedFunctions {
  void (*energy_density)(const void *material, const double *F, double *psi);
  void (*stress)(const void *material, const double *F, double *P);
  void (*tangent)(const void *material, const double *F, double *A);
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

template <InstructionSet isa, class M>
void energy_density(const void *material, const double *F, double *psi) {
  const Matrix3<Pack<isa>> gradient{load<isa, 9>(F)};
  static_cast<const M *>(material)->energy_density(gradient).store(psi);
}

template <InstructionSet isa, class M>
void stress(const void *material, const double *F, double *P) {
  const Matrix3<Pack<isa>> gradient{load<isa, 9>(F)};
  store<isa, 9>(static_cast<const M *>(material)->stress(gradient).entries, P);
}

template <InstructionSet isa, class M>
void tangent(const void *material, const double *F, double *A) {
  const Matrix3<Pack<isa>> gradient{load<isa, 9>(F)};
  Tangent<Pack<isa>> entries;
  static_cast<const M *>(material)->tangent(gradient, entries);
  store<isa, 81>(entries, A);
}

}  // namespace packed

/// The functions of a material for an instruction set, compiled where this is instantiated.
template <class M, InstructionSet isa>
PackedFunctions make_packed_functions() {
  return {packed::energy_density<isa, M>, packed::stress<isa, M>, packed::tangent<isa, M>};
}

}  // namespace trefoil
