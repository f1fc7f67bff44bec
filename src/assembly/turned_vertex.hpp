#pragma once

#include <petscsystypes.h>

#include <array>
#include <cstddef>

namespace trefoil {

/// A vertex with unknowns along axes of its own, of which the first are held: it slides in a plane
/// or along a line that is not parallel to the axes of space.
struct TurnedVertex {
  PetscInt vertex = 0;                          ///< local
  int held = 0;                                 ///< along the first so many axes
  std::array<std::array<double, 3>, 3> axes{};  ///< orthonormal
  std::array<double, 3> values{};               ///< displacements along the held ones
  std::array<int, 3> holder{-1, -1, -1};        ///< which constraint holds along each of them

  /// u = sum_k y_k axis_k, in place.
  void to_space(double *u) const {
    const std::array<double, 3> y{u[0], u[1], u[2]};
    for (std::size_t i = 0; i < 3; ++i) {
      u[i] = axes[0][i] * y[0] + axes[1][i] * y[1] + axes[2][i] * y[2];
    }
  }
  /// y_k = axis_k . u, in place.
  void to_axes(double *u) const {
    const std::array<double, 3> x{u[0], u[1], u[2]};
    for (std::size_t k = 0; k < 3; ++k) {
      u[k] = axes[k][0] * x[0] + axes[k][1] * x[1] + axes[k][2] * x[2];
    }
  }
};

}  // namespace trefoil
