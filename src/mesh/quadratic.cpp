#include "mesh/quadratic.hpp"

#include <algorithm>

namespace trefoil {
namespace {

/// An edge by its vertices, the smaller first, and where its midpoint stands in the new cells.
struct Edge {
  PetscInt from, to;
  std::size_t place;
  bool operator<(const Edge &other) const {
    return from != other.from ? from < other.from : to < other.to;
  }
};

/// Gives vertices that were added numbers behind all others.
void number_new_vertices(CellList &mesh, PetscInt count) {
  if (mesh.vertex_number.empty()) return;
  const PetscInt highest = *std::max_element(mesh.vertex_number.begin(), mesh.vertex_number.end());
  const PetscInt next = std::max(mesh.file_vertices, highest + 1);
  for (PetscInt k = 0; k < count; ++k) mesh.vertex_number.push_back(next + k);
}

}  // namespace

void promote_to_quadratic(CellList &mesh) {
  if (is_quadratic(*mesh.shape)) return;
  const auto corners = static_cast<std::size_t>(mesh.corners());
  const auto &edges = mesh.shape->edges;
  const auto width = static_cast<std::size_t>(mesh.shape->quadratic->nodes);
  const std::size_t cells = mesh.cells.size() / corners;
  std::vector<PetscInt> quadratic(cells * width);
  std::vector<Edge> all;
  all.reserve(cells * edges.size());
  for (std::size_t c = 0; c < cells; ++c) {
    const PetscInt *corner = &mesh.cells[corners * c];
    std::copy_n(corner, corners, &quadratic[width * c]);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const auto [from, to] = std::minmax(corner[edges[e][0]], corner[edges[e][1]]);
      all.push_back({from, to, width * c + corners + e});
    }
  }
  std::sort(all.begin(), all.end());
  const PetscInt before = mesh.vertices();
  PetscInt vertex = before - 1;
  for (std::size_t e = 0; e < all.size(); ++e) {
    if (e == 0 || all[e - 1] < all[e]) {
      ++vertex;
      for (std::size_t i = 0; i < 3; ++i)
        mesh.coordinates.push_back(
            0.5 * mesh.coordinates[static_cast<std::size_t>(3 * all[e].from) + i] +
            0.5 * mesh.coordinates[static_cast<std::size_t>(3 * all[e].to) + i]);
    }
    quadratic[all[e].place] = vertex;
  }
  mesh.cells.swap(quadratic);
  mesh.shape = mesh.shape->quadratic;
  number_new_vertices(mesh, vertex + 1 - before);
}

void drop_midpoints(CellList &mesh) {
  if (!is_quadratic(*mesh.shape)) return;
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  std::vector<PetscInt> linear;
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    const auto cell = mesh.cells.begin() + static_cast<std::ptrdiff_t>(c);
    linear.insert(linear.end(), cell, cell + mesh.corners());
  }
  mesh.cells.swap(linear);
  mesh.shape = mesh.shape->linear;
}

}  // namespace trefoil
