#include <petscsf.h>

#include <algorithm>
#include <limits>

#include "mesh/distribution.hpp"

namespace trefoil {
namespace {

PetscErrorCode take_coordinates(Mesh *mesh) {
  Vec coordinates = nullptr;
  const PetscScalar *values = nullptr;
  PetscInt size = 0;
  PetscFunctionBeginUser;
  PetscCall(DMGetCoordinatesLocal(mesh->dm, &coordinates));
  PetscCall(VecGetLocalSize(coordinates, &size));
  PetscCall(VecGetArrayRead(coordinates, &values));
  mesh->coordinates.assign(values, values + size);
  PetscCall(VecRestoreArrayRead(coordinates, &values));

  std::array<double, 6> box;  // minima, then negated maxima, so that one reduction serves both
  box.fill(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < mesh->coordinates.size(); ++i) {
    box[i % 3] = std::min(box[i % 3], mesh->coordinates[i]);
    box[3 + i % 3] = std::min(box[3 + i % 3], -mesh->coordinates[i]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, box.data(), 6, MPI_DOUBLE, MPI_MIN,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh->dm))));
  for (std::size_t i = 0; i < 3; ++i) {
    mesh->box_min[i] = box[i];
    mesh->box_max[i] = -box[3 + i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode take_vertex_numbers(Mesh *mesh) {
  IS numbering = nullptr;
  const PetscInt *number = nullptr;
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(DMPlexGetDepthStratum(mesh->dm, 0, &begin, &end));
  mesh->first_vertex = begin;
  PetscCall(DMPlexGetVertexNumbering(mesh->dm, &numbering));
  PetscCall(ISGetIndices(numbering, &number));
  for (PetscInt v = 0; v < end - begin; ++v) {
    // DMPlex marks the vertices of other ranks by -(number + 1).
    mesh->owned.push_back(number[v] >= 0);
    mesh->global_vertex.push_back(number[v] >= 0 ? number[v] : -(number[v] + 1));
  }
  PetscCall(ISRestoreIndices(numbering, &number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Corners as the DMPlex has them, which for a mesh from a cell list is the order of the file.
PetscErrorCode take_cells(Mesh *mesh) {
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(DMPlexGetHeightStratum(mesh->dm, 0, &begin, &end));
  mesh->cells.reserve(static_cast<std::size_t>(mesh->nodes_per_cell() * (end - begin)));
  for (PetscInt c = begin; c < end; ++c) {
    const PetscInt *corner = nullptr;
    PetscCall(DMPlexGetCone(mesh->dm, c, &corner));
    for (int a = 0; a < mesh->nodes_per_cell(); ++a)
      mesh->cells.push_back(corner[a] - mesh->first_vertex);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// How many vertices are corners of a cell, which the owner of a vertex may have to be told.
PetscErrorCode count_corners(MPI_Comm comm, Mesh *mesh) {
  PetscSF points = nullptr;
  PetscInt begin = 0, end = 0, corners = 0;
  PetscFunctionBeginUser;
  PetscCall(DMGetPointSF(mesh->dm, &points));
  PetscCall(DMPlexGetChart(mesh->dm, &begin, &end));
  std::vector<PetscInt> seen(static_cast<std::size_t>(end - begin), 0);
  const auto width = static_cast<std::size_t>(mesh->nodes_per_cell());
  for (std::size_t k = 0; k < mesh->cells.size(); ++k) {
    if (static_cast<int>(k % width) >= mesh->shape->corners) continue;
    seen[static_cast<std::size_t>(mesh->first_vertex + mesh->cells[k])] = 1;
  }
  std::vector<PetscInt> at_owner(seen);
  PetscCall(PetscSFReduceBegin(points, MPIU_INT, seen.data(), at_owner.data(), MPI_MAX));
  PetscCall(PetscSFReduceEnd(points, MPIU_INT, seen.data(), at_owner.data(), MPI_MAX));
  for (std::size_t v = 0; v < mesh->owned.size(); ++v) {
    corners += mesh->owned[v] && at_owner[static_cast<std::size_t>(mesh->first_vertex) + v];
  }
  PetscCallMPI(MPI_Allreduce(&corners, &mesh->total_corners, 1, MPIU_INT, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode count_totals(MPI_Comm comm, Mesh *mesh) {
  PetscMPIInt ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscInt mine[2] = {mesh->local_cells(),
                      static_cast<PetscInt>(std::count(mesh->owned.begin(), mesh->owned.end(), 1))};
  PetscInt totals[2] = {0, 0}, largest = 0;
  PetscCallMPI(MPI_Allreduce(mine, totals, 2, MPIU_INT, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(mine, &largest, 1, MPIU_INT, MPI_MAX, comm));
  mesh->total_cells = totals[0];
  mesh->total_vertices = totals[1];
  PetscCall(count_corners(comm, mesh));
  mesh->imbalance = static_cast<double>(largest) * ranks / static_cast<double>(totals[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode take_arrays(Mesh *mesh) {
  PetscFunctionBeginUser;
  PetscCall(take_vertex_numbers(mesh));
  PetscCall(take_coordinates(mesh));
  PetscCall(take_cells(mesh));
  PetscCall(count_totals(PetscObjectComm(reinterpret_cast<PetscObject>(mesh->dm)), mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
