#include <petscsf.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <sstream>

#include "mesh/mesh.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Tells all ranks the shape of the cells, which the first one knows.
PetscErrorCode tell_shape(MPI_Comm comm, const CellShape &shape, Mesh *mesh) {
  const auto shapes = mesh_shapes();
  auto row = static_cast<int>(std::find(shapes.begin(), shapes.end(), &shape) - shapes.begin());
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(&row, 1, MPI_INT, 0, comm));
  mesh->shape = shapes[static_cast<std::size_t>(row)];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// This rank's cells (global vertex numbers) and its even share of the vertices.
struct Share {
  std::vector<PetscInt> cells, groups;
  std::vector<double> coordinates;
};

/// Sends rank r `counts[r]` consecutive entries of `all`, which only the first rank has.
template <class T>
PetscErrorCode scatter(MPI_Comm comm, MPI_Datatype type, const std::vector<T> &all,
                       const std::vector<PetscMPIInt> &counts, std::vector<T> *mine) {
  PetscMPIInt rank = 0, count = 0;
  std::vector<PetscMPIInt> offsets(counts.size(), 0);
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  PetscCallMPI(MPI_Scatter(counts.data(), 1, MPI_INT, &count, 1, MPI_INT, 0, comm));
  mine->resize(static_cast<std::size_t>(count));
  PetscCallMPI(MPI_Scatterv(all.data(), counts.data(), offsets.data(), type, mine->data(), count,
                            type, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode send_shares(MPI_Comm comm, const CellList &whole, const Partition &partition,
                           Share *share) {
  PetscMPIInt rank = 0, ranks = 0;
  const int width = whole.nodes_per_cell();
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  const auto parts = static_cast<std::size_t>(ranks);
  std::vector<PetscMPIInt> corner_counts(parts, 0), coordinate_counts(parts, 0);
  std::vector<PetscMPIInt> group_counts(parts, 0);
  std::vector<PetscInt> sorted, groups(whole.groups.size());
  if (rank == 0) {
    for (PetscInt p : partition.rank_of_cell) {
      corner_counts[static_cast<std::size_t>(p)] += width;
    }
    std::vector<std::size_t> next(parts, 0);
    std::exclusive_scan(corner_counts.begin(), corner_counts.end(), next.begin(), std::size_t{0});
    sorted.resize(whole.cells.size());
    auto corner = whole.cells.begin();
    auto group = whole.groups.begin();
    for (PetscInt p : partition.rank_of_cell) {
      auto &position = next[static_cast<std::size_t>(p)];
      if (!groups.empty()) {
        groups[position / static_cast<std::size_t>(width)] = *group++;
        ++group_counts[static_cast<std::size_t>(p)];
      }
      std::copy_n(corner, width, sorted.begin() + static_cast<std::ptrdiff_t>(position));
      position += static_cast<std::size_t>(width);
      corner += width;
    }
    const PetscInt vertices = whole.vertices();
    for (PetscInt p = 0; p < ranks; ++p) {
      coordinate_counts[static_cast<std::size_t>(p)] =
          3 * (vertices / ranks + (p < vertices % ranks));
    }
  }
  PetscCall(scatter(comm, MPIU_INT, sorted, corner_counts, &share->cells));
  PetscCall(scatter(comm, MPIU_INT, groups, group_counts, &share->groups));
  PetscCall(scatter(comm, MPI_DOUBLE, whole.coordinates, coordinate_counts, &share->coordinates));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Uniform refinement works on a mesh with edges and faces; they are made for it and thrown away.
PetscErrorCode refine_uniformly(DM *dm) {
  DM interpolated = nullptr, refined = nullptr;
  PetscFunctionBeginUser;
  PetscCall(DMPlexInterpolate(*dm, &interpolated));
  PetscCall(DMDestroy(dm));
  PetscCall(DMPlexSetRefinementUniform(interpolated, PETSC_TRUE));
  PetscCall(DMRefine(interpolated, PetscObjectComm(reinterpret_cast<PetscObject>(interpolated)),
                     &refined));
  PetscCall(DMDestroy(&interpolated));
  PetscCall(DMPlexUninterpolate(refined, dm));
  PetscCall(DMPlexCopyCoordinates(refined, *dm));
  PetscCall(DMDestroy(&refined));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

/// Cells come from the list in its order, and a refined one's children one after the other.
void take_groups(const Share &share, Mesh *mesh) {
  if (share.groups.empty()) return;
  const std::size_t children = static_cast<std::size_t>(mesh->local_cells()) / share.groups.size();
  for (PetscInt group : share.groups) mesh->groups.insert(mesh->groups.end(), children, group);
}

/// Tells all ranks the names of groups, which the first one knows.
PetscErrorCode send_group_names(MPI_Comm comm, const std::map<std::string, PetscInt> &names,
                                Mesh *mesh) {
  std::string text;  // name, zero, number, zero
  PetscFunctionBeginUser;
  for (const auto &[name, number] : names) {
    text += name + '\0' + std::to_string(number) + '\0';
  }
  auto length = static_cast<PetscMPIInt>(text.size());
  PetscCallMPI(MPI_Bcast(&length, 1, MPI_INT, 0, comm));
  text.resize(static_cast<std::size_t>(length));
  PetscCallMPI(MPI_Bcast(text.data(), length, MPI_CHAR, 0, comm));
  std::istringstream words(text);
  for (std::string name, number; std::getline(words, name, '\0');) {
    std::getline(words, number, '\0');
    mesh->group_names.emplace(name, static_cast<PetscInt>(std::stol(number)));
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

PetscErrorCode distribute_mesh(MPI_Comm comm, const CellList &whole, const std::string &partitioner,
                               PetscInt refine, Mesh *mesh) {
  Partition partition;
  Share share;
  PetscFunctionBeginUser;
  PetscCall(tell_shape(comm, *whole.shape, mesh));
  PetscCheck(!is_quadratic(*mesh->shape) || refine == 0, comm, PETSC_ERR_ARG_WRONG,
             "quadratic cells are refined before they are distributed");
  PetscCall(partition_cells(comm, whole, *mesh->shape, partitioner, &partition));
  PetscCallMPI(MPI_Bcast(&partition.edge_cut, 1, MPIU_INT, 0, comm));
  mesh->edge_cut = partition.edge_cut;
  PetscCall(send_shares(comm, whole, partition, &share));
  PetscCall(DMPlexCreateFromCellListParallelPetsc(
      comm, mesh->dimension(), static_cast<PetscInt>(share.cells.size()) / mesh->nodes_per_cell(),
      static_cast<PetscInt>(share.coordinates.size()) / 3, PETSC_DECIDE, mesh->nodes_per_cell(),
      PETSC_FALSE, share.cells.data(), 3, share.coordinates.data(), nullptr, nullptr, &mesh->dm));
  for (PetscInt level = 0; level < refine; ++level) {
    PetscCall(refine_uniformly(&mesh->dm));
    mesh->edge_cut *= mesh->shape->facet->children;
  }
  PetscCall(take_vertex_numbers(mesh));
  PetscCall(take_coordinates(mesh));
  PetscCall(take_cells(mesh));
  take_groups(share, mesh);
  PetscCall(send_group_names(comm, whole.group_names, mesh));
  PetscCall(count_totals(comm, mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
