#include <algorithm>

#include "mesh/distribution.hpp"

namespace trefoil {
namespace {

constexpr const char *label_name = "groups";

/// Marks the points, edges and faces of the DMPlex that are in groups by the numbers of their sets.
PetscErrorCode mark_groups(DM dm, const CellShape &shape, const Groups &groups) {
  DMLabel label = nullptr;
  PetscInt first = 0;
  PetscFunctionBeginUser;
  PetscCall(DMCreateLabel(dm, label_name));
  PetscCall(DMGetLabel(dm, label_name, &label));
  PetscCall(DMPlexGetDepthStratum(dm, 0, &first, nullptr));
  for (const CellShape *facet = shape.facet; facet; facet = facet->facet) {
    const auto &entities = groups.below[static_cast<std::size_t>(facet->dimension)];
    std::vector<PetscInt> corners(static_cast<std::size_t>(facet->corners));
    for (std::size_t e = 0; e < entities.size(); ++e) {
      for (std::size_t c = 0; c < corners.size(); ++c) {
        corners[c] = first + entities.vertices[corners.size() * e + c];
      }
      PetscInt count = 0;
      const PetscInt *found = nullptr;
      PetscCall(DMPlexGetFullJoin(dm, facet->corners, corners.data(), &count, &found));
      if (count == 1) PetscCall(DMLabelSetValue(label, found[0], entities.sets[e]));
      PetscCall(DMPlexRestoreJoin(dm, facet->corners, corners.data(), &count, &found));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The local vertices of a point of the DMPlex.
PetscErrorCode append_vertices(DM dm, PetscInt point, std::vector<PetscInt> *vertices) {
  PetscInt begin = 0, end = 0, count = 0, *closure = nullptr;
  PetscFunctionBeginUser;
  PetscCall(DMPlexGetDepthStratum(dm, 0, &begin, &end));
  PetscCall(DMPlexGetTransitiveClosure(dm, point, PETSC_TRUE, &count, &closure));
  for (PetscInt k = 0; k < 2 * count; k += 2) {
    if (begin <= closure[k] && closure[k] < end) vertices->push_back(closure[k] - begin);
  }
  PetscCall(DMPlexRestoreTransitiveClosure(dm, point, PETSC_TRUE, &count, &closure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What is marked after refinement. The children of a face include edges, which are in no group of
/// faces: a set knows its groups' dimension.
PetscErrorCode take_marked(DM dm, Groups *groups) {
  DMLabel label = nullptr;
  PetscFunctionBeginUser;
  PetscCall(DMGetLabel(dm, label_name, &label));
  for (GroupedEntities &entities : groups->below) entities = {};
  for (std::size_t set = 1; set < groups->sets().size(); ++set) {
    IS marked = nullptr;
    const PetscInt *point = nullptr;
    PetscInt count = 0, begin = 0, end = 0;
    const int group = groups->sets()[set].front();
    const int dimension = groups->list()[static_cast<std::size_t>(group)].dimension;
    PetscCall(DMLabelGetStratumIS(label, static_cast<PetscInt>(set), &marked));
    if (!marked) continue;
    PetscCall(DMPlexGetDepthStratum(dm, dimension, &begin, &end));
    PetscCall(ISGetLocalSize(marked, &count));
    PetscCall(ISGetIndices(marked, &point));
    for (PetscInt k = 0; k < count; ++k) {
      if (point[k] < begin || point[k] >= end) continue;
      GroupedEntities &entities = groups->below[static_cast<std::size_t>(dimension)];
      PetscCall(append_vertices(dm, point[k], &entities.vertices));
      entities.sets.push_back(static_cast<PetscInt>(set));
    }
    PetscCall(ISRestoreIndices(marked, &point));
    PetscCall(ISDestroy(&marked));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Refinement leaves the old vertices where they were, before all new ones: the new ones come
/// behind the file's, by their global numbers.
PetscErrorCode number_new_vertices(DM dm, PetscInt highest, std::vector<PetscInt> *vertex_number) {
  IS numbering = nullptr;
  const PetscInt *number = nullptr;
  PetscInt count = 0;
  PetscFunctionBeginUser;
  PetscCall(DMPlexGetVertexNumbering(dm, &numbering));
  PetscCall(ISGetLocalSize(numbering, &count));
  PetscCall(ISGetIndices(numbering, &number));
  for (auto v = static_cast<PetscInt>(vertex_number->size()); v < count; ++v) {
    vertex_number->push_back(highest + 1 + std::max(number[v], -(number[v] + 1)));
  }
  PetscCall(ISRestoreIndices(numbering, &number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Entries a cell become entries a child, which follow each other.
template <class Child>
void spread(std::vector<PetscInt> &entries, int children, const Child &child) {
  std::vector<PetscInt> spread;
  for (const PetscInt entry : entries) {
    for (int k = 0; k < children; ++k) spread.push_back(child(entry, k));
  }
  entries.swap(spread);
}

}  // namespace

PetscErrorCode refine_distributed(PetscInt levels, Mesh *mesh) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh->dm));
  const int children = mesh->shape->children;
  DM interpolated = nullptr, refined = nullptr;
  PetscInt highest = mesh->file_vertices - 1;
  PetscFunctionBeginUser;
  for (const PetscInt number : mesh->vertex_number) highest = std::max(highest, number);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &highest, 1, MPIU_INT, MPI_MAX, comm));
  // Refinement works on a mesh with edges and faces; they are made for it and thrown away.
  PetscCall(DMPlexInterpolate(mesh->dm, &interpolated));
  PetscCall(DMDestroy(&mesh->dm));
  PetscCall(mark_groups(interpolated, *mesh->shape, mesh->groups));
  for (PetscInt level = 0; level < levels; ++level) {
    PetscCall(DMPlexSetRefinementUniform(interpolated, PETSC_TRUE));
    PetscCall(DMRefine(interpolated, comm, &refined));
    PetscCall(DMDestroy(&interpolated));
    interpolated = refined;
    mesh->edge_cut *= mesh->shape->facet->children;
    spread(mesh->groups.set_of_cell, children, [](PetscInt set, int) { return set; });
    spread(mesh->cell_number, children, [&](PetscInt cell, int k) { return children * cell + k; });
  }
  PetscCall(take_marked(interpolated, &mesh->groups));
  PetscCall(DMPlexUninterpolate(interpolated, &mesh->dm));
  PetscCall(DMPlexCopyCoordinates(interpolated, mesh->dm));
  PetscCall(DMDestroy(&interpolated));
  PetscCall(number_new_vertices(mesh->dm, highest, &mesh->vertex_number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
