#include "mesh/repeated.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

#include "mesh/check_mesh.hpp"

namespace trefoil {
namespace {

std::vector<PetscInt> sorted(const PetscInt *nodes, int count) {
  std::vector<PetscInt> vertices(nodes, nodes + count);
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

/// The entries, `width` vertices each, sorted by the least of their first `corners` vertices: those
/// of vertex v stand from start[v] to start[v + 1].
struct ByLeastVertex {
  std::vector<std::size_t> start;
  std::vector<PetscInt> entries;

  ByLeastVertex(const std::vector<PetscInt> &vertices, int width, int corners) {
    if (vertices.empty()) return;
    const auto count = static_cast<PetscInt>(vertices.size()) / width;
    const auto least = [&](PetscInt e) {
      const PetscInt *entry = &vertices[static_cast<std::size_t>(width * e)];
      return static_cast<std::size_t>(*std::min_element(entry, entry + corners));
    };
    const auto most = *std::max_element(vertices.begin(), vertices.end());
    start.assign(static_cast<std::size_t>(most) + 2, 0);
    for (PetscInt e = 0; e < count; ++e) ++start[least(e) + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    std::vector<std::size_t> next(start);
    entries.resize(static_cast<std::size_t>(count));
    for (PetscInt e = 0; e < count; ++e) entries[next[least(e)]++] = e;
  }
};

/// For each of the entries the first one that has the same first `corners` vertices in any order;
/// itself where it is that.
std::vector<PetscInt> first_of_same(const std::vector<PetscInt> &vertices, int width, int corners) {
  ByLeastVertex all(vertices, width, corners);
  std::vector<PetscInt> first(all.entries.size());
  std::iota(first.begin(), first.end(), 0);
  const auto entry = [&](PetscInt e) { return &vertices[static_cast<std::size_t>(width * e)]; };
  const auto sum = [&](PetscInt e) {
    return std::accumulate(entry(e), entry(e) + corners, std::int64_t{0});
  };
  for (std::size_t v = 0; v + 1 < all.start.size(); ++v) {
    const auto begin = all.entries.begin() + static_cast<std::ptrdiff_t>(all.start[v]);
    const auto end = all.entries.begin() + static_cast<std::ptrdiff_t>(all.start[v + 1]);
    // The same vertices have the same sum.
    std::sort(begin, end,
              [&](PetscInt a, PetscInt b) { return std::pair(sum(a), a) < std::pair(sum(b), b); });
    for (auto one = begin; one != end; ++one) {
      for (auto other = one; other != begin && sum(*(other - 1)) == sum(*one);) {
        --other;
        if (sorted(entry(*other), corners) != sorted(entry(*one), corners)) continue;
        first[static_cast<std::size_t>(*one)] = first[static_cast<std::size_t>(*other)];
        break;
      }
    }
  }
  return first;
}

void take_once(GroupedEntities &entities, Groups &groups) {
  if (entities.size() == 0) return;
  const auto corners = static_cast<int>(entities.vertices.size() / entities.size());
  const std::vector<PetscInt> first = first_of_same(entities.vertices, corners, corners);
  GroupedEntities once;
  std::vector<std::size_t> place(first.size());
  for (std::size_t e = 0; e < first.size(); ++e) {
    const auto original = static_cast<std::size_t>(first[e]);
    if (original != e) {
      PetscInt &set = once.sets[place[original]];
      set = groups.joined(set, entities.sets[e]);
      continue;
    }
    place[e] = once.size();
    const auto begin = entities.vertices.begin() + static_cast<std::ptrdiff_t>(e) * corners;
    once.vertices.insert(once.vertices.end(), begin, begin + corners);
    once.sets.push_back(entities.sets[e]);
  }
  std::swap(entities, once);
}

/// Puts two cells with the same corners into the groups of both.
/// @return whether they are one and the same cell; a plane one either way round
bool join(CellList &mesh, PetscInt first, PetscInt second, const std::string &name) {
  const int width = mesh.nodes_per_cell();
  const auto nodes = [&](PetscInt cell) {
    return sorted(&mesh.cells[static_cast<std::size_t>(width * cell)], width);
  };
  if (nodes(first) != nodes(second))
    throw InputError(name + ": " + name_of_cell(mesh, first) + " and " +
                     name_of_cell(mesh, second) +
                     " have the same corners but different midpoints; leave one of them out");
  if (!mesh.groups.set_of_cell.empty()) {
    PetscInt &one = mesh.groups.set_of_cell[static_cast<std::size_t>(first)];
    PetscInt &other = mesh.groups.set_of_cell[static_cast<std::size_t>(second)];
    one = other = mesh.groups.joined(one, other);
  }
  return mesh.dimension() == 2 || is_turned_round(mesh, first) == is_turned_round(mesh, second);
}

}  // namespace

std::vector<PetscInt> first_with_same_corners(const CellList &mesh) {
  return first_of_same(mesh.cells, mesh.nodes_per_cell(), mesh.corners());
}

PetscInt take_once(CellList &mesh, const std::string &name) {
  for (GroupedEntities &entities : mesh.groups.below) take_once(entities, mesh.groups);
  const std::vector<PetscInt> first = first_with_same_corners(mesh);
  std::vector<PetscInt> kept;
  for (PetscInt cell = 0; cell < mesh.size(); ++cell) {
    const PetscInt original = first[static_cast<std::size_t>(cell)];
    if (original == cell || !join(mesh, original, cell, name)) kept.push_back(cell);
  }
  const PetscInt repeated = mesh.size() - static_cast<PetscInt>(kept.size());
  if (repeated > 0) keep_cells(mesh, kept);
  return repeated;
}

}  // namespace trefoil
