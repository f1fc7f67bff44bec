#include "mesh/cell_list.hpp"

#include <algorithm>
#include <numeric>

namespace trefoil {
namespace {

/// Entries of `width` numbers in another order, where there are any.
template <class Number>
void reorder(std::vector<Number> &entries, std::size_t width, const std::vector<PetscInt> &order) {
  if (entries.empty()) return;
  std::vector<Number> ordered;
  ordered.reserve(width * order.size());
  for (const PetscInt old : order) {
    const auto entry = entries.begin() + static_cast<std::ptrdiff_t>(width) * old;
    ordered.insert(ordered.end(), entry, entry + static_cast<std::ptrdiff_t>(width));
  }
  entries.swap(ordered);
}

void renumber(GroupedEntities &entities, const std::vector<PetscInt> &new_number) {
  if (entities.sets.empty()) return;
  const std::size_t corners = entities.vertices.size() / entities.size();
  GroupedEntities kept;
  for (std::size_t e = 0; e < entities.size(); ++e) {
    const auto begin = entities.vertices.begin() + static_cast<std::ptrdiff_t>(corners * e);
    std::vector<PetscInt> entity(begin, begin + static_cast<std::ptrdiff_t>(corners));
    for (PetscInt &vertex : entity) vertex = new_number[static_cast<std::size_t>(vertex)];
    if (*std::min_element(entity.begin(), entity.end()) < 0) continue;
    kept.vertices.insert(kept.vertices.end(), entity.begin(), entity.end());
    kept.sets.push_back(entities.sets[e]);
  }
  std::swap(entities, kept);
}

}  // namespace

std::string name_of_cell(const CellList &mesh, PetscInt cell) {
  const PetscInt number =
      mesh.cell_number.empty() ? cell : mesh.cell_number[static_cast<std::size_t>(cell)];
  return std::string(mesh.shape->singular) + " " + std::to_string(number + 1);
}

void number_as_in_file(CellList &mesh) {
  mesh.vertex_number.resize(static_cast<std::size_t>(mesh.vertices()));
  mesh.cell_number.resize(static_cast<std::size_t>(mesh.size()));
  std::iota(mesh.vertex_number.begin(), mesh.vertex_number.end(), 0);
  std::iota(mesh.cell_number.begin(), mesh.cell_number.end(), 0);
  mesh.file_vertices = mesh.vertices();
  mesh.file_cells = mesh.size();
}

void renumber_vertices(CellList &mesh, const std::vector<PetscInt> &new_number, PetscInt count) {
  std::vector<PetscInt> order(static_cast<std::size_t>(count));
  for (std::size_t old = 0; old < new_number.size(); ++old) {
    if (new_number[old] < 0) continue;
    order[static_cast<std::size_t>(new_number[old])] = static_cast<PetscInt>(old);
  }
  reorder(mesh.coordinates, 3, order);
  reorder(mesh.vertex_number, 1, order);
  for (PetscInt &vertex : mesh.cells) vertex = new_number[static_cast<std::size_t>(vertex)];
  for (GroupedEntities &entities : mesh.groups.below) renumber(entities, new_number);
}

void keep_cells(CellList &mesh, const std::vector<PetscInt> &order) {
  reorder(mesh.cells, static_cast<std::size_t>(mesh.nodes_per_cell()), order);
  reorder(mesh.groups.set_of_cell, 1, order);
  reorder(mesh.cell_number, 1, order);
}

}  // namespace trefoil
