#include "contact/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "contact/separation.hpp"
#include "contact/swept_boxes.hpp"

namespace trefoil::contact {
namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

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
  const PairPoints end = moved(x, points_of(vertices, sweep.step()), sweep.share());
  return separation(pair.kind, nearest.normal, x) > reach &&
         separation(pair.kind, nearest.normal, end) > reach;
}

/// @return the work of the grids; more than `most_work`: pairs are missing
double find_pairs(const Surface &surface, const Sweep &sweep, const PairSearch &search,
                  double most_work, std::vector<ContactPair> &found) {
  found.clear();
  const Box region = region_of_rank(surface, sweep, search.rank);
  const auto take = [&](const ContactPair &pair) {
    if (may_touch(surface, pair, search) && !stays_away(surface, pair, sweep, search.reach)) {
      found.push_back(pair);
    }
  };
  const auto facets = swept_facets(surface, sweep, region);
  const auto vertices = swept_vertices(surface, sweep, region);
  const PairKind with_facet = surface.dim == 3 ? PairKind::vertex_triangle : PairKind::vertex_edge;
  const auto take_facet = [&](int v, int f) {
    take({with_facet, vertices.index[v], facets.index[f]});
  };
  const double work = SortedGrid(vertices.boxes, facets.boxes).visit_pairs(take_facet, most_work);
  sort_pairs(0, surface.vertex_count(), found);
  if (surface.dim == 2 || work > most_work) return work;

  const std::size_t with_facets = found.size();
  const auto edges = swept_edges(surface, sweep, region);
  const auto take_edges = [&](int a, int b) {
    take({PairKind::edge_edge, edges.index[a], edges.index[b]});
  };
  const double more_work = SortedGrid(edges.boxes).visit_pairs(take_edges, most_work - work);
  sort_pairs(with_facets, surface.edge_count(), found);
  return work + more_work;
}

/// The mean length of the edges' relative motion in mean lengths of edges.
double motion_in_edges(const Surface &surface, std::span<const double> x,
                       std::span<const double> step) {
  double motion = 0, length = 0;
  for (const auto &[a, b] : surface.edges) {
    motion += norm(point_of(step, a) - point_of(step, b));
    length += norm(point_of(x, a) - point_of(x, b));
  }
  return length > 0 ? motion / length : 0;
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
                                         const PairSearch &search) {
  std::vector<ContactPair> pairs;
  find_pairs(surface, Sweep(x, {}, 1, search.reach / 2), search, no_limit, pairs);
  return pairs;
}

SweptCandidates find_candidates(const Surface &surface, std::span<const double> x,
                                std::span<const double> step, const PairSearch &search) {
  constexpr double work_a_primitive = 1000, times_at_rest = 4, edges_of_motion = 64;
  SweptCandidates candidates;
  if (!std::all_of(step.begin(), step.end(), [](double s) { return std::isfinite(s); })) {
    return {{}, 0};
  }
  const auto find = [&](double share, double most_work) {
    const Sweep sweep(x, step, share, search.reach / 2);
    return find_pairs(surface, sweep, search, most_work, candidates.pairs);
  };
  // Of a thousand primitives all pairs may be looked at.
  double most_work = work_a_primitive * (1000 + surface.vertex_count() + surface.edge_count());
  if (find(1, most_work) <= most_work) return candidates;
  most_work = std::max(most_work, times_at_rest * find(0, no_limit));
  const double edges = motion_in_edges(surface, x, step);
  while (candidates.share * edges > edges_of_motion) candidates.share /= 4;
  while (find(candidates.share, most_work) > most_work) candidates.share /= 4;
  return candidates;
}

}  // namespace trefoil::contact
