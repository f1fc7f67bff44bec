#include "mesh/refine.hpp"

#include <algorithm>
#include <array>

#include "mesh/quadratic.hpp"

namespace trefoil {
namespace {

double signed_volume(const CellList &mesh, const std::array<PetscInt, 4> &cell) {
  double d[3][3];
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t i = 0; i < 3; ++i)
      d[a][i] = mesh.coordinates[static_cast<std::size_t>(3 * cell[a + 1]) + i] -
                mesh.coordinates[static_cast<std::size_t>(3 * cell[0]) + i];
  return d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) +
         d[0][1] * (d[1][2] * d[2][0] - d[1][0] * d[2][2]) +
         d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
}

double squared_distance(const CellList &mesh, PetscInt a, PetscInt b) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double difference = mesh.coordinates[static_cast<std::size_t>(3 * a) + i] -
                              mesh.coordinates[static_cast<std::size_t>(3 * b) + i];
    sum += difference * difference;
  }
  return sum;
}

/// The octahedron that is left when the four corners are cut off a tetrahedron, as four tetrahedra
/// around the shortest of its three diagonals [Bey 1995 on why the shortest].
void append_octahedron(const CellList &mesh, const PetscInt *node, std::vector<PetscInt> &cells) {
  // A diagonal, and the four others in a ring around it.
  constexpr std::size_t diagonals[3][6] = {
      {4, 9, 5, 6, 7, 8}, {5, 7, 4, 6, 9, 8}, {6, 8, 4, 5, 9, 7}};
  const auto *best = std::min_element(std::begin(diagonals), std::end(diagonals),
                                      [&](const auto &a, const auto &b) {
                                        return squared_distance(mesh, node[a[0]], node[a[1]]) <
                                               squared_distance(mesh, node[b[0]], node[b[1]]);
                                      });
  for (std::size_t k = 0; k < 4; ++k) {
    std::array<PetscInt, 4> cell{node[(*best)[0]], node[(*best)[1]], node[(*best)[2 + k]],
                                 node[(*best)[2 + (k + 1) % 4]]};
    if (signed_volume(mesh, cell) < 0) std::swap(cell[2], cell[3]);
    cells.insert(cells.end(), cell.begin(), cell.end());
  }
}

/// The children of a cell or of what bounds one, by the nodes of the quadratic one. A tetrahedron's
/// four corners only: the octahedron between them is cut as its shape wants it.
std::span<const int> children_of(const CellShape &shape) {
  static constexpr int point[] = {0}, edge[] = {0, 2, 2, 1},
                       triangle[] = {0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5},
                       tetrahedron[] = {0, 4, 6, 7, 4, 1, 5, 8, 6, 5, 2, 9, 7, 8, 9, 3};
  switch (shape.dimension) {
    case 0:
      return point;
    case 1:
      return edge;
    case 2:
      return triangle;
    default:
      return tetrahedron;
  }
}

/// Midpoints by the ends of their edges.
class Midpoints {
 public:
  explicit Midpoints(const CellList &quadratic) {
    const auto width = static_cast<std::size_t>(quadratic.nodes_per_cell());
    const auto &edges = quadratic.shape->edges;
    for (std::size_t c = 0; c < quadratic.cells.size(); c += width) {
      const PetscInt *node = &quadratic.cells[c];
      for (std::size_t e = 0; e < edges.size(); ++e) {
        const auto [from, to] = std::minmax(node[edges[e][0]], node[edges[e][1]]);
        all_.push_back({from, to, node[static_cast<std::size_t>(quadratic.corners()) + e]});
      }
    }
    std::sort(all_.begin(), all_.end());
  }
  /// -1: the edge is no cell's.
  [[nodiscard]] PetscInt between(PetscInt a, PetscInt b) const {
    const std::array<PetscInt, 3> wanted{std::min(a, b), std::max(a, b), 0};
    const auto found = std::lower_bound(all_.begin(), all_.end(), wanted);
    const bool is_there =
        found != all_.end() && (*found)[0] == wanted[0] && (*found)[1] == wanted[1];
    return is_there ? (*found)[2] : -1;
  }

 private:
  std::vector<std::array<PetscInt, 3>> all_;
};

/// Cuts what is in groups. Whatever has an edge that no cell has goes.
void refine(GroupedEntities &entities, const CellShape &shape, const Midpoints &midpoints) {
  GroupedEntities refined;
  const auto corners = static_cast<std::size_t>(shape.corners);
  for (std::size_t e = 0; e < entities.size(); ++e) {
    const PetscInt *corner = &entities.vertices[corners * e];
    std::vector<PetscInt> nodes(corner, corner + corners);
    for (const auto &edge : shape.edges) {
      nodes.push_back(midpoints.between(corner[edge[0]], corner[edge[1]]));
    }
    if (*std::min_element(nodes.begin(), nodes.end()) < 0) continue;
    for (const int node : children_of(shape)) {
      refined.vertices.push_back(nodes[static_cast<std::size_t>(node)]);
    }
    refined.sets.insert(refined.sets.end(), static_cast<std::size_t>(shape.children),
                        entities.sets[e]);
  }
  std::swap(entities, refined);
}

/// One entry for each cell becomes one for each of its children.
template <class Child>
void spread(std::vector<PetscInt> &entries, int children, const Child &child) {
  std::vector<PetscInt> spread;
  spread.reserve(entries.size() * static_cast<std::size_t>(children));
  for (const PetscInt entry : entries) {
    for (int k = 0; k < children; ++k) spread.push_back(child(entry, k));
  }
  entries.swap(spread);
}

}  // namespace

void refine_uniformly(CellList &mesh) {
  promote_to_quadratic(mesh);
  const int children = mesh.shape->children;
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  std::vector<PetscInt> cells;
  cells.reserve(mesh.cells.size() / width * static_cast<std::size_t>(children * mesh.corners()));
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    const PetscInt *node = &mesh.cells[c];
    for (const int k : children_of(*mesh.shape)) cells.push_back(node[k]);
    if (mesh.dimension() == 3) append_octahedron(mesh, node, cells);
  }
  if (std::any_of(mesh.groups.below.begin(), mesh.groups.below.end(),
                  [](const GroupedEntities &entities) { return entities.size() > 0; })) {
    const Midpoints midpoints(mesh);
    for (const CellShape *shape = mesh.shape->linear->facet; shape; shape = shape->facet) {
      refine(mesh.groups.below[static_cast<std::size_t>(shape->dimension)], *shape, midpoints);
    }
  }
  mesh.cells.swap(cells);
  mesh.shape = mesh.shape->linear;
  spread(mesh.groups.set_of_cell, children, [](PetscInt set, int) { return set; });
  spread(mesh.cell_number, children, [&](PetscInt cell, int k) { return children * cell + k; });
}

}  // namespace trefoil
