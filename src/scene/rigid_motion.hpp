#pragma once

#include <petscsys.h>

#include <array>
#include <vector>

namespace trefoil {

/// A screw: a turn about an axis and a slide along it, by Chasles' theorem every rigid motion.
struct RigidMotion {
  std::array<double, 3> axis{0, 0, 1};  ///< of length one
  std::array<double, 3> point{};        ///< on the axis
  double angle = 0;                     ///< 0 to pi
  std::array<double, 3> slide{};        ///< along the axis; where nothing turns, the translation

  /// Where the share t of the motion takes a place.
  [[nodiscard]] std::array<double, 3> move(const double *place, double t) const;
};

/// The rigid motion that takes places to where they go, least squares; of several (places on a
/// line, or one place) the one that turns least. [B. K. P. Horn, "Closed-form solution of absolute
/// orientation using unit quaternions", J. Opt. Soc. Am. A 4, 1987]
/// @param from, to this rank's places, 3 numbers each
/// @param deviation the most that a place is off it
/// Collective.
PetscErrorCode fit_rigid_motion(MPI_Comm comm, const std::vector<double> &from,
                                const std::vector<double> &to, RigidMotion *motion,
                                double *deviation);

}  // namespace trefoil
