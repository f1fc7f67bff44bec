#pragma once

// Included only by the files that are compiled for one instruction set each.

#include <vector>

#include "element/element_kernels.hpp"
#include "trefoil/tangent_terms.hpp"

namespace trefoil {
namespace {

/// The kernels of an element with a constant pressure of its own, ElementPressure::constant: an
/// element's energy is
///   sum_q w_q psi_q + V U(theta),   V = sum_q w_q,   theta = sum_q w_q J_q / V,
/// with what of psi stays at the points and the law U of the mean, see SplitMaterial. It is mean
/// dilatation [Nagtegaal, Parks, Rice 1974; Simo, Taylor, Pister 1985] of a part of U.
template <int nodes, int points, int dim, InstructionSet isa>
struct MeanVolumeKernels {
  using Real = Pack<isa>;
  using Plain = Kernels<nodes, points, dim, isa>;
  using Elements = typename Plain::Elements;
  static constexpr int modes = Plain::modes, rows = Plain::rows, entries = Plain::entries;

  /// Elements at displacements u, with the mean of their volumes and its law there.
  struct State {
    const Elements elements;
    typename Elements::Gradients G[points];
    Real weight[points];
    alignas(64) double H[points][9 * lanes];
    Real volume, over_volume;  ///< V and 1 / V; both 0 in lanes that fill the last pack
    Real theta_minus_1;
    Real energy, slope, curvature;  ///< U, U' and U'' at theta

    State(const MaterialModel &material, const ElementPacks &packed, PetscInt pack, const double *u)
        : elements(packed, pack) {
      typename Elements::Displacements U;
      elements.displacements(u, U);
      Real sum;
      for (int q = 0; q < points; ++q) {
        elements.gradients(q, G[q]);
        weight[q] = elements.weight(q);
        Elements::displacement_gradient(U, G[q], H[q]);
        volume += weight[q];
        sum += weight[q] * deformation(q).J_minus_1();
      }
      const auto is_element = volume > Real(0.0);
      over_volume = select(is_element, 1.0 / select(is_element, volume, Real(1.0)), Real(0.0));
      theta_minus_1 = sum * over_volume;
      const VolumetricLaw<Real> law = law_at(material, theta_minus_1);
      energy = law.energy, slope = law.slope, curvature = law.curvature;
    }

    [[nodiscard]] Deformation<Real> deformation(int q) const {
      return packed::load_deformation<isa>(H[q]);
    }
  };

  static VolumetricLaw<Real> law_at(const MaterialModel &material, const Real &theta_minus_1) {
    alignas(64) double change[lanes], law[3 * lanes];
    theta_minus_1.store(change);
    material.mean_laws(change, law);
    return {Real::load(law), Real::load(law + lanes), Real::load(law + 2 * lanes)};
  }

  static void energy(const MaterialModel &material, const ElementPacks &packed, PetscInt first,
                     PetscInt count, const double *u, double *sums) {
    Plain::energy(material.pointwise(), packed, first, count, u, sums);
    Real energy, size;
    for (PetscInt pack = first; pack < first + count; ++pack) {
      const State state(material, packed, pack, u);
      energy += state.volume * state.energy;
      size += state.volume * abs(state.energy);
    }
    sums[0] += energy.sum();
    sums[1] += size.sum();
  }

  /// theta is a polynomial in the plane, as J is at each point.
  static void energy_changes(const MaterialModel &material, const ElementPacks &packed,
                             PetscInt first, PetscInt count, const double *u, int directions,
                             const double *const *d, std::span<const PlanePoint> plane,
                             double *sums) {
    Plain::energy_changes(material.pointwise(), packed, first, count, u, directions, d, plane,
                          sums);
    typename Elements::Displacements D[2];
    alignas(64) double steps[2][9 * lanes] = {};
    for (PetscInt pack = first; pack < first + count; ++pack) {
      const State state(material, packed, pack, u);
      std::array<Real, 9> theta;
      for (int k = 0; k < directions; ++k) state.elements.displacements(d[k], D[k]);
      for (int q = 0; q < points; ++q) {
        for (int k = 0; k < directions; ++k) {
          Elements::displacement_gradient(D[k], state.G[q], steps[k]);
        }
        const std::array<Real, 9> J =
            determinant_in_plane(state.deformation(q), {packed::load<isa, 9>(steps[0])},
                                 {packed::load<isa, 9>(steps[1])});
        for (std::size_t k = 0; k < 9; ++k) {
          theta[k] += state.weight[q] * state.over_volume * J[k];
        }
      }
      double *sum = sums;
      for (const PlanePoint &point : plane) {
        Real theta_minus_1 = state.theta_minus_1;
        for (std::size_t k = 0; k < 9; ++k) theta_minus_1 += point.products()[k] * theta[k];
        const Real change = law_at(material, theta_minus_1).energy - state.energy;
        (Real::load(sum) + state.volume * change).store(sum);
        sum += lanes;
      }
    }
  }

  /// w_q (P_q + U'(theta) cof F_q).
  static void forces(const MaterialModel &material, const ElementPacks &packed, PetscInt first,
                     PetscInt count, const double *u, double *forces) {
    alignas(64) double P[9 * lanes];
    for (PetscInt pack = first; pack < first + count; ++pack) {
      const State state(material, packed, pack, u);
      Real reduced[dim][modes];
      for (int q = 0; q < points; ++q) {
        material.pointwise().stresses(state.H[q], P);
        const Matrix3<Real> C = state.deformation(q).cofactor();
        for (std::size_t k = 0; k < 9; ++k) {
          (Real::load(P + lanes * k) + state.slope * C.entries[k]).store(P + lanes * k);
        }
        Elements::add_stress(state.weight[q], P, state.G[q], reduced);
      }
      state.elements.add_forces(reduced, forces);
    }
  }

  static void hessians(const MaterialModel &material, const ElementPacks &packed, PetscInt first,
                       PetscInt count, const double *u, double *K) {
    hessians_at_pressures(material, packed, first, count, u, nullptr, K);
  }

  /// sum_q w_q B'(dP_q/dF + p d(cof F)/dF)B + V U''(theta) g g',   g = d(theta)/du.
  /// @param pressures p; null: U'(theta)
  static void hessians_at_pressures(const MaterialModel &material, const ElementPacks &packed,
                                    PetscInt first, PetscInt count, const double *u,
                                    const double *pressures, double *K) {
    alignas(64) double full[81 * lanes], A[points * Plain::tangent_entries * lanes];
    for (PetscInt pack = first; pack < first + count; ++pack) {
      const State state(material, packed, pack, u);
      const Real pressure =
          pressures ? Real::load(pressures + lanes * (pack - first)) : state.slope;
      Real g[rows];
      for (int q = 0; q < points; ++q) {
        const Deformation<Real> deformation = state.deformation(q);
        material.pointwise().tangents(state.H[q], full);
        Tangent<Real> tangent = packed::load<isa, 81>(full);
        add_cofactor_derivative(pressure, deformation.F(), tangent);
        packed::store<isa>(tangent, full);
        Plain::store_triangle(full, A + q * Plain::tangent_entries * lanes);
        const Matrix3<Real> C = deformation.cofactor();
        const Real share = state.weight[q] * state.over_volume;
        for (int r = 0; r < rows; ++r) {
          for (int j = 0; j < dim; ++j) g[r] += share * C(r % dim, j) * state.G[q][r / dim][j];
        }
      }
      Plain::contract(packed, pack, 1, A, K);
      const Real stiffness = state.volume * state.curvature;
      for (int r = 0; r < rows; ++r) {
        const Real scaled = stiffness * g[r];
        for (int s = 0; s <= r; ++s, K += lanes) (Real::load(K) + scaled * g[s]).store(K);
      }
    }
  }

  /// U'(theta) + U''(theta) g'd.
  static void pressures(const MaterialModel &material, const ElementPacks &packed, PetscInt first,
                        PetscInt count, const double *u, const double *d, double *pressures) {
    typename Elements::Displacements D;
    alignas(64) double step[9 * lanes];
    for (PetscInt pack = first; pack < first + count; ++pack, pressures += lanes) {
      const State state(material, packed, pack, u);
      Real change;
      state.elements.displacements(d, D);
      for (int q = 0; q < points; ++q) {
        Elements::displacement_gradient(D, state.G[q], step);
        const Matrix3<Real> C = state.deformation(q).cofactor();
        const Real share = state.weight[q] * state.over_volume;
        for (std::size_t k = 0; k < 9; ++k) {
          change += share * C.entries[k] * Real::load(step + lanes * k);
        }
      }
      (state.slope + state.curvature * change).store(pressures);
    }
  }

  static ElementKernels all() {
    ElementKernels kernels = Plain::all();
    kernels.energy = energy;
    kernels.energy_changes = energy_changes;
    kernels.forces = forces;
    kernels.hessians = hessians;
    kernels.pressures = pressures;
    kernels.hessians_at_pressures = hessians_at_pressures;
    return kernels;
  }
};

/// Those of a quadratic element for each way to take the volume.
template <int nodes, int points, int dim, InstructionSet isa>
ElementKernels quadratic_kernels(ElementPressure pressure) {
  return pressure == ElementPressure::constant ? MeanVolumeKernels<nodes, points, dim, isa>::all()
                                               : Kernels<nodes, points, dim, isa>::all();
}

}  // namespace

template <InstructionSet isa>
ElementKernels make_element_kernels(int dimension, int nodes, ElementPressure pressure) {
  if (dimension == 2) {
    return nodes == 3 ? Kernels<3, 1, 2, isa>::all() : quadratic_kernels<6, 3, 2, isa>(pressure);
  }
  return nodes == 4 ? Kernels<4, 1, 3, isa>::all() : quadratic_kernels<10, 4, 3, isa>(pressure);
}

}  // namespace trefoil
