#pragma once

#include "assembly/discretization.hpp"

namespace trefoil {

/// The linear displacements of a quadratic mesh: those of its corners, with the midpoints of edges
/// halfway between. They have an unknown for each unknown of a corner, in the same order and on the
/// same ranks; held ones of turned vertices, which have rows in the Hessian, are among them.
class CornerInterpolation {
 public:
  CornerInterpolation() = default;
  CornerInterpolation(const CornerInterpolation &) = delete;
  CornerInterpolation &operator=(const CornerInterpolation &) = delete;
  ~CornerInterpolation();

  /// Collective; once.
  PetscErrorCode set_up(const Discretization &discretization);

  /// From unknowns of the corners to those of all vertices, AIJ. Zero in the rows of what is held.
  [[nodiscard]] Mat matrix() const { return matrix_; }
  /// The corners' unknowns among all.
  [[nodiscard]] IS corners() const { return corners_; }

  /// Attaches the rigid-body modes of `fine`, restricted to the corners, to `coarse`. Collective.
  PetscErrorCode attach_modes(Mat fine, Mat coarse) const;

 private:
  Mat matrix_ = nullptr;
  IS corners_ = nullptr;
};

}  // namespace trefoil
