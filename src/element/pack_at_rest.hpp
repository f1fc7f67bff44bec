#pragma once

// Included only by the files that are compiled for one instruction set each.

#include "element/element_modes.hpp"
#include "element/element_packs.hpp"

namespace trefoil {
namespace {

/// The rest shape of the elements of a pack.
template <int nodes, int points, int dim, InstructionSet isa>
struct PackAtRest {
  using Real = Pack<isa>;
  using Modes = ElementModes<nodes, isa>;
  static constexpr int modes = nodes - 1;
  using Displacements = Real[modes][dim];  ///< U_k[i]
  using Gradients = Real[modes][dim];      ///< G_k[i] of a point

  const double *jacobians, *reduced;
  const PetscInt *node;

  PackAtRest(const ElementPacks &packed, PetscInt pack)
      : jacobians(packed.jacobians.data() + points * (dim * dim + 1) * lanes * pack),
        reduced(packed.reduced.data()),
        node(packed.nodes.data() + nodes * lanes * pack) {}

  [[nodiscard]] Real weight(int q) const {
    return Real::load(jacobians + lanes * ((dim * dim + 1) * q + dim * dim));
  }
  void gradients(int q, Gradients &G) const {
    Real inverse[dim * dim];
    for (int k = 0; k < dim * dim; ++k) {
      inverse[k] = Real::load(jacobians + lanes * ((dim * dim + 1) * q + k));
    }
    const double *g = reduced + modes * dim * q;
    for (int k = 0; k < modes; ++k, g += dim) {
      for (int i = 0; i < dim; ++i) {
        Real sum = g[0] * inverse[i];
        for (int j = 1; j < dim; ++j) sum += g[j] * inverse[dim * j + i];
        G[k][i] = sum;
      }
    }
  }
  void displacements(const double *u, Displacements &U) const {
    for (int i = 0; i < dim; ++i) {
      Real x[nodes], y[modes];
      for (int a = 0; a < nodes; ++a) {
        for (int lane = 0; lane < lanes; ++lane) x[a].v[lane] = u[3 * node[lanes * a + lane] + i];
      }
      Modes::reduce(x, y);
      for (int k = 0; k < modes; ++k) U[k][i] = y[k];
    }
  }

  /// H = sum_k U_k G_k' as PackedFunctions takes it; in the plane nothing moves in the third
  /// direction.
  static void displacement_gradient(const Displacements &U, const Gradients &G, double *H) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        Real sum(0.0);
        if (i < dim && j < dim) {
          sum = U[0][i % dim] * G[0][j % dim];
          for (int k = 1; k < modes; ++k) sum += U[k][i % dim] * G[k][j % dim];
        }
        sum.store(H + lanes * (3 * i + j));
      }
    }
  }

  /// Adds w P G_k to the reduced forces.
  static void add_stress(const Real &weight, const double *P, const Gradients &G,
                         Real (&reduced_forces)[dim][modes]) {
    for (int i = 0; i < dim; ++i) {
      Real stress[dim];
      for (int j = 0; j < dim; ++j) stress[j] = weight * Real::load(P + lanes * (3 * i + j));
      for (int k = 0; k < modes; ++k) {
        for (int j = 0; j < dim; ++j) reduced_forces[i][k] += stress[j] * G[k][j];
      }
    }
  }
  /// Adds the reduced forces to those of the nodes.
  void add_forces(const Real (&reduced_forces)[dim][modes], double *forces) const {
    for (int i = 0; i < dim; ++i) {
      Real force[nodes];
      Modes::expand(reduced_forces[i], force);
      for (int a = 0; a < nodes; ++a) {
        for (int lane = 0; lane < lanes; ++lane) {
          forces[3 * node[lanes * a + lane] + i] += force[a].v[lane];
        }
      }
    }
  }
};

}  // namespace
}  // namespace trefoil
