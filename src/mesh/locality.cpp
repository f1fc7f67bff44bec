#include "mesh/locality.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>

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

/// The place of each vertex on Morton's curve: the bits of its coordinates in turn.
std::vector<std::uint64_t> curve_places(const CellList &mesh) {
  constexpr double steps = 0x1fffff;
  std::array<double, 3> least, most;
  least.fill(std::numeric_limits<double>::infinity());
  most.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < mesh.coordinates.size(); ++i) {
    least[i % 3] = std::min(least[i % 3], mesh.coordinates[i]);
    most[i % 3] = std::max(most[i % 3], mesh.coordinates[i]);
  }
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i) size = std::max(size, most[i] - least[i]);
  std::vector<std::uint64_t> places(mesh.coordinates.size() / 3, 0);
  for (std::size_t i = 0; i < mesh.coordinates.size() && size > 0; ++i) {
    const double part = (mesh.coordinates[i] - least[i % 3]) / size;
    places[i / 3] |= spread(static_cast<std::uint64_t>(steps * part)) << i % 3;
  }
  return places;
}

}  // namespace

void order_along_curve(CellList &mesh) {
  const std::vector<std::uint64_t> place = curve_places(mesh);
  std::vector<PetscInt> order(place.size()), number(place.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](PetscInt a, PetscInt b) {
    return place[static_cast<std::size_t>(a)] < place[static_cast<std::size_t>(b)];
  });
  std::vector<double> coordinates;
  coordinates.reserve(mesh.coordinates.size());
  for (std::size_t v = 0; v < order.size(); ++v) {
    const auto old = mesh.coordinates.begin() + 3 * static_cast<std::ptrdiff_t>(order[v]);
    coordinates.insert(coordinates.end(), old, old + 3);
    number[static_cast<std::size_t>(order[v])] = static_cast<PetscInt>(v);
  }
  mesh.coordinates.swap(coordinates);

  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  const auto corners = static_cast<std::size_t>(mesh.corners());
  std::vector<std::pair<std::int64_t, std::size_t>> cells;  // by the sum of their corners' numbers
  cells.reserve(mesh.cells.size() / width);
  for (PetscInt &vertex : mesh.cells) vertex = number[static_cast<std::size_t>(vertex)];
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    std::int64_t sum = 0;
    for (std::size_t a = 0; a < corners; ++a) sum += mesh.cells[c + a];
    cells.emplace_back(sum, c);
  }
  std::stable_sort(cells.begin(), cells.end(),
                   [](const auto &a, const auto &b) { return a.first < b.first; });
  std::vector<PetscInt> sorted, groups;
  sorted.reserve(mesh.cells.size());
  for (const auto &entry : cells) {
    const auto cell = mesh.cells.begin() + static_cast<std::ptrdiff_t>(entry.second);
    if (!mesh.groups.empty()) groups.push_back(mesh.groups[entry.second / width]);
    sorted.insert(sorted.end(), cell, cell + static_cast<std::ptrdiff_t>(width));
  }
  mesh.cells.swap(sorted);
  mesh.groups.swap(groups);
}

}  // namespace trefoil
