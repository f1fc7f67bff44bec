#include "mesh/locality.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <set>

namespace trefoil {
namespace {

/// Spreads the lowest 21 bits of a number to every third bit.
std::uint64_t spread(std::uint64_t bits) {
  bits &= 0x1fffff;
  bits = (bits | bits << 32) & 0x1f00000000ffff;
  bits = (bits | bits << 16) & 0x1f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  bits = (bits | bits << 2) & 0x1249249249249249;
  return bits;
}

/// Morton's curve through the box of the vertices: the bits of a point's coordinates in turn.
class Curve {
 public:
  explicit Curve(const CellList &mesh) {
    std::array<double, 3> most;
    least_.fill(std::numeric_limits<double>::infinity());
    most.fill(-std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < mesh.coordinates.size(); ++i) {
      least_[i % 3] = std::min(least_[i % 3], mesh.coordinates[i]);
      most[i % 3] = std::max(most[i % 3], mesh.coordinates[i]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      size_ = std::max(size_, most[i] - least_[i]);
      diagonal_ = std::hypot(diagonal_, most[i] - least_[i]);
    }
  }

  [[nodiscard]] double diagonal() const { return diagonal_; }
  /// The point's place on the curve; points outside of the box are moved into it.
  [[nodiscard]] std::uint64_t place(const std::array<double, 3> &point) const {
    constexpr double steps = 0x1fffff;
    std::uint64_t place = 0;
    for (std::size_t i = 0; i < 3 && size_ > 0; ++i) {
      const double part = std::clamp((point[i] - least_[i]) / size_, 0., 1.);
      place |= spread(static_cast<std::uint64_t>(steps * part)) << i;
    }
    return place;
  }

 private:
  std::array<double, 3> least_{};
  double size_ = 0, diagonal_ = 0;
};

std::array<double, 3> position(const CellList &mesh, std::size_t vertex) {
  const double *p = &mesh.coordinates[3 * vertex];
  return {p[0], p[1], p[2]};
}

/// The place of each vertex on the curve.
std::vector<std::uint64_t> curve_places(const CellList &mesh, const Curve &curve) {
  std::vector<std::uint64_t> places(mesh.coordinates.size() / 3);
  for (std::size_t v = 0; v < places.size(); ++v) places[v] = curve.place(position(mesh, v));
  return places;
}

bool is_near(const CellList &mesh, std::size_t a, std::size_t b, double distance) {
  const std::array<double, 3> p = position(mesh, a), q = position(mesh, b);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) <= distance;
}

}  // namespace

void order_along_curve(CellList &mesh) {
  const std::vector<std::uint64_t> place = curve_places(mesh, Curve(mesh));
  std::vector<PetscInt> order(place.size()), number(place.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](PetscInt a, PetscInt b) {
    return place[static_cast<std::size_t>(a)] < place[static_cast<std::size_t>(b)];
  });
  for (std::size_t v = 0; v < order.size(); ++v)
    number[static_cast<std::size_t>(order[v])] = static_cast<PetscInt>(v);
  renumber_vertices(mesh, number, mesh.vertices());

  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  std::vector<std::int64_t> sums;  // of the numbers of each cell's corners
  sums.reserve(static_cast<std::size_t>(mesh.size()));
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    const auto corner = mesh.cells.begin() + static_cast<std::ptrdiff_t>(c);
    sums.push_back(std::accumulate(corner, corner + mesh.corners(), std::int64_t{0}));
  }
  std::vector<PetscInt> cells(sums.size());
  std::iota(cells.begin(), cells.end(), 0);
  std::stable_sort(cells.begin(), cells.end(), [&](PetscInt a, PetscInt b) {
    return sums[static_cast<std::size_t>(a)] < sums[static_cast<std::size_t>(b)];
  });
  keep_cells(mesh, cells);
}

PetscInt coincident_vertices(const CellList &mesh) {
  constexpr double tolerance = 1e-9;
  const Curve curve(mesh);
  const std::vector<std::uint64_t> places = curve_places(mesh, curve);
  const double distance = tolerance * curve.diagonal();
  const auto moved = [&](std::size_t vertex, int octant) {
    std::array<double, 3> point = position(mesh, vertex);
    for (std::size_t i = 0; i < 3; ++i) point[i] += octant >> i & 1 ? distance : -distance;
    return curve.place(point);
  };
  const auto one_before_is_at = [&](std::uint64_t place, std::size_t v) {
    auto u = static_cast<std::size_t>(std::lower_bound(places.begin(), places.end(), place) -
                                      places.begin());
    while (u < v && places[u] == place && !is_near(mesh, u, v, distance)) ++u;
    return u < v && places[u] == place;
  };
  PetscInt count = 0;
  for (std::size_t v = 0; v < places.size(); ++v) {
    std::set<std::uint64_t> near{places[v]};
    // Few vertices are so near to the border of a cell of the curve's grid that others, as near,
    // are at another place on it.
    if (moved(v, 0) != places[v] || moved(v, 7) != places[v]) {
      for (int octant = 0; octant < 8; ++octant) near.insert(moved(v, octant));
    }
    count += std::any_of(near.begin(), near.end(),
                         [&](std::uint64_t place) { return one_before_is_at(place, v); });
  }
  return count;
}

}  // namespace trefoil
