#pragma once

#include <petscsys.h>

#include "element/element_packs.hpp"
#include "filter/filter.hpp"

namespace trefoil {

/// What is split into its positive and negative part.
enum class FilterSpace {
  element,     ///< the Hessian of an element, exactly
  deformation  ///< dP/dF at each quadrature point: N_e = sum_q w_q B' N_q B
};

/// Elements of one kind whose reduced Hessians are made and split in packs of eight: what the
/// batched assembly sees of a term. Packs [first, first + count) at a time; matrices are lower
/// triangles of rows() rows, entry e of lane l of matrix p at (entries() p + e) * 8 + l.
class PackedElements {
 public:
  virtual ~PackedElements() = default;
  /// Their nodes and the basis of the reduced matrices; the mesh's cells, in their order.
  [[nodiscard]] virtual const ElementPacks &elements() const = 0;
  /// Expands reduced matrices to blocks of nodes, see ElementKernels.
  [[nodiscard]] virtual decltype(ElementKernels::expand) expand() const = 0;

  [[nodiscard]] virtual FilterSpace filter_space() const { return FilterSpace::element; }

  /// Reduced Hessians at the local displacements u.
  virtual void hessians(PetscInt first, PetscInt count, const double *u, double *K) const = 0;
  /// Their negative parts N, and how many eigenvalues were negative (see split_reduced()).
  /// @param K what hessians() made, and what Term::shift_filter() of other terms added
  virtual SplitResult split(PetscInt first, PetscInt count, const double *u, const double *K,
                            double *N, int *negative) const = 0;
};

}  // namespace trefoil
