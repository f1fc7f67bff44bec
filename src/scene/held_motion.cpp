#include "scene/held_motion.hpp"

#include <algorithm>
#include <array>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode find_held_motion(Constraints &constraints, double end, double time, double length,
                                HeldMotion *motion) {
  struct Differences {
    std::array<double, 4> velocity, acceleration;
  };
  constexpr Differences central{{0, 0.5, -0.5, 0}, {-2, 1, 1, 0}};
  constexpr Differences one_sided{{-1.5, 2, -0.5, 0}, {2, -5, 4, -1}};
  const double h = std::min(length, end / 3);
  HeldDofs held;
  PetscFunctionBeginUser;
  PetscCall(constraints.hold(time, &held));
  const std::size_t size = held.value.size();
  motion->held = held.held;
  motion->at_end = {held.value, std::vector<double>(size, 0), std::vector<double>(size, 0)};
  if (!constraints.move_in_time()) PetscFunctionReturn(PETSC_SUCCESS);
  const bool at_start = time - h<0, at_end = time + h> end;
  const Differences &weights = at_start || at_end ? one_sided : central;
  const double sign = at_end ? -1 : 1;
  const std::array<double, 4> offsets{0, sign * h, at_start || at_end ? 2 * sign * h : -h,
                                      3 * sign * h};
  for (std::size_t s = 0; s < 4; ++s) {
    if (weights.velocity[s] == 0 && weights.acceleration[s] == 0) continue;
    PetscCall(constraints.hold(time + offsets[s], &held));
    for (std::size_t k = 0; k < size; ++k) {
      motion->at_end.v[k] += sign * weights.velocity[s] / h * held.value[k];
      motion->at_end.a[k] += weights.acceleration[s] / (h * h) * held.value[k];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
