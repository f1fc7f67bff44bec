#include "mesh/repeated.hpp"

#include <algorithm>
#include <cstdint>

#include "mesh/check_mesh.hpp"

namespace trefoil {
namespace {

std::vector<PetscInt> sorted(const PetscInt *nodes, int count) {
  std::vector<PetscInt> vertices(nodes, nodes + count);
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

/// A number that depends on which vertices there are, not on their order; those of different
/// vertices are hardly ever the same.
std::uint64_t hash(const PetscInt *nodes, int count) {
  std::uint64_t sum = 0;
  for (int k = 0; k < count; ++k) {
    std::uint64_t bits = static_cast<std::uint64_t>(nodes[k]) + 0x9e3779b97f4a7c15U;
    bits = (bits ^ bits >> 30) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ bits >> 27) * 0x94d049bb133111ebU;
    sum += bits ^ bits >> 31;
  }
  return sum;
}

/// For each of the entries, `width` vertices each, the first one that has the same first `corners`
/// vertices in any order; itself where it is that.
std::vector<PetscInt> first_of_same(const std::vector<PetscInt> &vertices, int width, int corners) {
  std::vector<std::pair<std::uint64_t, PetscInt>> order;
  order.reserve(vertices.size() / static_cast<std::size_t>(width));
  const auto entry = [&](PetscInt e) { return &vertices[static_cast<std::size_t>(width * e)]; };
  for (PetscInt e = 0; e < static_cast<PetscInt>(vertices.size()) / width; ++e) {
    order.emplace_back(hash(entry(e), corners), e);
  }
  std::sort(order.begin(), order.end());
  std::vector<PetscInt> first(order.size());
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && order[end].first == order[begin].first) ++end;
    for (std::size_t k = begin; k < end; ++k) {
      const PetscInt e = order[k].second;
      const auto same = [&](const auto &other) {
        return sorted(entry(other.second), corners) == sorted(entry(e), corners);
      };
      const auto itself = order.begin() + static_cast<std::ptrdiff_t>(k);
      const auto found =
          std::find_if(order.begin() + static_cast<std::ptrdiff_t>(begin), itself, same);
      first[static_cast<std::size_t>(e)] = found->second;
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
