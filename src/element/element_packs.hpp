#pragma once

#include <petscsystypes.h>

#include <span>
#include <vector>

#include "element/reference_element.hpp"
#include "trefoil/material_model.hpp"

namespace trefoil {

/// Elements of one kind at rest, eight to a pack, structure of arrays: simplices of order 1 or 2,
/// straight or bent.
///
/// Shape functions add up to one, so that translations cost nothing: with an orthonormal basis Q
/// (nodes x (nodes - 1)) of what is orthogonal to the constant vector, an element has
/// rows = dim (nodes - 1) unknowns, its reduced gradients are G_k = sum_a Q[a][k] g_a, and its
/// Hessian has the non-zero eigenvalues of the full one. Q are columns 1.. of the Householder
/// reflection that takes the first unit vector to the constant one: with s = 1/sqrt(nodes),
/// c = s^2/(1 - s), Q[0][k] = s and Q[a][k] = delta_{a,k+1} - c, so that changing bases costs
/// additions in proportion to the nodes. For four nodes Q is the three Hadamard vectors that are
/// not constant, over two.
///
/// Nodes stand in an order of their own: corners by ascending vertex number, then midpoints by the
/// corners of their edges, (0,1) (0,2) (0,3) (1,2) (1,3) (2,3). Two elements that share two nodes
/// then have them in the same order.
///
/// The last pack is filled up with copies of the last element that have no volume.
struct ElementPacks {
  const ReferenceElement *reference = nullptr;
  PetscInt elements = 0;
  std::vector<PetscInt> nodes;    ///< packs x nodes x 8: local vertex numbers
  std::vector<double> jacobians;  ///< packs x points x (dim^2 + 1) x 8: inverse Jacobian matrix row
                                  ///< by row (reference, position), then weight times determinant
  std::vector<double> reduced;    ///< points x (nodes - 1) x dim: reduced gradients on the
                                  ///< reference cell

  [[nodiscard]] PetscInt packs() const { return (elements + lanes - 1) / lanes; }
  /// Rows of a reduced Hessian, and entries of its lower triangle.
  [[nodiscard]] int rows() const { return reference->dimension * (reference->nodes - 1); }
  [[nodiscard]] int entries() const { return rows() * (rows() + 1) / 2; }
  /// Entries of the lower triangle of the in-plane part of dP/dF: 45, in the plane 10.
  [[nodiscard]] int tangent_entries() const { return reference->dimension == 3 ? 45 : 10; }
  [[nodiscard]] double bytes() const {
    return static_cast<double>(jacobians.capacity() * sizeof(double) +
                               nodes.capacity() * sizeof(PetscInt));
  }
};

/// Cells as packs, in their order.
/// @param cells cells x nodes: vertex numbers, in the order of the reference element
/// @param coordinates vertices x 3: rest positions
ElementPacks pack_elements(const ReferenceElement &reference, std::span<const PetscInt> cells,
                           std::span<const double> coordinates);

/// The batched kernels of an element, for packs [first, first + count). `u` and `forces` are local
/// arrays, 3 numbers a local vertex. Matrices in packs are lower triangles, entry e of lane l of
/// matrix p at (entries p + e) * 8 + l, p from 0.
struct ElementKernels {
  /// Adds sum psi w to sums[0] and sum |psi| w to sums[1], psi less psi(I).
  void (*energy)(const MaterialModel &material, const ElementPacks &elements, PetscInt first,
                 PetscInt count, const double *u, double *sums);
  /// Adds w (psi(u + a d_0 + b d_1) - psi(u)) at each of the points (a, b) of a plane to its eight
  /// sums, one a lane; with one of the `directions`, local arrays d, b does not count. One pass.
  void (*energy_changes)(const MaterialModel &material, const ElementPacks &elements,
                         PetscInt first, PetscInt count, const double *u, int directions,
                         const double *const *d, std::span<const PlanePoint> points, double *sums);
  /// Adds the elements' forces, sum over the points of w P g_a.
  void (*forces)(const MaterialModel &material, const ElementPacks &elements, PetscInt first,
                 PetscInt count, const double *u, double *forces);
  /// Reduced Hessians K.
  void (*hessians)(const MaterialModel &material, const ElementPacks &elements, PetscInt first,
                   PetscInt count, const double *u, double *K);
  /// dP/dF at the points, those of a pack one after the other; in the plane dP_ij/dF_kl with
  /// i, j, k, l < 2 only.
  void (*tangents)(const MaterialModel &material, const ElementPacks &elements, PetscInt first,
                   PetscInt count, const double *u, double *A);
  /// K = sum over the points of w B'AB for A as tangents() writes it.
  void (*contract)(const ElementPacks &elements, PetscInt first, PetscInt count, const double *A,
                   double *K);
  /// Expands one pack's reduced matrix K to the blocks H_ab = sum_kl Q[a][k] Q[b][l] K_kl, a <= b,
  /// row by row: entry (i, m) of block number q at (dim^2 q + dim i + m) * 8.
  void (*expand)(const double *K, double *blocks);
  /// Of elements with a pressure of their own, else null: dU/dJ after a step d, linearised at u,
  /// one number an element, eight a pack from `first` on (tension is positive).
  void (*pressures)(const MaterialModel &material, const ElementPacks &elements, PetscInt first,
                    PetscInt count, const double *u, const double *d, double *pressures) = nullptr;
  /// The same elements' Hessians with what pressures() wrote in place of their pressures at u, as
  /// those of unknowns of their own.
  void (*hessians_at_pressures)(const MaterialModel &material, const ElementPacks &elements,
                                PetscInt first, PetscInt count, const double *u,
                                const double *pressures, double *K) = nullptr;
};

/// How a quadratic element takes the volumetric part U(J) of psi = W(F) + U(J).
enum class ElementPressure {
  pointwise,  ///< at each quadrature point
  constant    ///< at the element's mean of J: P2-P0, mean dilatation
};

/// The kernels of an element for an instruction set.
/// @param pressure other than `pointwise` for quadratic elements only; linear ones have one point
ElementKernels element_kernels(const ReferenceElement &reference,
                               ElementPressure pressure = ElementPressure::pointwise,
                               InstructionSet instructions = chosen_instruction_set());

/// The same, defined in the file that is compiled for it.
template <InstructionSet isa>
ElementKernels make_element_kernels(int dimension, int nodes, ElementPressure pressure);

}  // namespace trefoil
