#include "mesh/quadratic.hpp"

#include <algorithm>
#include <array>

#include "element/isoparametric_element.hpp"

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
  PetscInt vertex = mesh.vertices() - 1;
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

void refine_uniformly(CellList &mesh) {
  promote_to_quadratic(mesh);
  std::vector<PetscInt> cells;
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  cells.reserve(mesh.cells.size() / width *
                static_cast<std::size_t>(mesh.shape->children * mesh.corners()));
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    const PetscInt *v = &mesh.cells[c];
    if (mesh.dimension() == 2) {
      cells.insert(cells.end(),
                   {v[0], v[3], v[5], v[3], v[1], v[4], v[5], v[4], v[2], v[3], v[4], v[5]});
    } else {
      cells.insert(cells.end(), {v[0], v[4], v[6], v[7], v[4], v[1], v[5], v[8], v[6], v[5], v[2],
                                 v[9], v[7], v[8], v[9], v[3]});
      append_octahedron(mesh, v, cells);
    }
  }
  mesh.cells.swap(cells);
  mesh.shape = mesh.shape->linear;
  std::vector<PetscInt> groups;  // a cell's children follow each other
  for (const PetscInt group : mesh.groups)
    groups.insert(groups.end(), static_cast<std::size_t>(mesh.shape->children), group);
  mesh.groups.swap(groups);
}

void check_curved_cells(const CellList &mesh, const std::string &name) {
  if (!is_quadratic(*mesh.shape)) return;
  const ReferenceElement &reference = reference_element(mesh.dimension(), mesh.nodes_per_cell());
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  std::vector<double> positions(3 * width);
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    for (std::size_t k = 0; k < 3 * width; ++k) {
      const auto vertex = static_cast<std::size_t>(mesh.cells[c + k / 3]);
      positions[k] = mesh.coordinates[3 * vertex + k % 3];
    }
    const IsoparametricElement element(reference, positions.data());
    if (element.least_jacobian() > 0) continue;
    throw InputError(name + ": " + mesh.shape->singular + " " + std::to_string(c / width + 1) +
                     " is bent so far that its Jacobian determinant is not positive at a "
                     "quadrature point; mend the mesh, or use its corners only with -order 1");
  }
}

}  // namespace trefoil
