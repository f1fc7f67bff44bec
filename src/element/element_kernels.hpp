#pragma once

// The batched kernels of isoparametric simplices. Included only by the files that are compiled for
// one instruction set each (element_kernels_*.cpp); everything in here depends on Pack<isa>.

#include "element/pack_at_rest.hpp"

namespace trefoil {
namespace {

/// Place of (r, c) in a lower triangle, whichever is larger.
constexpr int lower(int r, int c) {
  return r >= c ? r * (r + 1) / 2 + c : c * (c + 1) / 2 + r;
}

/// The kernels of one element, see ElementKernels.
template <int nodes, int points, int dim, InstructionSet isa>
struct Kernels {
  using Real = Pack<isa>;
  using Elements = PackAtRest<nodes, points, dim, isa>;
  using Modes = ElementModes<nodes, isa>;
  static constexpr int modes = nodes - 1;
  static constexpr int rows = dim * modes, entries = rows * (rows + 1) / 2;
  static constexpr int tangent_rows = dim * dim;
  static constexpr int tangent_entries = tangent_rows * (tangent_rows + 1) / 2;

  /// Calls work(weight, H) at every point of the packs.
  template <class Work>
  static void at_points(const ElementPacks &packed, PetscInt first, PetscInt count, const double *u,
                        const Work &work) {
    Real U[modes][dim], G[modes][dim];
    alignas(64) double H[9 * lanes];
    for (PetscInt pack = first; pack < first + count; ++pack) {
      const Elements elements(packed, pack);
      elements.displacements(u, U);
      for (int q = 0; q < points; ++q) {
        elements.gradients(q, G);
        Elements::displacement_gradient(U, G, H);
        work(elements.weight(q), H);
      }
    }
  }

  static void energy(const MaterialModel &material, const ElementPacks &packed, PetscInt first,
                     PetscInt count, const double *u, double *sums) {
    Real energy, scale;
    alignas(64) double psi[lanes];
    at_points(packed, first, count, u, [&](const Real &weight, const double *H) {
      material.energy_densities(H, psi);
      const Real density = Real::load(psi);
      energy += density * weight;
      scale += abs(density) * weight;
    });
    sums[0] += energy.sum();
    sums[1] += scale.sum();
  }

  static void energy_changes(const MaterialModel &material, const ElementPacks &packed,
                             PetscInt first, PetscInt count, const double *u, int directions,
                             const double *const *d, std::span<const PlanePoint> plane,
                             double *sums) {
    Real U[3][modes][dim], G[modes][dim];
    alignas(64) double H[3][9 * lanes] = {}, weight[lanes];  // of u and of the directions
    for (PetscInt pack = first; pack < first + count; ++pack) {
      const Elements elements(packed, pack);
      elements.displacements(u, U[0]);
      for (int k = 0; k < directions; ++k) elements.displacements(d[k], U[k + 1]);
      for (int q = 0; q < points; ++q) {
        elements.gradients(q, G);
        for (int k = 0; k <= directions; ++k) Elements::displacement_gradient(U[k], G, H[k]);
        elements.weight(q).store(weight);
        material.energy_changes(H[0], H[1], H[2], plane, weight, sums);
      }
    }
  }

  static void forces(const MaterialModel &material, const ElementPacks &packed, PetscInt first,
                     PetscInt count, const double *u, double *forces) {
    Real U[modes][dim], G[modes][dim];
    alignas(64) double H[9 * lanes], P[9 * lanes];
    for (PetscInt pack = first; pack < first + count; ++pack) {
      const Elements elements(packed, pack);
      elements.displacements(u, U);
      Real reduced[dim][modes];
      for (int q = 0; q < points; ++q) {
        elements.gradients(q, G);
        Elements::displacement_gradient(U, G, H);
        material.stresses(H, P);
        Elements::add_stress(elements.weight(q), P, G, reduced);
      }
      elements.add_forces(reduced, forces);
    }
  }

  /// The lower triangle of the in-plane part of A = dP/dF.
  static void store_triangle(const double *full, double *A) {
    for (int r = 0; r < tangent_rows; ++r) {
      for (int c = 0; c <= r; ++c, A += lanes) {
        const int row = 3 * (r / dim) + r % dim, column = 3 * (c / dim) + c % dim;
        Real::load(full + lanes * (9 * row + column)).store(A);
      }
    }
  }

  static void tangents(const MaterialModel &material, const ElementPacks &packed, PetscInt first,
                       PetscInt count, const double *u, double *A) {
    alignas(64) double full[81 * lanes];
    at_points(packed, first, count, u, [&](const Real &, const double *H) {
      material.tangents(H, full);
      store_triangle(full, A);
      A += tangent_entries * lanes;
    });
  }

  /// Column (l, m) of the contraction at point q: C_ij = w sum_n A_ij,mn G_l[n].
  static void contract_column(const double *A, const Real &weight, const Real (&G)[dim], int m,
                              Real (&C)[tangent_rows]) {
    for (int p = 0; p < tangent_rows; ++p) {
      Real sum;
      for (int n = 0; n < dim; ++n) sum += Real::load(A + lanes * lower(p, dim * m + n)) * G[n];
      C[p] = weight * sum;
    }
  }

  static void contract(const ElementPacks &packed, PetscInt first, PetscInt count, const double *A,
                       double *K) {
    Real G[points][modes][dim];
    for (PetscInt pack = first; pack < first + count;
         ++pack, A += points * tangent_entries * lanes, K += entries * lanes) {
      const Elements elements(packed, pack);
      for (int q = 0; q < points; ++q) elements.gradients(q, G[q]);
      for (int l = 0; l < modes; ++l) {
        for (int m = 0; m < dim; ++m) {
          Real C[points][tangent_rows];
          for (int q = 0; q < points; ++q) {
            contract_column(A + q * tangent_entries * lanes, elements.weight(q), G[q][l], m, C[q]);
          }
          const int column = dim * l + m;
          for (int k = l; k < modes; ++k) {
            for (int i = k == l ? m : 0; i < dim; ++i) {
              Real sum;
              for (int q = 0; q < points; ++q) {
                for (int j = 0; j < dim; ++j) sum += G[q][k][j] * C[q][dim * i + j];
              }
              sum.store(K + lanes * lower(dim * k + i, column));
            }
          }
        }
      }
    }
  }

  static void hessians(const MaterialModel &material, const ElementPacks &packed, PetscInt first,
                       PetscInt count, const double *u, double *K) {
    for (PetscInt pack = first; pack < first + count; ++pack, K += entries * lanes) {
      if constexpr (points == 1) {
        hessians_of_constant_strain(material, packed, pack, u, K);
      } else {
        alignas(64) double A[points * tangent_entries * lanes];
        tangents(material, packed, pack, 1, u, A);
        contract(packed, pack, 1, A, K);
      }
    }
  }

  /// The same in one go, row by row, where there is one point: everything stays in registers.
  static void hessians_of_constant_strain(const MaterialModel &material, const ElementPacks &packed,
                                          PetscInt pack, const double *u, double *K) {
    Real U[modes][dim], G[modes][dim];
    alignas(64) double H[9 * lanes], A[81 * lanes];
    const Elements elements(packed, pack);
    elements.displacements(u, U);
    elements.gradients(0, G);
    Elements::displacement_gradient(U, G, H);
    material.tangents(H, A);
    const Real weight = elements.weight(0);
#pragma GCC unroll 3
    for (int k = 0; k < modes; ++k) {
      Real weighted[dim];
      for (int j = 0; j < dim; ++j) weighted[j] = weight * G[k][j];
#pragma GCC unroll 3
      for (int i = 0; i < dim; ++i) {
        Real row[dim][dim];  // w sum_j G_k[j] dP_ij/dF_mn
#pragma GCC unroll 9
        for (int p = 0; p < dim * dim; ++p) {
          const double *column = A + lanes * (27 * i + 3 * (p / dim) + p % dim);
          Real sum = weighted[0] * Real::load(column);
          for (int j = 1; j < dim; ++j) sum += weighted[j] * Real::load(column + 9 * lanes * j);
          row[p / dim][p % dim] = sum;
        }
#pragma GCC unroll 9
        for (int column = 0; column <= dim * k + i; ++column, K += lanes) {
          const int l = column / dim, m = column % dim;
          Real sum = row[m][0] * G[l][0];
          for (int n = 1; n < dim; ++n) sum += row[m][n] * G[l][n];
          sum.store(K);
        }
      }
    }
  }

  /// Goes through half of the product, H_al = sum_k Q[a][k] K_kl, one pair of components at a time.
  static void expand(const double *K, double *blocks) {
    for (int i = 0; i < dim; ++i) {
      for (int m = 0; m < dim; ++m) {
        Real half[nodes][modes];
        for (int l = 0; l < modes; ++l) {
          Real column[modes], x[nodes];
          for (int k = 0; k < modes; ++k) {
            column[k] = Real::load(K + lanes * lower(dim * k + i, dim * l + m));
          }
          Modes::expand(column, x);
          for (int a = 0; a < nodes; ++a) half[a][l] = x[a];
        }
        double *block = blocks + lanes * (dim * i + m);
        for (int a = 0; a < nodes; ++a) {
          Real row[nodes];
          Modes::expand(half[a], row);
          for (int b = a; b < nodes; ++b, block += dim * dim * lanes) row[b].store(block);
        }
      }
    }
  }

  static ElementKernels all() {
    return {energy, energy_changes, forces, hessians, tangents, contract, expand, nullptr, nullptr};
  }
};

}  // namespace
}  // namespace trefoil
