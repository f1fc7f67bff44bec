#include "contact/candidates.hpp"

#include <algorithm>
#include <numeric>

#include "contact/separation.hpp"
#include "contact/swept_boxes.hpp"

namespace trefoil::contact {
namespace {

bool shares_vertex(const std::array<int, 4> &vertices, int firsts) {
  for (int a = 0; a < firsts; ++a) {
    for (int b = firsts; b < 4; ++b) {
      if (vertices[a] == vertices[b]) return true;
    }
  }
  return false;
}

/// Sorts pairs of one kind, from `begin` on, of which `firsts` primitives may be the first: by
/// counting, then the few of each first one.
void sort_pairs(std::size_t begin, int firsts, std::vector<ContactPair> &pairs) {
  std::vector<std::size_t> place(firsts + 1);
  for (std::size_t k = begin; k < pairs.size(); ++k) ++place[pairs[k].first + 1];
  std::partial_sum(place.begin(), place.end(), place.begin());
  std::vector<ContactPair> sorted(pairs.size() - begin);
  std::vector<std::size_t> next = place;
  for (std::size_t k = begin; k < pairs.size(); ++k) sorted[next[pairs[k].first]++] = pairs[k];
  const auto from = sorted.begin();
  for (int first = 0; first < firsts; ++first) {
    std::sort(from + static_cast<std::ptrdiff_t>(place[first]),
              from + static_cast<std::ptrdiff_t>(place[first + 1]));
  }
  std::copy(sorted.begin(), sorted.end(), pairs.begin() + static_cast<std::ptrdiff_t>(begin));
}

/// Whether the plane between the nearest points, held still, keeps the two apart by more than the
/// reach: its distance to each pair of corners changes linearly along the step.
bool stays_away(const Surface &surface, const ContactPair &pair, const Sweep &sweep, double reach) {
  const auto vertices = vertices_of(surface, pair);
  const PairPoints x = points_of(vertices, sweep.x());
  const NearestPoints nearest = nearest_points(pair.kind, x);
  if (!(nearest.distance > reach)) return false;
  if (sweep.step().empty()) return true;
  const PairPoints step = points_of(vertices, sweep.step());
  return separation(pair.kind, nearest.normal, x) > reach &&
         separation(pair.kind, nearest.normal, moved(x, step, 1)) > reach;
}

}  // namespace

const Primitive &first_of(const Surface &surface, const ContactPair &pair) {
  return pair.kind == PairKind::edge_edge ? surface.edge_data[pair.first]
                                          : surface.vertex_data[pair.first];
}

const Primitive &second_of(const Surface &surface, const ContactPair &pair) {
  return pair.kind == PairKind::edge_edge ? surface.edge_data[pair.second]
                                          : surface.facet_data[pair.second];
}

std::array<int, 4> vertices_of(const Surface &surface, const ContactPair &pair) {
  if (pair.kind == PairKind::edge_edge) {
    const auto &a = surface.edges[pair.first], &b = surface.edges[pair.second];
    return {a[0], a[1], b[0], b[1]};
  }
  const auto &facet = surface.facets[pair.second];
  return {pair.first, facet[0], facet[1], facet[2]};
}

PairPoints points_of(const std::array<int, 4> &vertices, std::span<const double> x) {
  PairPoints points;
  for (int a = 0; a < 4; ++a) {
    if (vertices[a] >= 0) points[a] = point_of(x, vertices[a]);
  }
  return points;
}

bool is_asked_for(const Primitive &a, const Primitive &b, const PairSearch &search) {
  return joint_role(a, b) <= (search.prescribed ? Role::prescribed : Role::free) &&
         (search.self_contact || a.body != b.body) &&
         (search.rank < 0 || owner_of_pair(a, b) == search.rank);
}

bool may_touch(const Surface &surface, const ContactPair &pair, const PairSearch &search) {
  return !shares_vertex(vertices_of(surface, pair), points_of_first(pair.kind)) &&
         is_asked_for(first_of(surface, pair), second_of(surface, pair), search);
}

std::vector<ContactPair> find_candidates(const Surface &surface, std::span<const double> x,
                                         std::span<const double> step, const PairSearch &search) {
  const Sweep sweep(x, step, search.reach / 2);
  const Box region = region_of_rank(surface, sweep, search.rank);
  std::vector<ContactPair> found;
  const auto take = [&](const ContactPair &pair) {
    if (may_touch(surface, pair, search) && !stays_away(surface, pair, sweep, search.reach)) {
      found.push_back(pair);
    }
  };
  const auto facets = swept_facets(surface, sweep, region);
  const auto vertices = swept_vertices(surface, sweep, region);
  const PairKind with_facet = surface.dim == 3 ? PairKind::vertex_triangle : PairKind::vertex_edge;
  SortedGrid(vertices.boxes, facets.boxes).visit_pairs([&](int v, int f) {
    take({with_facet, vertices.index[v], facets.index[f]});
  });
  sort_pairs(0, surface.vertex_count(), found);
  if (surface.dim == 3) {
    const std::size_t with_facets = found.size();
    const auto edges = swept_edges(surface, sweep, region);
    SortedGrid(edges.boxes).visit_pairs([&](int a, int b) {
      take({PairKind::edge_edge, edges.index[a], edges.index[b]});
    });
    sort_pairs(with_facets, surface.edge_count(), found);
  }
  return found;
}

}  // namespace trefoil::contact
