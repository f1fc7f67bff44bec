#pragma once

#include <span>

#include "trefoil/material.hpp"
#include "trefoil/plane_invariants.hpp"
#include "trefoil/split_material.hpp"

namespace trefoil {

/// A material's functions for the eight deformations of a pack, for the kernels. Arrays hold entry
/// k of lane e at k * lanes + e: the displacement gradient H and P 9 entries, A = dP/dF 81, psi
/// and J - 1 one, a VolumetricLaw three.
struct PackedFunctions {
  void (*energy_density)(const void *material, const double *H, double *psi);
  /// Adds weight (psi(H + a D + b S) - psi(H)) to sums at each of the points: `weight` one entry,
  /// `sums` one a point.
  void (*energy_changes)(const void *material, const double *H, const double *D, const double *S,
                         std::span<const PlanePoint> points, const double *weight, double *sums);
  void (*stress)(const void *material, const double *H, double *P);
  void (*tangent)(const void *material, const double *H, double *A);

  /// Where the material splits its volume off, see SplitMaterial; else null. The law of the
  /// element's mean of J, and the functions of what stays at the points.
  void (*mean_law)(const void *material, const double *J_minus_1, double *law) = nullptr;
  const PackedFunctions *pointwise = nullptr;
};

namespace packed {

/// The material that functions get, or its part M.
template <class M>
decltype(auto) material_at(const void *material) {
  if constexpr (requires { typename M::Whole; }) {
    return M(*static_cast<const typename M::Whole *>(material));
  } else {
    return *static_cast<const M *>(material);
  }
}

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
[[gnu::flatten, gnu::noinline]] void energy_density(const void *material, const double *H,
                                                    double *psi) {
  material_at<M>(material).energy_density(load_deformation<isa>(H)).store(psi);
}

/// One energy after the other, by calls: inlined into the loop, decompositions of F are slower.
template <InstructionSet isa, class M>
void sampled_energy_changes(const void *material, const double *H, const double *D, const double *S,
                            std::span<const PlanePoint> points, const double *weight,
                            double *sums) {
  using Real = Pack<isa>;
  const auto start = load<isa, 9>(H), first = load<isa, 9>(D), second = load<isa, 9>(S);
  alignas(64) double moved[9 * lanes], psi[lanes];
  energy_density<isa, M>(material, H, psi);
  const Real before = Real::load(psi), w = Real::load(weight);
  for (const PlanePoint &point : points) {
    for (std::size_t k = 0; k < 9; ++k) {
      (start[k] + point.a() * first[k] + point.b() * second[k]).store(moved + lanes * k);
    }
    energy_density<isa, M>(material, moved, psi);
    (Real::load(sums) + w * (Real::load(psi) - before)).store(sums);
    sums += lanes;
  }
}

/// The same, where the energy is one of invariants: those are known in all of the plane at once.
template <InstructionSet isa, class M>
[[gnu::flatten]] void invariant_energy_changes(const void *material, const double *H,
                                               const double *D, const double *S,
                                               std::span<const PlanePoint> points,
                                               const double *weight, double *sums) {
  using Real = Pack<isa>;
  const M &model = material_at<M>(material);
  const PlaneInvariants<Real> plane(load_deformation<isa>(H), {load<isa, 9>(D)}, {load<isa, 9>(S)});
  const Real before = model.energy_of_invariants(plane.start()), w = Real::load(weight);
  for (const PlanePoint &point : points) {
    const Real change = model.energy_of_invariants(plane.at(point)) - before;
    (Real::load(sums) + w * change).store(sums);
    sums += lanes;
  }
}

template <InstructionSet isa, class M>
[[gnu::flatten]] void stress(const void *material, const double *H, double *P) {
  store<isa>(material_at<M>(material).stress(load_deformation<isa>(H)).entries, P);
}

template <InstructionSet isa, class M>
[[gnu::flatten]] void tangent(const void *material, const double *H, double *A) {
  Tangent<Pack<isa>> entries;
  material_at<M>(material).tangent(load_deformation<isa>(H), entries);
  store<isa>(entries, A);
}

template <InstructionSet isa, class M>
[[gnu::flatten]] void mean_law(const void *material, const double *J_minus_1, double *law) {
  const auto [energy, slope, curvature] =
      material_at<M>(material).mean_law(Pack<isa>::load(J_minus_1));
  store<isa, 3>({energy, slope, curvature}, law);
}

}  // namespace packed

/// The functions of a material for an instruction set, compiled where this is instantiated.
template <class M, InstructionSet isa>
PackedFunctions make_packed_functions() {
  auto *energy_changes = packed::sampled_energy_changes<isa, M>;
  if constexpr (HasEnergyOfInvariants<M>) energy_changes = packed::invariant_energy_changes<isa, M>;
  PackedFunctions functions{packed::energy_density<isa, M>, energy_changes, packed::stress<isa, M>,
                            packed::tangent<isa, M>};
  if constexpr (VolumeSplittingMaterial<M>) {
    static const PackedFunctions pointwise =
        make_packed_functions<typename M::PointwisePart, isa>();
    functions.mean_law = packed::mean_law<isa, M>;
    functions.pointwise = &pointwise;
  }
  return functions;
}

}  // namespace trefoil
