#pragma once

#include <petscsys.h>

#include "element/element_packs.hpp"
#include "filter/filter.hpp"

namespace trefoil {

/// Elements of one kind whose reduced Hessians are made, split and added in packs of eight: what
/// the batched assembly sees of a term. Packs [first, first + count) at a time; matrices are lower
/// triangles of rows() rows, entry e of lane l of matrix p at (entries() p + e) * 8 + l.
class PackedElements {
 public:
  virtual ~PackedElements() = default;
  [[nodiscard]] virtual PetscInt elements() const = 0;
  [[nodiscard]] PetscInt packs() const { return (elements() + lanes - 1) / lanes; }
  [[nodiscard]] virtual int rows() const = 0;
  [[nodiscard]] int entries() const { return rows() * (rows() + 1) / 2; }

  /// Reduced Hessians at the local displacements u.
  virtual void hessians(PetscInt first, PetscInt count, const double *u, double *K) const = 0;
  /// Their negative parts N, and how many eigenvalues were negative (see split_reduced()).
  /// @param K what hessians() made
  virtual SplitResult split(PetscInt first, PetscInt count, const double *u, const double *K,
                            double *N, int *negative) const = 0;
  /// Adds the elements' blocks, see ElementKernels.
  virtual void add_blocks(PetscInt first, PetscInt count, const double *K, const int *chosen,
                          const ElementPlaces &places, double *const arrays[3]) const = 0;
};

}  // namespace trefoil
