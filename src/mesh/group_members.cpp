#include "mesh/group_members.hpp"

#include <petscsf.h>

#include <algorithm>
#include <set>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

int dimension_of(const Mesh &mesh, int group) {
  return mesh.groups.list()[static_cast<std::size_t>(group)].dimension;
}

/// The corners, ascending, of the edges or faces that this rank has in a group.
std::set<std::vector<PetscInt>> members(const Mesh &mesh, int group) {
  const auto &entities = mesh.groups.below[static_cast<std::size_t>(dimension_of(mesh, group))];
  const std::vector<char> in_group = mesh.groups.sets_with(group);
  const std::size_t corners = entities.size() ? entities.vertices.size() / entities.size() : 0;
  std::set<std::vector<PetscInt>> found;
  for (std::size_t e = 0; e < entities.size(); ++e) {
    if (!in_group[static_cast<std::size_t>(entities.sets[e])]) continue;
    const auto begin = entities.vertices.begin() + static_cast<std::ptrdiff_t>(corners * e);
    std::vector<PetscInt> entity(begin, begin + static_cast<std::ptrdiff_t>(corners));
    std::sort(entity.begin(), entity.end());
    found.insert(std::move(entity));
  }
  return found;
}

/// Marks the midpoints of this rank's quadratic cells that are on edges between two of an entity's
/// corners.
void mark_midpoints(const Mesh &mesh, const std::set<std::vector<PetscInt>> &entities,
                    std::vector<char> *taken) {
  std::set<std::pair<PetscInt, PetscInt>> edges;
  for (const std::vector<PetscInt> &entity : entities) {
    for (std::size_t a = 0; a < entity.size(); ++a) {
      for (std::size_t b = a + 1; b < entity.size(); ++b) edges.emplace(entity[a], entity[b]);
    }
  }
  const auto &edges_of_cell = mesh.shape->edges;
  for (std::size_t c = 0; c < mesh.cells.size();
       c += static_cast<std::size_t>(mesh.nodes_per_cell())) {
    const PetscInt *node = &mesh.cells[c];
    for (std::size_t e = 0; e < edges_of_cell.size(); ++e) {
      const PetscInt a = node[edges_of_cell[e][0]], b = node[edges_of_cell[e][1]];
      if (edges.count(std::minmax(a, b))) {
        (*taken)[static_cast<std::size_t>(
            node[static_cast<std::size_t>(mesh.shape->corners) + e])] = 1;
      }
    }
  }
}

/// What one rank takes all ranks take that have the vertex. Collective.
PetscErrorCode share_marks(const Mesh &mesh, std::vector<char> *taken) {
  PetscSF points = nullptr;
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(DMGetPointSF(mesh.dm, &points));
  PetscCall(DMPlexGetChart(mesh.dm, &begin, &end));
  const auto first = static_cast<std::ptrdiff_t>(mesh.first_vertex - begin);
  std::vector<PetscInt> mine(static_cast<std::size_t>(end - begin), 0);
  std::copy(taken->begin(), taken->end(), mine.begin() + first);
  std::vector<PetscInt> all(mine);
  PetscCall(PetscSFReduceBegin(points, MPIU_INT, mine.data(), all.data(), MPI_MAX));
  PetscCall(PetscSFReduceEnd(points, MPIU_INT, mine.data(), all.data(), MPI_MAX));
  mine = all;
  PetscCall(PetscSFBcastBegin(points, MPIU_INT, all.data(), mine.data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(points, MPIU_INT, all.data(), mine.data(), MPI_REPLACE));
  std::copy_n(mine.begin() + first, taken->size(), taken->begin());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

std::vector<char> cells_of_group(const Mesh &mesh, int group) {
  std::vector<char> taken(static_cast<std::size_t>(mesh.local_cells()), 0);
  const std::vector<char> in_group = mesh.groups.sets_with(group);
  const std::vector<PetscInt> &sets = mesh.groups.set_of_cell;
  std::transform(sets.begin(), sets.end(), taken.begin(),
                 [&](PetscInt set) { return in_group[static_cast<std::size_t>(set)]; });
  return taken;
}

PetscErrorCode vertices_of_group(const Mesh &mesh, int group, std::vector<char> *taken) {
  PetscFunctionBeginUser;
  taken->assign(static_cast<std::size_t>(mesh.local_vertices()), 0);
  if (dimension_of(mesh, group) == mesh.dimension()) {
    const std::vector<char> cells = cells_of_group(mesh, group);
    const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
    for (std::size_t k = 0; k < mesh.cells.size(); ++k) {
      if (cells[k / width]) (*taken)[static_cast<std::size_t>(mesh.cells[k])] = 1;
    }
  } else {
    const std::set<std::vector<PetscInt>> entities = members(mesh, group);
    for (const std::vector<PetscInt> &entity : entities) {
      for (const PetscInt vertex : entity) (*taken)[static_cast<std::size_t>(vertex)] = 1;
    }
    if (is_quadratic(*mesh.shape)) mark_midpoints(mesh, entities, taken);
  }
  PetscCall(share_marks(mesh, taken));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode facets_of_group(const Mesh &mesh, int group, std::vector<Facet> *facets,
                               PetscInt *inner) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  std::vector<char> taken;
  std::vector<Facet> candidates;
  PetscFunctionBeginUser;
  PetscCheck(dimension_of(mesh, group) == mesh.dimension() - 1, comm, PETSC_ERR_ARG_WRONG,
             "a group of facets has one dimension less than the cells");
  // A facet of the surface is in one cell, and it is the rank of that cell that has it in its
  // group.
  PetscCall(vertices_of_group(mesh, group, &taken));
  const auto may_be_in_it = [&](const Facet &facet) {
    return std::all_of(facet.begin(), facet.begin() + facet.corners(),
                       [&](PetscInt v) { return taken[static_cast<std::size_t>(v)]; });
  };
  PetscCall(boundary_facets(mesh, may_be_in_it, &candidates));
  const std::set<std::vector<PetscInt>> entities = members(mesh, group);
  facets->clear();
  for (const Facet &facet : candidates) {
    std::vector<PetscInt> corners(facet.begin(), facet.begin() + facet.corners());
    std::sort(corners.begin(), corners.end());
    if (entities.count(corners)) facets->push_back(facet);
  }
  *inner = static_cast<PetscInt>(entities.size() - facets->size());
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, inner, 1, MPIU_INT, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
