#pragma once

#include <petscsystypes.h>

#include <array>

namespace trefoil {

/// A vertex that is not free to move in a direction of length one: it slides in a plane, or a
/// spring holds it.
struct Support {
  PetscInt vertex = 0;  ///< local
  std::array<double, 3> direction{};
};

}  // namespace trefoil
