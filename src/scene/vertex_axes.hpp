#pragma once

#include <array>
#include <vector>

#include "assembly/discretization.hpp"
#include "assembly/turned_vertex.hpp"

namespace trefoil {

/// What one more direction is to a vertex that is held along others.
enum class Direction { another, known, nearly_known, contradicts };

/// Holds a vertex along one more direction by one more axis, orthogonal to those that it has.
/// @param direction of length one
/// @param value displacement along it
/// @param holder the constraint
Direction add_direction(std::array<double, 3> direction, double value, int holder,
                        TurnedVertex *turned);

/// A vertex with the axes of those components that are held already, but not that out of the plane.
/// @param holder which constraint holds each local dof; -1: none
TurnedVertex begin_turned(const HeldDofs &held, PetscInt v, const std::vector<int> &holder);

/// Vertices that turn out to be held along axes of space alone are held by components; the others
/// by none, and get the axes that they lack.
void settle_turned(int dimension, HeldDofs *held, std::vector<int> *holder);

}  // namespace trefoil
