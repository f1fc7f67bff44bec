#include <metis.h>

#include <algorithm>
#include <numeric>

#include "mesh/dual_graph.hpp"
#include "mesh/mesh.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

DualGraph dual_graph(const CellList &mesh) {
  idx_t cells = mesh.size(), vertices = mesh.vertices(), common = mesh.shape->facet->corners,
        base = 0;
  std::vector<idx_t> begin(static_cast<std::size_t>(cells) + 1);
  std::vector<idx_t> corner;
  corner.reserve(static_cast<std::size_t>(cells) * static_cast<std::size_t>(mesh.corners()));
  for (std::size_t c = 0; c < begin.size(); ++c) {
    begin[c] = static_cast<idx_t>(c) * mesh.corners();
    if (static_cast<idx_t>(c) == cells) break;
    const auto cell = mesh.cells.begin() + static_cast<std::ptrdiff_t>(c) * mesh.nodes_per_cell();
    corner.insert(corner.end(), cell, cell + mesh.corners());
  }
  idx_t *rows = nullptr, *columns = nullptr;
  DualGraph graph;
  if (METIS_MeshToDual(&cells, &vertices, begin.data(), corner.data(), &common, &base, &rows,
                       &columns) == METIS_OK) {
    graph.start.assign(rows, rows + cells + 1);
    graph.neighbour.assign(columns, columns + rows[cells]);
    METIS_Free(rows);
    METIS_Free(columns);
  }
  return graph;
}

std::vector<PetscInt> metis_parts(const DualGraph &graph, PetscInt parts) {
  idx_t cells = static_cast<idx_t>(graph.start.size()) - 1, balances = 1, count = parts, cut = 0;
  std::vector<idx_t> start(graph.start.begin(), graph.start.end());
  std::vector<idx_t> neighbour(graph.neighbour.begin(), graph.neighbour.end());
  std::vector<idx_t> part(static_cast<std::size_t>(cells), 0);
  // Recursive bisection balances few parts better; k-way is faster for many.
  auto *divide = parts <= 8 ? METIS_PartGraphRecursive : METIS_PartGraphKway;
  divide(&cells, &balances, start.data(), neighbour.data(), nullptr, nullptr, nullptr, &count,
         nullptr, nullptr, nullptr, &cut, part.data());
  return {part.begin(), part.end()};
}

/// A part without cells gets one from the largest part, so that every rank has work.
void fill_empty_parts(std::vector<PetscInt> &part, PetscInt parts) {
  std::vector<PetscInt> size(static_cast<std::size_t>(parts), 0);
  for (PetscInt p : part) ++size[static_cast<std::size_t>(p)];
  for (auto empty = size.begin(); (empty = std::find(empty, size.end(), 0)) != size.end();) {
    const auto largest = std::max_element(size.begin(), size.end());
    *std::find(part.begin(), part.end(), largest - size.begin()) = empty - size.begin();
    --*largest;
    ++*empty;
  }
}

PetscInt count_cut_faces(const DualGraph &graph, const std::vector<PetscInt> &part) {
  PetscInt cut = 0;
  for (std::size_t c = 0; c + 1 < graph.start.size(); ++c) {
    for (PetscInt e = graph.start[c]; e < graph.start[c + 1]; ++e) {
      cut += part[c] < part[static_cast<std::size_t>(graph.neighbour[static_cast<std::size_t>(e)])];
    }
  }
  return cut;
}

}  // namespace

PetscErrorCode partition_cells(MPI_Comm comm, const CellList &whole, const CellShape &shape,
                               const std::string &partitioner, Partition *partition) {
  PetscMPIInt rank = 0, ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscInt cells = rank == 0 ? whole.size() : 0;
  PetscCallMPI(MPI_Bcast(&cells, 1, MPIU_INT, 0, comm));
  PetscCheck(ranks <= cells, comm, PETSC_ERR_USER_INPUT,
             "there are more ranks (%d) than %s (%" PetscInt_FMT
             "); start fewer ranks or refine the mesh",
             ranks, shape.plural, cells);
  if (ranks == 1) {
    partition->rank_of_cell.assign(static_cast<std::size_t>(cells), 0);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  DualGraph graph;
  if (rank == 0) graph = dual_graph(whole);
  if (partitioner == "metis") {
    if (rank == 0) partition->rank_of_cell = metis_parts(graph, ranks);
  } else {
    PetscCall(divide(comm, partitioner, graph, &partition->rank_of_cell));
  }
  if (rank == 0) {
    fill_empty_parts(partition->rank_of_cell, ranks);
    partition->edge_cut = count_cut_faces(graph, partition->rank_of_cell);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
