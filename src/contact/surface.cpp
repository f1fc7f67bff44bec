#include "contact/surface.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace trefoil::contact {
namespace {

/// What the vertices of a primitive make of it; no area yet.
template <std::size_t corners>
Primitive joined(const Surface &surface, const std::array<int, corners> &vertices) {
  Primitive all;
  all.owner = -1;
  all.role = Role::obstacle;
  for (const int v : vertices) {
    if (v < 0) continue;
    const SurfaceVertex &vertex = surface.vertices[v];
    all.body = vertex.body;
    all.role = std::min(all.role, vertex.role);
    if (all.owner < 0) all.owner = vertex.owner;
  }
  all.stiffness = std::numeric_limits<double>::infinity();
  return all;
}

/// Gives a share of a facet to a vertex, an edge or itself.
void add_share(Primitive &to, double area, double stiffness) {
  to.area += area;
  to.stiffness = std::min(to.stiffness, stiffness);
}

double rest_area(const Surface &surface, const std::array<int, 3> &facet) {
  const Vector3 &a = surface.vertices[facet[0]].rest;
  const Vector3 first = surface.vertices[facet[1]].rest - a;
  if (surface.dim == 2) return norm(first);
  return norm(cross(first, surface.vertices[facet[2]].rest - a)) / 2;
}

std::array<int, 2> edge_opposite(const std::array<int, 3> &facet, int corner) {
  return {facet[corner == 0 ? 1 : 0], facet[corner == 2 ? 1 : 2]};
}

/// The edges of sorted facets, each once, sorted.
std::vector<std::array<int, 2>> edges_of(const Surface &surface) {
  std::vector<std::array<int, 2>> edges;
  edges.reserve(surface.facets.size() * 3);
  for (const auto &facet : surface.facets) {
    if (surface.dim == 2) {
      edges.push_back({facet[0], facet[1]});
    } else {
      for (int corner = 0; corner < 3; ++corner) edges.push_back(edge_opposite(facet, corner));
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace

std::vector<double> Surface::rest_positions() const {
  std::vector<double> x;
  x.reserve(3 * vertices.size());
  for (const SurfaceVertex &vertex : vertices) {
    for (int i = 0; i < 3; ++i) x.push_back(vertex.rest[i]);
  }
  return x;
}

Surface make_surface(int dim, std::vector<SurfaceVertex> vertices,
                     std::vector<SurfaceFacet> facets) {
  Surface surface;
  surface.dim = dim;
  surface.vertices = std::move(vertices);
  for (SurfaceFacet &facet : facets) {
    std::sort(facet.vertices.begin(), facet.vertices.begin() + dim);
  }
  std::sort(facets.begin(), facets.end(),
            [](const SurfaceFacet &a, const SurfaceFacet &b) { return a.vertices < b.vertices; });
  for (const SurfaceFacet &facet : facets) surface.facets.push_back(facet.vertices);
  surface.edges = edges_of(surface);

  for (int v = 0; v < surface.vertex_count(); ++v) {
    surface.vertex_data.push_back(joined(surface, std::array<int, 1>{v}));
  }
  for (const auto &edge : surface.edges) surface.edge_data.push_back(joined(surface, edge));
  for (std::size_t f = 0; f < facets.size(); ++f) {
    const auto &corners = surface.facets[f];
    const double area = rest_area(surface, corners), stiffness = facets[f].stiffness;
    surface.facet_data.push_back(joined(surface, corners));
    add_share(surface.facet_data.back(), area, stiffness);
    for (int corner = 0; corner < dim; ++corner) {
      add_share(surface.vertex_data[corners[corner]], area / dim, stiffness);
      if (dim == 2) continue;
      const auto edge = std::lower_bound(surface.edges.begin(), surface.edges.end(),
                                         edge_opposite(corners, corner));
      add_share(surface.edge_data[edge - surface.edges.begin()], area / 3, stiffness);
    }
  }
  if (dim == 2) surface.edge_data = surface.facet_data;
  return surface;
}

double body_diagonal(const Surface &surface) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  Vector3 low{inf, inf, inf}, high{-inf, -inf, -inf};
  for (const SurfaceVertex &vertex : surface.vertices) {
    if (vertex.role == Role::obstacle) continue;
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], vertex.rest[i]);
      high[i] = std::max(high[i], vertex.rest[i]);
    }
  }
  return low.x <= high.x ? norm(high - low) : 0;
}

}  // namespace trefoil::contact
