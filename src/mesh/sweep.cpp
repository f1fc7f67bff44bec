#include "mesh/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trefoil {
namespace {

// The corners of a prism: 0 1 2 counterclockwise seen from the top, 3 4 5 above them.
using Prism = std::array<PetscInt, 6>;

// The same prism, turned so that its smallest vertex comes first. The turns, of which each keeps
// the orientation, are those that bring the corner of their row's number to the front.
Prism turned_to_smallest(const Prism &prism) {
  constexpr std::size_t turns[6][6] = {{0, 1, 2, 3, 4, 5}, {1, 2, 0, 4, 5, 3}, {2, 0, 1, 5, 3, 4},
                                       {3, 5, 4, 0, 2, 1}, {4, 3, 5, 1, 0, 2}, {5, 4, 3, 2, 1, 0}};
  const auto smallest = std::min_element(prism.begin(), prism.end()) - prism.begin();
  Prism turned;
  for (std::size_t corner = 0; corner < 6; ++corner)
    turned[corner] = prism[turns[smallest][corner]];
  return turned;
}

// Every quadrilateral face is cut by the diagonal through its smallest vertex, so that neighbours
// agree. J. Dompierre et al., "How to subdivide pyramids, prisms and hexahedra into tetrahedra",
// CERCA R99-78 (1999).
void append_prism(const Prism &prism, std::vector<PetscInt> &cells) {
  const Prism v = turned_to_smallest(prism);
  if (std::min(v[1], v[5]) < std::min(v[2], v[4]))
    cells.insert(cells.end(), {v[0], v[1], v[2], v[5], v[0], v[1], v[5], v[4]});
  else
    cells.insert(cells.end(), {v[0], v[1], v[2], v[4], v[0], v[4], v[2], v[5]});
  cells.insert(cells.end(), {v[0], v[4], v[5], v[3]});
}

}  // namespace

Disc::Disc(PetscInt rings) {
  points.push_back({0, 0});
  std::vector<PetscInt> inner{0};
  for (PetscInt ring = 1; ring <= rings; ++ring) {
    const double radius = static_cast<double>(ring) / rings;
    std::vector<PetscInt> outer;
    for (PetscInt point = 0; point < 6 * ring; ++point) {
      const double angle = std::numbers::pi * point / (3. * ring);
      outer.push_back(static_cast<PetscInt>(points.size()));
      points.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }

    const auto inside = [&](PetscInt point) { return inner[point % inner.size()]; };
    const auto outside = [&](PetscInt point) { return outer[point % outer.size()]; };
    for (PetscInt sixth = 0; sixth < 6; ++sixth) {
      const PetscInt from = sixth * (ring - 1), to = sixth * ring;
      for (PetscInt step = 0; step < ring; ++step)
        triangles.push_back({inside(from + step), outside(to + step), outside(to + step + 1)});
      for (PetscInt step = 0; step + 1 < ring; ++step)
        triangles.push_back({inside(from + step), outside(to + step + 1), inside(from + step + 1)});
    }
    inner = std::move(outer);
  }
}

CellList sweep(const Disc &disc, PetscInt layers, Closure closure,
               const std::function<Point(PetscInt layer, double u, double v)> &place) {
  const PetscInt layers_of_points = closure == Closure::open ? layers + 1 : layers;
  const auto points = static_cast<PetscInt>(disc.points.size());

  CellList mesh;
  mesh.coordinates.reserve(3 * disc.points.size() * static_cast<std::size_t>(layers_of_points));
  for (PetscInt layer = 0; layer < layers_of_points; ++layer)
    for (const auto &[u, v] : disc.points) {
      const Point point = place(layer, u, v);
      mesh.coordinates.insert(mesh.coordinates.end(), point.begin(), point.end());
    }

  mesh.cells.reserve(12 * disc.triangles.size() * static_cast<std::size_t>(layers));
  for (PetscInt layer = 0; layer < layers; ++layer) {
    const PetscInt bottom = layer * points;
    const PetscInt top = (layer + 1) % layers_of_points * points;
    for (const auto &[a, b, c] : disc.triangles)
      append_prism({bottom + a, bottom + b, bottom + c, top + a, top + b, top + c}, mesh.cells);
  }
  return mesh;
}

}  // namespace trefoil
