#pragma once

#include <petscsys.h>

namespace trefoil {

/// A few unknowns that a dense matrix couples: those of an element, of a pair in contact.
struct Stencil {
  int n = 0;                       ///< unknowns
  const PetscInt *dofs = nullptr;  ///< their local numbers, 3 * local vertex + component
  bool global = false;             ///< `dofs` are numbers of the whole system, negative where held
  PetscInt cell = -1;              ///< the mesh's cell whose element it is; -1: none's
};

/// Takes the dense symmetric n x n matrices of stencils, one after the other.
class StencilSink {
 public:
  virtual ~StencilSink() = default;
  /// Adds H; its negative part is found here.
  virtual PetscErrorCode add(const Stencil &stencil, const double *H) = 0;
  /// The same where the term knows the negative part.
  /// @param N sum of |lambda| v v' over the negative eigenvalues; 0 where there is none
  /// @param negative how many eigenvalues are negative; -1: not finite
  virtual PetscErrorCode add_split(const Stencil &stencil, const double *H, const double *N,
                                   int negative) = 0;
};

}  // namespace trefoil
