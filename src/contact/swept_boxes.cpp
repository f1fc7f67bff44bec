#include "contact/swept_boxes.hpp"

namespace trefoil::contact {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

bool overlap(const Box &a, const Box &b) {
  for (int i = 0; i < 3; ++i) {
    if (a.low[i] > b.high[i] || b.low[i] > a.high[i]) return false;
  }
  return true;
}

/// @param vertices  list k of the vertices of primitive k
template <class Vertices>
SweptPrimitives swept(const Sweep &sweep, const Box &region, int count, const Vertices &vertices) {
  SweptPrimitives result;
  for (int k = 0; k < count; ++k) {
    const Box box = sweep.box_of(vertices(k));
    if (!overlap(box, region)) continue;
    result.index.push_back(k);
    result.boxes.push_back(box);
  }
  return result;
}

void unite(Box &box, const Box &other) {
  for (int i = 0; i < 3; ++i) {
    box.low[i] = std::min(box.low[i], other.low[i]);
    box.high[i] = std::max(box.high[i], other.high[i]);
  }
}

}  // namespace

Sweep::Sweep(std::span<const double> x, std::span<const double> step, double share, double margin)
    : x_(x), step_(step), share_(share), margin_(margin) {
  const int count = static_cast<int>(step.size() / 3);
  for (int v = 0; v < count; ++v) mean_ = mean_ + (1.0 / count) * point_of(step, v);
}

void Sweep::extend(Box &box, int vertex) const {
  const Vector3 from = point_of(x_, vertex);
  const Vector3 to = step_.empty() ? from : from + share_ * (point_of(step_, vertex) - mean_);
  for (int i = 0; i < 3; ++i) {
    box.low[i] = std::min(box.low[i], std::min(from[i], to[i]) - margin_);
    box.high[i] = std::max(box.high[i], std::max(from[i], to[i]) + margin_);
  }
}

Box Sweep::empty_box() {
  return {{inf, inf, inf}, {-inf, -inf, -inf}};
}

SweptPrimitives swept_vertices(const Surface &surface, const Sweep &sweep, const Box &region) {
  return swept(sweep, region, surface.vertex_count(), [](int v) { return std::array<int, 1>{v}; });
}

SweptPrimitives swept_edges(const Surface &surface, const Sweep &sweep, const Box &region) {
  return swept(sweep, region, surface.edge_count(), [&](int e) { return surface.edges[e]; });
}

SweptPrimitives swept_facets(const Surface &surface, const Sweep &sweep, const Box &region) {
  return swept(sweep, region, surface.facet_count(), [&](int f) { return surface.facets[f]; });
}

Box region_of_rank(const Surface &surface, const Sweep &sweep, int rank) {
  if (rank < 0) return {{-inf, -inf, -inf}, {inf, inf, inf}};
  Box region = Sweep::empty_box();
  // The owner of a facet owns the two edges at its first vertex: they span its box.
  for (int v = 0; v < surface.vertex_count(); ++v) {
    if (surface.vertex_data[v].owner == rank) sweep.extend(region, v);
  }
  for (int e = 0; e < surface.edge_count(); ++e) {
    if (surface.edge_data[e].owner == rank) unite(region, sweep.box_of(surface.edges[e]));
  }
  return region;
}

}  // namespace trefoil::contact
