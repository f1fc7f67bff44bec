#pragma once

#include <petscsnes.h>

#include <array>

#include "snes/solve_context.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

/// A direction p of negative curvature, where there is one.
struct NegativeCurvature {
  Vec direction = nullptr;  ///< one of the work vectors
  double squared_norm = 0;  ///< p'Mp of the preconditioner M, the filtered Jacobian or near it
};

/// Five vectors like x, destroyed together.
class WorkVectors {
 public:
  explicit WorkVectors(Vec x) : x_(x) {}
  WorkVectors(const WorkVectors &) = delete;
  WorkVectors &operator=(const WorkVectors &) = delete;
  ~WorkVectors() {
    for (Vec &v : vectors_) static_cast<void>(VecDestroy(&v));  // errors have nowhere to go
  }
  PetscErrorCode get(std::size_t i, Vec *v) {
    PetscFunctionBeginUser;
    if (!vectors_[i]) PetscCall(VecDuplicate(x_, &vectors_[i]));
    *v = vectors_[i];
    PetscFunctionReturn(PETSC_SUCCESS);
  }

 private:
  Vec x_;
  std::array<Vec, 5> vectors_{};
};

/// a'b of real vectors.
PetscErrorCode dot(Vec a, Vec b, double *product);

/// Conjugate gradients on the unfiltered Hessian H from a random right-hand side, preconditioned by
/// the solver of the filtered one, which must be positive definite:
///
/// - p'Hp < 0 of a search direction p proves that H is indefinite, whatever the preconditioner;
/// - a residual below 1e-4 / sqrt(n) of the first one proves that it is definite, but for a chance
///   of about 1e-4. As long as no p'Hp was negative, the residual is q(M^-1 H) times the first one
///   for a polynomial with q(0) = 1 and positive roots, so |q| > 1 at negative arguments: the part
///   of the residual in an eigenvector of negative curvature grows. It began at about 1 / sqrt(n),
///   unless the random vector happened to have nearly no part in that eigenvector.
///
/// Collective.
/// @param found the direction where `kind` is a saddle; it belongs to `work`
PetscErrorCode probe_curvature(SolveContext &context, Mat filtered, WorkVectors &work,
                               StationaryPoint *kind, NegativeCurvature *found);

}  // namespace trefoil
