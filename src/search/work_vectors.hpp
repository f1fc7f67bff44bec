#pragma once

#include <petscvec.h>

#include <array>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

/// What a vector of the search is for; each has one use.
enum class Work : std::size_t {
  start,        ///< a copy of x that the host's callbacks do not know
  direction,    ///< the linear solver's direction
  product,      ///< a Hessian times a vector
  slope_point,  ///< points of the line where the slope is integrated, and the residual there
  slope_residual,
  previous_step,     ///< the step before
  scaled_previous,   ///< the same, as long as the direction
  plane_minimiser,   ///< the direction of subspace minimisation
  newton_direction,  ///< of the unfiltered Hessian
  cg_residual,       ///< of conjugate gradients that look for negative curvature
  cg_preconditioned,
  cg_direction,
  lanczos_scale,  ///< of Lanczos' method, which looks for it in the inverse
  lanczos_last,
  lanczos_vector,
  lanczos_next,
  count
};

/// Vectors like those of the SNES, made when they are first asked for.
class WorkVectors {
 public:
  WorkVectors() = default;
  WorkVectors(const WorkVectors &) = delete;
  WorkVectors &operator=(const WorkVectors &) = delete;
  ~WorkVectors() { static_cast<void>(release()); }  // errors have nowhere to go

  PetscErrorCode get(Work use, Vec like, Vec *vector) {
    Vec &own = vectors_[static_cast<std::size_t>(use)];
    PetscFunctionBeginUser;
    if (!own) PetscCall(VecDuplicate(like, &own));
    *vector = own;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  /// Destroys all: the next problem may have another size.
  PetscErrorCode release() {
    PetscFunctionBeginUser;
    for (Vec &vector : vectors_) PetscCall(VecDestroy(&vector));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

 private:
  std::array<Vec, static_cast<std::size_t>(Work::count)> vectors_{};
};

}  // namespace trefoil
