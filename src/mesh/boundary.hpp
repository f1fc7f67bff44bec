#pragma once

#include <array>
#include <functional>
#include <vector>

#include "mesh/mesh.hpp"

namespace trefoil {

/// A triangle of the body's surface, of a plane body an edge: its local vertices, corners in the
/// order of their global numbers, then, of quadratic cells, the midpoints of the edges between
/// corners 0 and 1, 1 and 2, 2 and 0.
struct Facet {
  std::array<PetscInt, 6> vertices{};
  int corners = 3, count = 3;

  [[nodiscard]] const PetscInt *begin() const { return vertices.data(); }
  [[nodiscard]] const PetscInt *end() const { return vertices.data() + count; }
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
