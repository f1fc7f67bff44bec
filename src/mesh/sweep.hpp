#pragma once

#include <array>
#include <functional>
#include <vector>

#include "mesh/cell_list.hpp"

namespace trefoil {

using Point = std::array<double, 3>;

/// A triangulated disc of radius 1: a centre and concentric rings, ring k with 6k points at radius
/// k / rings. Triangles run counterclockwise.
struct Disc {
  explicit Disc(PetscInt rings);

  std::vector<std::array<double, 2>> points;
  std::vector<std::array<PetscInt, 3>> triangles;  ///< 6 rings^2 of them
};

/// Whether a sweep ends in a face of its own or where it began.
enum class Closure { open, periodic };

/// Sweeps the disc along `layers` steps into prisms, three tetrahedra each. `place(layer, u, v)` is
/// where the point (u, v) of the disc comes to lie in a layer, 0 <= layer <= layers (periodic:
/// < layers); it keeps the orientation of (u, v, layer). A periodic sweep takes at least 3 layers.
CellList sweep(const Disc &disc, PetscInt layers, Closure closure,
               const std::function<Point(PetscInt layer, double u, double v)> &place);

}  // namespace trefoil
