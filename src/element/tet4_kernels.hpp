#pragma once

// The batched kernels themselves. Included only by the files that are compiled for one instruction
// set each (tet4_kernels_*.cpp); everything in here depends on the type Pack<isa>.

#include "element/tet4_packs.hpp"

namespace trefoil {
namespace {

/// 2 h_k[a], see Tet4Packs.
constexpr double hadamard[3][4] = {{1, 1, -1, -1}, {1, -1, 1, -1}, {1, -1, -1, 1}};

template <InstructionSet isa>
struct PackedTets {
  using Real = Pack<isa>;
  Real gradients[9];  ///< G_k[i] at 3 k + i
  Real volume;
  alignas(64) double F[9 * lanes];  ///< as PackedFunctions takes it

  /// F = I + sum_a u_a g_a' = I + sum_k U_k G_k',  U_k = sum_a h_k[a] u_a.
  PackedTets(const Tet4Packs &tets, PetscInt pack, const double *u) {
    const double *G = tets.gradients.data() + 9 * lanes * pack;
    const PetscInt *vertex = tets.vertices.data() + 4 * lanes * pack;
    for (int k = 0; k < 9; ++k) gradients[k] = Real::load(G + lanes * k);
    volume = Real::load(tets.volumes.data() + lanes * pack);
    for (int i = 0; i < 3; ++i) {
      Real corner[4];
      for (int a = 0; a < 4; ++a) {
        for (int lane = 0; lane < lanes; ++lane) {
          corner[a].v[lane] = u[3 * vertex[lanes * a + lane] + i];
        }
      }
      const Real left = 0.5 * (corner[0] + corner[1]), right = 0.5 * (corner[2] + corner[3]);
      const Real even = 0.5 * (corner[0] - corner[1]), odd = 0.5 * (corner[2] - corner[3]);
      const Real U[3] = {left - right, even + odd, even - odd};
      for (int j = 0; j < 3; ++j) {
        const Real strain = U[0] * gradients[j] + U[1] * gradients[3 + j] + U[2] * gradients[6 + j];
        (i == j ? strain + 1.0 : strain).store(F + lanes * (3 * i + j));
      }
    }
  }
};

template <InstructionSet isa>
void packed_energy(const MaterialModel &material, const Tet4Packs &tets, PetscInt first,
                   PetscInt count, const double *u, double rest_density, double *sums) {
  Pack<isa> energy, scale;
  for (PetscInt pack = first; pack < first + count; ++pack) {
    const PackedTets<isa> tet(tets, pack, u);
    alignas(64) double psi[lanes];
    material.energy_densities(tet.F, psi);
    const Pack<isa> density = Pack<isa>::load(psi);
    energy += density * tet.volume;
    scale += abs(density - rest_density) * tet.volume;
  }
  sums[0] += energy.sum();
  sums[1] += scale.sum();
}

/// Elements' grad u = sum_a u_a g_a' = sum_k U_k G_k', entry 3 i + j.
template <InstructionSet isa>
void displacement_gradient(const Tet4Packs &tets, PetscInt pack, const double *u,
                           Pack<isa> (&gradient)[9]) {
  const PackedTets<isa> tet(tets, pack, u);
  for (int k = 0; k < 9; ++k) {
    gradient[k] = Pack<isa>::load(tet.F + lanes * k);
    if (k % 4 == 0) gradient[k] = gradient[k] - Pack<isa>(1.0);
  }
}

template <InstructionSet isa>
void packed_energy_changes(const MaterialModel &material, const Tet4Packs &tets, PetscInt first,
                           PetscInt count, const double *u, int directions, const double *const *d,
                           int points, const double *coefficients, double *changes) {
  using Real = Pack<isa>;
  for (PetscInt pack = first; pack < first + count; ++pack) {
    const PackedTets<isa> tet(tets, pack, u);
    Real step[2][9];
    for (int k = 0; k < directions; ++k) displacement_gradient<isa>(tets, pack, d[k], step[k]);
    alignas(64) double psi[lanes], F[9 * lanes];
    material.energy_densities(tet.F, psi);
    const Real before = Real::load(psi);
    for (int point = 0; point < points; ++point) {
      const double *c = coefficients + directions * point;
      for (int entry = 0; entry < 9; ++entry) {
        Real sum = Real::load(tet.F + lanes * entry);
        for (int k = 0; k < directions; ++k) sum += c[k] * step[k][entry];
        sum.store(F + lanes * entry);
      }
      material.energy_densities(F, psi);
      changes[point] += ((Real::load(psi) - before) * tet.volume).sum();
    }
  }
}

template <InstructionSet isa>
void packed_forces(const MaterialModel &material, const Tet4Packs &tets, PetscInt first,
                   PetscInt count, const double *u, double *forces) {
  using Real = Pack<isa>;
  for (PetscInt pack = first; pack < first + count; ++pack) {
    const PackedTets<isa> tet(tets, pack, u);
    const PetscInt *vertex = tets.vertices.data() + 4 * lanes * pack;
    alignas(64) double stress[9 * lanes];
    material.stresses(tet.F, stress);
    const Matrix3<Real> P{packed::load<isa, 9>(stress)};
    for (int i = 0; i < 3; ++i) {
      Real reduced[3];  // V P G_k / 2
      for (int k = 0; k < 3; ++k) {
        reduced[k] = 0.5 * tet.volume *
                     (P(i, 0) * tet.gradients[3 * k] + P(i, 1) * tet.gradients[3 * k + 1] +
                      P(i, 2) * tet.gradients[3 * k + 2]);
      }
      for (int a = 0; a < 4; ++a) {
        const Real force =
            hadamard[0][a] * reduced[0] + hadamard[1][a] * reduced[1] + hadamard[2][a] * reduced[2];
        for (int lane = 0; lane < lanes; ++lane) {
          forces[3 * vertex[lanes * a + lane] + i] += force.v[lane];
        }
      }
    }
  }
}

/// K[(k,i),(l,m)] = V sum_jn G_k[j] (dP_ij/dF_mn) G_l[n], the lower triangle.
template <InstructionSet isa>
void packed_reduced_hessians(const MaterialModel &material, const Tet4Packs &tets, PetscInt first,
                             PetscInt count, const double *u, double *K) {
  using Real = Pack<isa>;
  for (PetscInt pack = first; pack < first + count; ++pack) {
    const PackedTets<isa> tet(tets, pack, u);
    alignas(64) double tangent[81 * lanes];  // dP_ij/dF_mn at (9 (3 i + j) + 3 m + n)
    material.tangents(tet.F, tangent);
    Real weighted[9];  // V G_k
    for (int r = 0; r < 9; ++r) weighted[r] = tet.volume * tet.gradients[r];
    double *entry = K + reduced_entries * lanes * (pack - first);
#pragma GCC unroll 3
    for (int k = 0; k < 3; ++k) {
#pragma GCC unroll 3
      for (int i = 0; i < 3; ++i) {
        Real row[9];  // V sum_j G_k[j] dP_ij/dF
#pragma GCC unroll 9
        for (int q = 0; q < 9; ++q) {
          const double *column = tangent + lanes * (27 * i + q);
          row[q] = weighted[3 * k] * Real::load(column) +
                   weighted[3 * k + 1] * Real::load(column + 9 * lanes) +
                   weighted[3 * k + 2] * Real::load(column + 18 * lanes);
        }
#pragma GCC unroll 9
        for (int column = 0; column <= 3 * k + i; ++column) {
          const int l = column / 3, m = column % 3;
          const Real value = row[3 * m] * tet.gradients[3 * l] +
                             row[3 * m + 1] * tet.gradients[3 * l + 1] +
                             row[3 * m + 2] * tet.gradients[3 * l + 2];
          value.store(entry);
          entry += lanes;
        }
      }
    }
  }
}

}  // namespace

template <InstructionSet isa>
Tet4Kernels make_tet4_kernels() {
  return {packed_energy<isa>, packed_energy_changes<isa>, packed_forces<isa>,
          packed_reduced_hessians<isa>};
}

}  // namespace trefoil
