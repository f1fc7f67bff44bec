#pragma once

#include "trefoil/material.hpp"
#include "trefoil/split_material.hpp"

namespace trefoil {

/// A material's functions for the eight deformations of a pack, for the kernels. Arrays hold entry
/// k of lane e at k * lanes + e: the displacement gradient H and P 9 entries, A = dP/dF 81, psi, W,
/// p and J - 1 one, a volumetric law three (U, U', U'').
struct PackedFunctions {
  void (*energy_density)(const void *material, const double *H, double *psi);
  void (*stress)(const void *material, const double *H, double *P);
  void (*tangent)(const void *material, const double *H, double *A);

  /// The parts of a sum W(F) + U(J), see SplitMaterial; null where the material is none.
  void (*distortional_energy)(const void *material, const double *H, double *W) = nullptr;
  void (*stress_at_pressure)(const void *material, const double *H, const double *p,
                             double *P) = nullptr;
  void (*tangent_at_pressure)(const void *material, const double *H, const double *p,
                              double *A) = nullptr;
  void (*volumetric_law)(const void *material, const double *J_minus_1, double *law) = nullptr;
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

template <InstructionSet isa, class M>
[[gnu::flatten]] void distortional_energy(const void *material, const double *H, double *W) {
  static_cast<const M *>(material)->distortional_energy(load_deformation<isa>(H)).store(W);
}

template <InstructionSet isa, class M>
[[gnu::flatten]] void stress_at_pressure(const void *material, const double *H, const double *p,
                                         double *P) {
  store<isa>(static_cast<const M *>(material)
                 ->stress_at_pressure(load_deformation<isa>(H), Pack<isa>::load(p))
                 .entries,
             P);
}

template <InstructionSet isa, class M>
[[gnu::flatten]] void tangent_at_pressure(const void *material, const double *H, const double *p,
                                          double *A) {
  Tangent<Pack<isa>> entries;
  entries.fill(Pack<isa>(0.0));
  static_cast<const M *>(material)->add_tangent_at_pressure(load_deformation<isa>(H),
                                                            Pack<isa>::load(p), entries);
  store<isa>(entries, A);
}

template <InstructionSet isa, class M>
[[gnu::flatten]] void volumetric_law(const void *material, const double *J_minus_1, double *law) {
  const VolumetricLaw<Pack<isa>> parts =
      static_cast<const M *>(material)->volumetric_law(Pack<isa>::load(J_minus_1));
  parts.energy.store(law);
  parts.slope.store(law + lanes);
  parts.curvature.store(law + 2 * lanes);
}

}  // namespace packed

/// The functions of a material for an instruction set, compiled where this is instantiated.
template <class M, InstructionSet isa>
PackedFunctions make_packed_functions() {
  PackedFunctions functions{packed::energy_density<isa, M>, packed::stress<isa, M>,
                            packed::tangent<isa, M>};
  if constexpr (VolumeSplittingMaterial<M>) {
    functions.distortional_energy = packed::distortional_energy<isa, M>;
    functions.stress_at_pressure = packed::stress_at_pressure<isa, M>;
    functions.tangent_at_pressure = packed::tangent_at_pressure<isa, M>;
    functions.volumetric_law = packed::volumetric_law<isa, M>;
  }
  return functions;
}

}  // namespace trefoil
