#pragma once

#include <petscsys.h>

#include <array>
#include <string>
#include <vector>

namespace trefoil {

/// A force and its moment about the origin.
struct Resultant {
  std::array<double, 3> force{}, moment{};
};

/// What a constraint takes, and how it holds the body.
struct ConstraintReport {
  std::string name;
  PetscInt64 vertices = 0;
  double area = 0;  ///< of the surface between them, at rest
  Resultant reaction;
};

/// What a load takes, and how it pulls at the body.
struct LoadReport {
  std::string name;
  PetscInt64 facets = 0;
  double area = 0;  ///< of them, at rest
  Resultant resultant;
};

/// A part of the body with a material of its own.
struct RegionReport {
  std::string name;
  PetscInt64 cells = 0;
  double volume = 0, mass = 0;  ///< at rest
};

}  // namespace trefoil
