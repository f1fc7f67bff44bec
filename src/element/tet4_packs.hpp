#pragma once

#include <petscsystypes.h>

#include <vector>

#include "filter/reduced_filter.hpp"
#include "trefoil/material_model.hpp"

namespace trefoil {

struct Mesh;

/// Linear tetrahedra at rest, eight to a pack, structure of arrays.
///
/// The gradients g_a of the four shape functions add up to zero, so three combinations say it all:
/// with the Hadamard vectors h_1 = (1,1,-1,-1)/2, h_2 = (1,-1,1,-1)/2, h_3 = (1,-1,-1,1)/2, which
/// with the constant one are orthonormal,
///   G_k = sum_a h_k[a] g_a,   g_a = sum_k h_k[a] G_k.
/// In the basis h_k (x) e_i an element has nine unknowns and its Hessian is 9 x 9, with the same
/// non-zero eigenvalues as the 12 x 12 one: what is left out are the rigid translations.
///
/// Corners are in the order of their vertices' numbers, whatever it is in the mesh.
/// The last pack is filled up with copies of the last element that have no volume.
struct Tet4Packs {
  PetscInt elements = 0;
  std::vector<double> gradients;   ///< packs x 9 x 8: G_k[i] at row 3 k + i, 1/length
  std::vector<double> volumes;     ///< packs x 8: rest volumes
  std::vector<PetscInt> vertices;  ///< packs x 4 x 8: local vertex numbers

  [[nodiscard]] PetscInt packs() const { return (elements + lanes - 1) / lanes; }
  [[nodiscard]] double bytes() const {
    return static_cast<double>((gradients.capacity() + volumes.capacity()) * sizeof(double) +
                               vertices.capacity() * sizeof(PetscInt));
  }
};

/// The cells of a mesh as packs, in their order.
Tet4Packs pack_tetrahedra(const Mesh &mesh);

/// The element's batched kernels, for packs [first, first + count). `u` and `forces` are local
/// arrays, 3 numbers a local vertex.
struct Tet4Kernels {
  /// Adds sum psi V to sums[0] and sum |psi - rest_density| V to sums[1].
  void (*energy)(const MaterialModel &material, const Tet4Packs &tets, PetscInt first,
                 PetscInt count, const double *u, double rest_density, double *sums);
  /// Adds sum V (psi(u + sum_k c_k d_k) - psi(u)) to changes[p] for each of `points` rows c of
  /// coefficients, one for each of `directions` (one or two) local arrays d. One pass.
  void (*energy_changes)(const MaterialModel &material, const Tet4Packs &tets, PetscInt first,
                         PetscInt count, const double *u, int directions, const double *const *d,
                         int points, const double *coefficients, double *changes);
  /// Adds the elements' forces V P g_a.
  void (*forces)(const MaterialModel &material, const Tet4Packs &tets, PetscInt first,
                 PetscInt count, const double *u, double *forces);
  /// Reduced Hessians, lower triangles: K[(45 * pack + entry) * 8 + lane], pack from 0.
  void (*reduced_hessians)(const MaterialModel &material, const Tet4Packs &tets, PetscInt first,
                           PetscInt count, const double *u, double *K);
};

/// The kernels for an instruction set.
Tet4Kernels tet4_kernels(InstructionSet instructions = chosen_instruction_set());

/// The same, defined in the file that is compiled for it.
template <InstructionSet isa>
Tet4Kernels make_tet4_kernels();

}  // namespace trefoil
