#include <algorithm>

#include "mesh/distribution.hpp"

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

/// Entries of `width` numbers a cell, sorted by the cells' ranks.
std::vector<PetscInt> by_rank(const std::vector<PetscInt> &entries, std::size_t width,
                              const std::vector<PetscInt> &order) {
  std::vector<PetscInt> sorted;
  if (entries.empty()) return sorted;
  sorted.reserve(entries.size());
  for (const PetscInt cell : order) {
    const auto entry = entries.begin() + static_cast<std::ptrdiff_t>(width) * cell;
    sorted.insert(sorted.end(), entry, entry + static_cast<std::ptrdiff_t>(width));
  }
  return sorted;
}

/// The cells of rank 0, then those of rank 1, and so on, each rank's in the order of the list.
std::vector<PetscInt> order_by_rank(const Partition &partition,
                                    std::vector<PetscMPIInt> &cells_of_rank) {
  for (const PetscInt p : partition.rank_of_cell) ++cells_of_rank[static_cast<std::size_t>(p)];
  std::vector<std::size_t> next(cells_of_rank.size(), 0);
  std::exclusive_scan(cells_of_rank.begin(), cells_of_rank.end(), next.begin(), std::size_t{0});
  std::vector<PetscInt> order(partition.rank_of_cell.size());
  for (std::size_t cell = 0; cell < order.size(); ++cell) {
    const auto p = static_cast<std::size_t>(partition.rank_of_cell[cell]);
    order[next[p]++] = static_cast<PetscInt>(cell);
  }
  return order;
}

PetscErrorCode send_shares(MPI_Comm comm, const CellList &whole, const Partition &partition,
                           Share *share) {
  PetscMPIInt rank = 0, ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  const std::vector<PetscMPIInt> nothing(static_cast<std::size_t>(ranks), 0);
  std::vector<PetscMPIInt> cells(nothing), vertices(nothing);
  std::vector<PetscInt> order;
  if (rank == 0) {
    order = order_by_rank(partition, cells);
    for (PetscInt p = 0; p < ranks; ++p) {  // as PetscLayout divides them
      vertices[static_cast<std::size_t>(p)] =
          whole.vertices() / ranks + (p < whole.vertices() % ranks);
    }
  }
  const auto times = [](std::vector<PetscMPIInt> counts, int width) {
    for (PetscMPIInt &count : counts) count *= width;
    return counts;
  };
  const auto send = [&](const std::vector<PetscInt> &entries, int width,
                        std::vector<PetscInt> *mine) {
    return scatter(comm, MPIU_INT, by_rank(entries, static_cast<std::size_t>(width), order),
                   entries.empty() ? nothing : times(cells, width), mine);
  };
  PetscCall(send(whole.cells, whole.nodes_per_cell(), &share->cells));
  PetscCall(send(whole.groups.set_of_cell, 1, &share->sets));
  PetscCall(send(whole.cell_number, 1, &share->cell_number));
  PetscCall(scatter(comm, MPI_DOUBLE, whole.coordinates, times(vertices, 3), &share->coordinates));
  PetscCall(scatter(comm, MPIU_INT, whole.vertex_number,
                    whole.vertex_number.empty() ? nothing : vertices, &share->vertex_number));
  PetscInt known[2] = {!whole.vertex_number.empty(),
                       whole.vertex_number.empty() ? whole.vertices() : whole.file_vertices};
  PetscCallMPI(MPI_Bcast(known, 2, MPIU_INT, 0, comm));
  share->is_numbered = known[0] != 0;
  share->file_vertices = known[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The number of each local vertex in the whole mesh: the DMPlex has its cells in the order in
/// which they came, and their vertices too.
PetscErrorCode take_whole_numbers(const Mesh &mesh, const std::vector<PetscInt> &cells,
                                  std::vector<PetscInt> *whole_number) {
  PetscInt begin = 0, first = 0, end = 0;
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  PetscFunctionBeginUser;
  PetscCall(DMPlexGetHeightStratum(mesh.dm, 0, &begin, nullptr));
  PetscCall(DMPlexGetDepthStratum(mesh.dm, 0, &first, &end));
  whole_number->assign(static_cast<std::size_t>(end - first), 0);
  for (std::size_t c = 0; c < cells.size() / width; ++c) {
    const PetscInt *cone = nullptr;
    PetscCall(DMPlexGetCone(mesh.dm, begin + static_cast<PetscInt>(c), &cone));
    for (std::size_t a = 0; a < width; ++a) {
      (*whole_number)[static_cast<std::size_t>(cone[a] - first)] = cells[width * c + a];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The file's numbers of cells and vertices; where the shares have none, their own.
PetscErrorCode take_file_numbers(MPI_Comm comm, const Share &share,
                                 const std::vector<PetscInt> &whole_number, Mesh *mesh) {
  PetscInt first = 0;
  const auto cells = static_cast<PetscInt>(share.cells.size()) / mesh->nodes_per_cell();
  PetscFunctionBeginUser;
  mesh->file_vertices = share.file_vertices;
  if (share.is_numbered) {
    mesh->cell_number = share.cell_number;
    PetscCall(fetch_from_shares(comm, share.vertex_number, whole_number, &mesh->vertex_number));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  mesh->vertex_number = whole_number;
  PetscCallMPI(MPI_Exscan(&cells, &first, 1, MPIU_INT, MPI_SUM, comm));
  mesh->cell_number.resize(static_cast<std::size_t>(cells));
  std::iota(mesh->cell_number.begin(), mesh->cell_number.end(), first);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode fetch_from_shares(MPI_Comm comm, const std::vector<PetscInt> &share,
                                 const std::vector<PetscInt> &places, std::vector<PetscInt> *mine) {
  PetscLayout layout = nullptr;
  PetscSF shares = nullptr;
  PetscFunctionBeginUser;
  mine->assign(places.size(), 0);
  PetscCall(PetscLayoutCreateFromSizes(comm, static_cast<PetscInt>(share.size()), PETSC_DECIDE, 1,
                                       &layout));
  PetscCall(PetscSFCreate(comm, &shares));
  PetscCall(PetscSFSetGraphLayout(shares, layout, static_cast<PetscInt>(places.size()), nullptr,
                                  PETSC_OWN_POINTER, places.data()));
  PetscCall(PetscSFBcastBegin(shares, MPIU_INT, share.data(), mine->data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(shares, MPIU_INT, share.data(), mine->data(), MPI_REPLACE));
  PetscCall(PetscSFDestroy(&shares));
  PetscCall(PetscLayoutDestroy(&layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode make_from_shares(MPI_Comm comm, const Share &share, Mesh *mesh,
                                std::vector<PetscInt> *whole_number) {
  PetscFunctionBeginUser;
  PetscCall(DMPlexCreateFromCellListParallelPetsc(
      comm, mesh->dimension(), static_cast<PetscInt>(share.cells.size()) / mesh->nodes_per_cell(),
      static_cast<PetscInt>(share.coordinates.size()) / 3, PETSC_DECIDE, mesh->nodes_per_cell(),
      PETSC_FALSE, share.cells.data(), 3, share.coordinates.data(), nullptr, nullptr, &mesh->dm));
  PetscCall(take_whole_numbers(*mesh, share.cells, whole_number));
  PetscCall(take_file_numbers(comm, share, *whole_number, mesh));
  mesh->groups.set_of_cell = share.sets;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode complete_mesh(MPI_Comm comm, PetscInt refine, Mesh *mesh) {
  PetscFunctionBeginUser;
  if (refine > 0) PetscCall(refine_distributed(refine, mesh));
  PetscCall(take_arrays(mesh));
  PetscCall(count_groups(comm, mesh));
  PetscCall(connected_components(*mesh, &mesh->part, &mesh->parts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode distribute_mesh(MPI_Comm comm, const CellList &whole, const std::string &partitioner,
                               PetscInt refine, Mesh *mesh) {
  Partition partition;
  Share share;
  std::vector<PetscInt> whole_number;
  PetscFunctionBeginUser;
  PetscCall(tell_shape(comm, *whole.shape, mesh));
  PetscCheck(!is_quadratic(*mesh->shape) || refine == 0, comm, PETSC_ERR_ARG_WRONG,
             "quadratic cells are refined before they are distributed");
  PetscCall(partition_cells(comm, whole, *mesh->shape, partitioner, &partition));
  PetscCallMPI(MPI_Bcast(&partition.edge_cut, 1, MPIU_INT, 0, comm));
  mesh->edge_cut = partition.edge_cut;
  PetscCall(send_shares(comm, whole, partition, &share));
  PetscCall(make_from_shares(comm, share, mesh, &whole_number));
  PetscCall(distribute_groups(comm, whole, partition, whole_number, mesh));
  PetscCall(complete_mesh(comm, refine, mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
