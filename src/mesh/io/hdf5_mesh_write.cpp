#include <petscviewerhdf5.h>

#include <algorithm>
#include <filesystem>

#include "mesh/distribution.hpp"
#include "mesh/io/hdf5_mesh.hpp"
#include "mesh/io/hdf5_mesh_names.hpp"
#include "mesh/io/list_check.hpp"
#include "support/collective_error.hpp"
#include "support/part_file.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"

namespace trefoil {
namespace {

/// Keeps a number by which the reader knows that a list is as it was written.
template <class Number>
PetscErrorCode write_check(PetscViewer viewer, const std::string &name,
                           const std::vector<Number> &mine) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(viewer));
  const auto count = static_cast<PetscInt64>(mine.size());
  PetscInt64 first = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Exscan(&count, &first, 1, MPIU_INT64, MPI_SUM, comm));
  std::uint64_t sum = check_of_entries(first, std::span<const Number>(mine));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm));
  const PetscInt kept = kept_check(sum);
  PetscCall(
      PetscViewerHDF5WriteAttribute(viewer, name.c_str(), hdf5_names::check, PETSC_INT, &kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Writes a list of numbers, rank below rank; nothing where no rank has any.
PetscErrorCode write_integers(PetscViewer viewer, const std::string &name,
                              const std::vector<PetscInt> &numbers) {
  IS list = nullptr;
  PetscInt total = 0;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(viewer));
  const std::size_t slash = name.rfind('/');
  PetscFunctionBeginUser;
  PetscCall(ISCreateGeneral(comm, static_cast<PetscInt>(numbers.size()), numbers.data(),
                            PETSC_USE_POINTER, &list));
  PetscCall(ISGetSize(list, &total));
  if (total > 0) {
    PetscCall(PetscObjectSetName(reinterpret_cast<PetscObject>(list), name.c_str() + slash + 1));
    PetscCall(PetscViewerHDF5PushGroup(viewer, name.substr(0, slash).c_str()));
    PetscCall(ISView(list, viewer));
    PetscCall(PetscViewerHDF5PopGroup(viewer));
    PetscCall(write_check(viewer, name, numbers));
  }
  PetscCall(ISDestroy(&list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode write_points(PetscViewer viewer, const Mesh &mesh) {
  std::vector<double> mine;
  Vec points = nullptr;
  PetscFunctionBeginUser;
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (!mesh.owned[v]) continue;
    const auto point = mesh.coordinates.begin() + static_cast<std::ptrdiff_t>(3 * v);
    mine.insert(mine.end(), point, point + 3);
  }
  PetscCall(VecCreateMPIWithArray(PetscObjectComm(reinterpret_cast<PetscObject>(viewer)), 3,
                                  static_cast<PetscInt>(mine.size()), PETSC_DETERMINE, mine.data(),
                                  &points));
  PetscCall(PetscObjectSetName(reinterpret_cast<PetscObject>(points), "vertices"));
  PetscCall(PetscViewerHDF5PushGroup(viewer, "/geometry"));
  PetscCall(VecView(points, viewer));
  PetscCall(PetscViewerHDF5PopGroup(viewer));
  PetscCall(write_check(viewer, hdf5_names::points, mine));
  PetscCall(VecDestroy(&points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// As DMPlexTopologyView() does: points of rank 0, cells and then vertices, those of rank 1, ...;
/// `order` has the numbers of these, in which all cells come before all vertices.
PetscErrorCode write_topology(PetscViewer viewer, const Mesh &mesh, PetscInt first_cell) {
  PetscInt dimension = mesh.dimension();
  std::vector<PetscInt> cells, cones, order;
  PetscFunctionBeginUser;
  for (const PetscInt vertex : mesh.cells) {
    cells.push_back(mesh.total_cells + mesh.global_vertex[static_cast<std::size_t>(vertex)]);
  }
  for (PetscInt c = 0; c < mesh.local_cells(); ++c) {
    cones.push_back(mesh.nodes_per_cell());
    order.push_back(first_cell + c);
  }
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (!mesh.owned[v]) continue;
    cones.push_back(0);
    order.push_back(mesh.total_cells + mesh.global_vertex[v]);
  }
  PetscCall(write_integers(viewer, hdf5_names::cells, cells));
  PetscCall(write_integers(viewer, "/topology/cones", cones));
  PetscCall(write_integers(viewer, "/topology/order", order));
  cells.assign(cells.size(), 0);
  PetscCall(write_integers(viewer, "/topology/orientation", cells));
  PetscCall(PetscViewerHDF5WriteAttribute(viewer, hdf5_names::cells.c_str(), "cell_dim", PETSC_INT,
                                          &dimension));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode write_numbers(PetscViewer viewer, const Mesh &mesh) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(viewer));
  const auto shapes = mesh_shapes();
  const auto row = std::find(shapes.begin(), shapes.end(), mesh.shape) - shapes.begin();
  PetscMPIInt rank = 0;
  std::vector<PetscInt> header, numbers;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) {
    header = {hdf5_names::format, static_cast<PetscInt>(row), mesh.total_cells, mesh.total_vertices,
              mesh.file_vertices};
  }
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (mesh.owned[v]) numbers.push_back(mesh.vertex_number[v]);
  }
  PetscCall(write_integers(viewer, hdf5_names::header, header));
  PetscCall(write_integers(viewer, hdf5_names::vertex_number, numbers));
  PetscCall(write_integers(viewer, hdf5_names::cell_number, mesh.cell_number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A local cell that has all these corners.
PetscInt cell_with(const Mesh &mesh, const std::vector<std::vector<PetscInt>> &cells_of_vertex,
                   const PetscInt *corner, std::size_t corners) {
  for (const PetscInt cell : cells_of_vertex[static_cast<std::size_t>(*corner)]) {
    const auto first =
        mesh.cells.begin() + static_cast<std::ptrdiff_t>(cell) * mesh.nodes_per_cell();
    const auto last = first + mesh.shape->corners;
    if (std::all_of(corner, corner + corners,
                    [&](PetscInt each) { return std::find(first, last, each) != last; }))
      return cell;
  }
  return -1;
}

/// Of each dimension below the cells': the cell that each entity in a group bounds, its set of
/// groups, its corners. Collective, so that no rank is left in the writing of them.
PetscErrorCode rows_of_entities(MPI_Comm comm, const Mesh &mesh, PetscInt first_cell,
                                std::vector<std::vector<PetscInt>> *rows) {
  std::string complaint;
  PetscFunctionBeginUser;
  rows->assign(mesh.groups.below.size(), {});
  std::vector<std::vector<PetscInt>> cells_of_vertex(mesh.owned.size());
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  for (std::size_t k = 0; k < mesh.cells.size(); ++k) {
    cells_of_vertex[static_cast<std::size_t>(mesh.cells[k])].push_back(
        static_cast<PetscInt>(k / width));
  }
  for (std::size_t dimension = 0; dimension < mesh.groups.below.size(); ++dimension) {
    const GroupedEntities &entities = mesh.groups.below[dimension];
    const std::size_t corners = entities.size() ? entities.vertices.size() / entities.size() : 0;
    std::vector<PetscInt> &row = (*rows)[dimension];
    for (std::size_t e = 0; e < entities.size(); ++e) {
      const PetscInt *corner = &entities.vertices[corners * e];
      const PetscInt cell = cell_with(mesh, cells_of_vertex, corner, corners);
      if (cell < 0) complaint = "what is in a group has no cell";
      row.push_back(first_cell + cell);
      row.push_back(entities.sets[e]);
      for (std::size_t a = 0; a < corners; ++a)
        row.push_back(mesh.global_vertex[static_cast<std::size_t>(corner[a])]);
    }
  }
  PetscCall(agree_on_complaint(comm, complaint, PETSC_ERR_PLIB));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode write_groups(PetscViewer viewer, const Mesh &mesh, PetscInt first_cell) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(viewer));
  PetscMPIInt rank = 0;
  GroupTables tables;
  std::vector<std::vector<PetscInt>> rows;
  PetscFunctionBeginUser;
  if (mesh.groups.list().empty()) PetscFunctionReturn(PETSC_SUCCESS);  // the same on all ranks
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) tables = pack_groups(mesh.groups);
  PetscCall(rows_of_entities(comm, mesh, first_cell, &rows));
  PetscCall(write_integers(viewer, hdf5_names::groups, tables.numbers));
  PetscCall(
      write_integers(viewer, hdf5_names::group_names, {tables.names.begin(), tables.names.end()}));
  PetscCall(write_integers(viewer, hdf5_names::cell_set, mesh.groups.set_of_cell));
  for (std::size_t dimension = 0; dimension < rows.size(); ++dimension) {
    PetscCall(write_integers(viewer, hdf5_names::entities(dimension), rows[dimension]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// About what the file takes: cells, cones, orders and numbers; points; what HDF5 keeps itself.
PetscInt64 bytes_of(const Mesh &mesh) {
  const PetscInt64 integers =
      mesh.total_cells * (2 * mesh.nodes_per_cell() + 3) + mesh.total_vertices * PetscInt64{3};
  const PetscInt64 bytes = integers * static_cast<PetscInt64>(sizeof(PetscInt)) +
                           mesh.total_vertices * PetscInt64{3 * sizeof(double)};
  return bytes + bytes / 5 + 65536;
}

PetscErrorCode write_all(MPI_Comm comm, const std::string &part, const Mesh &mesh) {
  PetscViewer viewer = nullptr;
  PetscInt first_cell = 0;
  const PetscInt cells = mesh.local_cells();
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Exscan(&cells, &first_cell, 1, MPIU_INT, MPI_SUM, comm));
  PetscCall(PetscViewerHDF5Open(comm, part.c_str(), FILE_MODE_WRITE, &viewer));
  PetscCall(write_topology(viewer, mesh, first_cell));
  PetscCall(write_points(viewer, mesh));
  PetscCall(write_numbers(viewer, mesh));
  PetscCall(write_groups(viewer, mesh, first_cell));
  PetscCall(PetscViewerDestroy(&viewer));  // what is buffered meets a full disk here
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode write_hdf5_mesh(MPI_Comm comm, const std::string &path, const Mesh &mesh) {
  const std::string place = follow_links(path);
  PetscMPIInt rank = 0;
  std::string part, problem;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) {
    if (is_stream(place))
      problem = "it is a device or a pipe; name a file";
    else
      part = make_part(place, &problem);
    // Some ranks would wait for ever for one whose part of the file has no room.
    if (problem.empty()) problem = find_no_room(part, bytes_of(mesh));
    std::error_code error;
    if (!problem.empty() && !part.empty()) std::filesystem::remove(part, error);
  }
  const auto sentence = [&] {
    return problem.empty() ? "" : "cannot write the mesh '" + path + "': " + problem;
  };
  PetscCall(agree_on_complaint(comm, sentence(), PETSC_ERR_FILE_OPEN));
  auto length = static_cast<PetscMPIInt>(part.size());
  PetscCallMPI(MPI_Bcast(&length, 1, MPI_INT, 0, comm));
  part.resize(static_cast<std::size_t>(length));
  PetscCallMPI(MPI_Bcast(part.data(), length, MPI_CHAR, 0, comm));
  // What fails here is said in a sentence of ours, and leaves nothing behind.
  H5E_auto2_t printer = nullptr;
  void *printer_data = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &printer, &printer_data);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
  const PetscErrorCode failure = write_all(comm, part, mesh);
  PetscCall(PetscPopErrorHandler());
  H5Eset_auto2(H5E_DEFAULT, printer, printer_data);
  if (failure) problem = "HDF5 cannot write it; is there room on the disk?";
  PetscInt fails = failure ? 1 : 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &fails, 1, MPIU_INT, MPI_MAX, comm));
  if (rank == 0) {
    std::error_code error;
    if (!fails) std::filesystem::rename(part, place, error);
    if (error) problem = error.message();
    if (fails || error) std::filesystem::remove(part, error);
  }
  PetscCall(agree_on_complaint(comm, sentence(), PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
