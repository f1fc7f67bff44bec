#pragma once

#include <array>
#include <functional>
#include <vector>

#include "mesh/mesh.hpp"

namespace trefoil {

/// A triangle of the body's surface, of a plane body an edge: its local vertices, in the order of
/// its shape. Seen from outside of the body a triangle's corners run anticlockwise, and the body is
/// to the left of an edge.
struct Facet {
  const CellShape *shape = &shapes::tri3;
  std::array<PetscInt, CellShape::most_facet_nodes> vertices{};
  PetscInt cell = 0;  ///< the local cell that has it

  [[nodiscard]] int corners() const { return shape->corners; }
  [[nodiscard]] int count() const { return shape->nodes; }
  [[nodiscard]] const PetscInt *begin() const { return vertices.data(); }
  [[nodiscard]] const PetscInt *end() const { return vertices.data() + shape->nodes; }
};

/// The facets of this rank's cells that belong to no other cell, of this rank or another, and that
/// `wanted` takes; each of the whole mesh's is on one rank. Collective; what `wanted` says of a
/// facet must depend on nothing but its vertices.
PetscErrorCode boundary_facets(const Mesh &mesh, const std::function<bool(const Facet &)> &wanted,
                               std::vector<Facet> *facets);

/// Adds up, at the rank that owns each vertex, what all ranks have for it, 3 numbers a local
/// vertex; zero where another rank owns it. Collective.
PetscErrorCode sum_at_owners(const Mesh &mesh, std::vector<double> *values);

}  // namespace trefoil
