#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mesh/check_mesh.hpp"

namespace trefoil {
namespace {

/// For each midpoint of a cell the edge in the middle of which it lies: its own, unless it is ten
/// times as near to another one's middle.
std::vector<std::size_t> edges_of_midpoints(const CellList &mesh, const PetscInt *node) {
  const auto &edges = mesh.shape->edges;
  const auto at = [&](int k, std::size_t i) {
    return mesh.coordinates[3 * static_cast<std::size_t>(node[k]) + i];
  };
  const auto distance = [&](int k, const std::array<int, 2> &edge) {
    std::array<double, 3> d;
    for (std::size_t i = 0; i < 3; ++i) d[i] = at(k, i) - (at(edge[0], i) / 2 + at(edge[1], i) / 2);
    return std::hypot(d[0], d[1], d[2]);
  };
  std::vector<std::size_t> found;
  for (std::size_t own = 0; own < edges.size(); ++own) {
    const int k = mesh.corners() + static_cast<int>(own);
    double least = distance(k, edges[own]) / 10;
    std::size_t best = own;
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const double here = distance(k, edges[e]);
      if (here < least) best = e;
      least = std::min(least, here);
    }
    found.push_back(best);
  }
  return found;
}

/// Whether midpoints have changed places. Those of a bent cell may come near to other edges, but do
/// not change places with theirs.
bool have_changed_places(const std::vector<std::size_t> &edges) {
  if (std::is_sorted(edges.begin(), edges.end())) return false;
  std::vector<std::size_t> sorted(edges);
  std::sort(sorted.begin(), sorted.end());
  return std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
}

/// "its node 9 lies between corners 2 and 4, where node 10 belongs", as Gmsh numbers nodes.
std::string first_wrong_place(const CellShape &shape, const std::vector<std::size_t> &edges) {
  const auto gmsh_number = [&](std::size_t midpoint) {
    const auto node = static_cast<std::size_t>(shape.corners) + midpoint;
    return std::to_string(shape.gmsh_order[node] + 1);
  };
  std::size_t k = 0;
  while (edges[k] == k) ++k;
  const auto &edge = shape.edges[edges[k]];
  return "its node " + gmsh_number(k) + " lies between corners " + std::to_string(edge[0] + 1) +
         " and " + std::to_string(edge[1] + 1) + ", where node " + gmsh_number(edges[k]) +
         " belongs";
}

}  // namespace

void check_node_order(const CellList &mesh, const std::string &name) {
  if (!is_quadratic(*mesh.shape)) return;
  for (PetscInt cell = 0; cell < mesh.size(); ++cell) {
    const std::vector<std::size_t> edges = edges_of_midpoints(
        mesh, &mesh.cells[static_cast<std::size_t>(mesh.nodes_per_cell() * cell)]);
    if (!have_changed_places(edges)) continue;
    throw InputError(
        name + ": " + name_of_cell(mesh, cell) +
        " has its midpoints in another order than Gmsh: " + first_wrong_place(*mesh.shape, edges) +
        "; save the mesh again with gmsh, or use its corners only with -order 1");
  }
}

}  // namespace trefoil
