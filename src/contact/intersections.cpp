#include "contact/intersections.hpp"

#include <algorithm>

#include "contact/swept_boxes.hpp"

namespace trefoil::contact {
namespace {

bool share_vertex(const std::array<int, 2> &edge, const std::array<int, 3> &facet) {
  return std::any_of(facet.begin(), facet.end(),
                     [&](int vertex) { return vertex == edge[0] || vertex == edge[1]; });
}

/// Where segment a b meets the plane that the points of `r` lie on one side of or on: the point
/// that divides it as their distances, by volumes or areas.
Vector3 dividing_point(const Vector3 &a, const Vector3 &b, double of_a, double of_b) {
  const double t = of_a != of_b ? of_a / (of_a - of_b) : 0.5;
  return a + std::clamp(t, 0.0, 1.0) * (b - a);
}

}  // namespace

std::vector<Intersection> find_intersections(const Surface &surface, std::span<const double> x,
                                             const PairSearch &search) {
  const Sweep sweep(x, {}, 1, 0);
  const Box region = region_of_rank(surface, sweep, search.rank);
  const auto edges = swept_edges(surface, sweep, region);
  const auto facets = swept_facets(surface, sweep, region);
  std::vector<Intersection> found;
  SortedGrid(edges.boxes, facets.boxes).visit_pairs([&](int e, int f) {
    const int edge = edges.index[e], facet = facets.index[f];
    if (surface.dim == 2 && edge >= facet) return;  // the facets are the edges
    if (share_vertex(surface.edges[edge], surface.facets[facet]) ||
        !is_asked_for(surface.edge_data[edge], surface.facet_data[facet], search)) {
      return;
    }
    const Vector3 a = point_of(x, surface.edges[edge][0]), b = point_of(x, surface.edges[edge][1]);
    const Vector3 c = point_of(x, surface.facets[facet][0]);
    const Vector3 d = point_of(x, surface.facets[facet][1]);
    const Vector3 third = surface.dim == 3 ? point_of(x, surface.facets[facet][2]) : Vector3{};
    const Meeting meeting =
        surface.dim == 3 ? segment_meets_triangle(a, b, c, d, third) : segments_meet(a, b, c, d);
    if (meeting == Meeting::apart) return;
    const Vector3 normal =
        surface.dim == 3 ? cross(d - c, third - c) : cross(d - c, Vector3{0, 0, 1});
    found.push_back(
        {edge, facet, meeting, dividing_point(a, b, dot(normal, a - c), dot(normal, b - c))});
  });
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace trefoil::contact
