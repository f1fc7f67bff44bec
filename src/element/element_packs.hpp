#pragma once

#include <petscsystypes.h>

#include <cstdint>
#include <vector>

#include "element/reference_element.hpp"
#include "trefoil/material_model.hpp"

namespace trefoil {

struct Mesh;

/// Elements of one kind at rest, eight to a pack, structure of arrays: what Tet4Packs is to linear
/// tetrahedra, for any simplex of order 1 or 2, straight or bent.
///
/// Shape functions add up to one, so that translations cost nothing: with an orthonormal basis Q
/// (nodes x (nodes - 1)) of what is orthogonal to the constant vector, an element has
/// rows = dim (nodes - 1) unknowns, its reduced gradients are G_k = sum_a Q[a][k] g_a, and its
/// Hessian has the non-zero eigenvalues of the full one. Q are columns 1.. of the Householder
/// reflection that takes the first unit vector to the constant one: with s = 1/sqrt(nodes),
/// c = s^2/(1 - s), Q[0][k] = s and Q[a][k] = delta_{a,k+1} - c, so that changing bases costs
/// additions in proportion to the nodes.
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

/// The cells of a mesh as packs, in their order.
ElementPacks pack_elements(const Mesh &mesh);

/// Where the dim x dim blocks of elements go: into up to three arrays.
struct ElementPlaces {
  static constexpr std::int32_t nowhere = -1, in_parts = 3;
  /// cells x nodes^2: block (a, b) of a cell at nodes a + b. `nowhere`, or: the two lowest bits
  /// choose the array, the rest is the place of the block's first number in it. Blocks `in_parts`
  /// instead have dim^2 such codes of single numbers, from that place on in `numbers`.
  std::vector<std::int32_t> code;
  /// 4 x local vertices: distance between the rows of a block in array r for row vertex v, at
  /// 4 v + r.
  std::vector<std::int32_t> stride;
  std::vector<std::int32_t> numbers;

  [[nodiscard]] double bytes() const {
    return static_cast<double>((code.capacity() + stride.capacity() + numbers.capacity()) *
                               sizeof(std::int32_t));
  }
};

/// The batched kernels of an element, for packs [first, first + count). `u` and `forces` are local
/// arrays, 3 numbers a local vertex. Matrices in packs are lower triangles, entry e of lane l of
/// matrix p at (entries p + e) * 8 + l, p from 0.
struct ElementKernels {
  /// Adds sum psi w to sums[0] and sum |psi - rest_density| w to sums[1].
  void (*energy)(const MaterialModel &material, const ElementPacks &elements, PetscInt first,
                 PetscInt count, const double *u, double rest_density, double *sums);
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
  /// Expands reduced matrices to the elements' blocks and adds them.
  /// @param chosen elements to add, by lane of the packs: those where it is positive; null: all
  /// @param arrays what ElementPlaces chooses from
  void (*add_blocks)(const ElementPacks &elements, PetscInt first, PetscInt count, const double *K,
                     const int *chosen, const ElementPlaces &places, double *const arrays[3]);
};

/// The kernels of an element for an instruction set.
ElementKernels element_kernels(const ReferenceElement &reference,
                               InstructionSet instructions = chosen_instruction_set());

/// The same, defined in the file that is compiled for it.
template <InstructionSet isa>
ElementKernels make_element_kernels(int dimension, int nodes);

}  // namespace trefoil
