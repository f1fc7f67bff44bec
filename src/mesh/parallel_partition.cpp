#include "mesh/parallel_partition.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "mesh/distribution.hpp"
#include "mesh/dual_graph.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// A facet by its sorted corners (PETSC_MAX_INT: there is no third), and one of its cells.
using FacetOfCell = std::array<PetscInt, 4>;

std::vector<PetscInt> facets_of(const std::vector<PetscInt> &cells, const CellShape &shape,
                                PetscInt first_cell) {
  const auto width = static_cast<std::size_t>(shape.nodes);
  const auto corners = static_cast<std::size_t>(shape.facet->corners);
  std::vector<PetscInt> rows;
  rows.reserve(cells.size() / width * shape.facets.size() * 4);
  for (std::size_t c = 0; c < cells.size() / width; ++c) {
    for (const auto &nodes : shape.facets) {
      std::array<PetscInt, CellShape::most_facet_corners> key;
      key.fill(PETSC_MAX_INT);
      for (std::size_t a = 0; a < corners; ++a) {
        key[a] = cells[width * c + static_cast<std::size_t>(nodes[a])];
      }
      std::sort(key.begin(), key.end());
      rows.insert(rows.end(), key.begin(), key.end());
      rows.push_back(first_cell + static_cast<PetscInt>(c));
    }
  }
  return rows;
}

/// Pairs of cells with a facet in common, each way round, of the facets that met on this rank.
std::vector<PetscInt> neighbours_by(const std::vector<PetscInt> &rows) {
  std::vector<FacetOfCell> facets(rows.size() / 4);
  for (std::size_t k = 0; k < rows.size(); ++k) facets[k / 4][k % 4] = rows[k];
  std::sort(facets.begin(), facets.end());
  std::vector<PetscInt> pairs;
  for (std::size_t f = 1; f < facets.size(); ++f) {
    const FacetOfCell &one = facets[f - 1], &other = facets[f];
    if (!std::equal(one.begin(), one.end() - 1, other.begin())) continue;
    pairs.insert(pairs.end(), {one[3], other[3], other[3], one[3]});
  }
  return pairs;
}

DualGraph rows_of(const std::vector<PetscInt> &pairs, PetscInt first_cell, std::size_t cells) {
  DualGraph graph;
  graph.start.assign(cells + 1, 0);
  for (std::size_t k = 0; k < pairs.size(); k += 2) {
    ++graph.start[static_cast<std::size_t>(pairs[k] - first_cell) + 1];
  }
  std::partial_sum(graph.start.begin(), graph.start.end(), graph.start.begin());
  std::vector<PetscInt> next(graph.start);
  graph.neighbour.resize(pairs.size() / 2);
  for (std::size_t k = 0; k < pairs.size(); k += 2) {
    const auto cell = static_cast<std::size_t>(pairs[k] - first_cell);
    graph.neighbour[static_cast<std::size_t>(next[cell]++)] = pairs[k + 1];
  }
  return graph;
}

/// Facets meet on the rank that has their lowest vertex; what they say of their cells comes back.
PetscErrorCode make_graph(MPI_Comm comm, const std::vector<PetscInt> &cells, const CellShape &shape,
                          PetscInt vertices, DualGraph *graph) {
  PetscMPIInt ranks = 0;
  PetscInt first = 0, total = 0;
  const auto mine = static_cast<PetscInt>(cells.size()) / shape.nodes;
  std::vector<PetscInt> met, pairs, rank_of_row;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCallMPI(MPI_Exscan(&mine, &first, 1, MPIU_INT, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(&mine, &total, 1, MPIU_INT, MPI_SUM, comm));
  const std::vector<PetscInt> rows = facets_of(cells, shape, first);
  for (std::size_t k = 0; k < rows.size(); k += 4) {
    rank_of_row.push_back(rank_of_place(rows[k], vertices, ranks));
  }
  PetscCall(send_rows(comm, rows, 4, rank_of_row, &met));
  const std::vector<PetscInt> found = neighbours_by(met);
  rank_of_row.clear();
  for (std::size_t k = 0; k < found.size(); k += 2) {
    rank_of_row.push_back(rank_of_place(found[k], total, ranks));
  }
  PetscCall(send_rows(comm, found, 2, rank_of_row, &pairs));
  *graph = rows_of(pairs, first, static_cast<std::size_t>(mine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where a part came out empty, every rank keeps its share: the file's cells lie along a curve.
PetscErrorCode leave_none_empty(MPI_Comm comm, PetscMPIInt ranks, std::vector<PetscInt> *part) {
  PetscMPIInt rank = 0;
  std::vector<PetscInt> sizes(static_cast<std::size_t>(ranks), 0);
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  for (const PetscInt p : *part) ++sizes[static_cast<std::size_t>(p)];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sizes.data(), ranks, MPIU_INT, MPI_SUM, comm));
  if (std::find(sizes.begin(), sizes.end(), 0) != sizes.end()) part->assign(part->size(), rank);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode count_cut_faces(MPI_Comm comm, const DualGraph &graph, Partition *partition) {
  std::vector<PetscInt> part_of_neighbour;
  PetscFunctionBeginUser;
  PetscCall(fetch_from_shares(comm, partition->rank_of_cell, graph.neighbour, &part_of_neighbour));
  PetscInt cut = 0;
  for (std::size_t c = 0; c + 1 < graph.start.size(); ++c) {
    for (PetscInt e = graph.start[c]; e < graph.start[c + 1]; ++e) {
      cut += partition->rank_of_cell[c] < part_of_neighbour[static_cast<std::size_t>(e)];
    }
  }
  PetscCallMPI(MPI_Allreduce(&cut, &partition->edge_cut, 1, MPIU_INT, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscInt rank_of_place(PetscInt place, PetscInt total, PetscInt ranks) {
  const PetscInt least = total / ranks, larger = total % ranks;  // the first ones have one more
  const PetscInt in_larger = larger * (least + 1);
  return place < in_larger ? place / (least + 1) : larger + (place - in_larger) / least;
}

PetscErrorCode send_rows(MPI_Comm comm, const std::vector<PetscInt> &rows, int width,
                         const std::vector<PetscInt> &rank_of_row,
                         std::vector<PetscInt> *received) {
  PetscMPIInt ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  const std::vector<PetscMPIInt> zeros(static_cast<std::size_t>(ranks), 0);
  std::vector<PetscMPIInt> counts(zeros), incoming(zeros), from(zeros), to(zeros);
  for (const PetscInt rank : rank_of_row) counts[static_cast<std::size_t>(rank)] += width;
  PetscCallMPI(MPI_Alltoall(counts.data(), 1, MPI_INT, incoming.data(), 1, MPI_INT, comm));
  std::exclusive_scan(counts.begin(), counts.end(), from.begin(), 0);
  std::exclusive_scan(incoming.begin(), incoming.end(), to.begin(), 0);
  std::vector<PetscInt> sorted(rows.size());
  std::vector<PetscMPIInt> next(from);
  for (std::size_t row = 0; row < rank_of_row.size(); ++row) {
    PetscMPIInt &place = next[static_cast<std::size_t>(rank_of_row[row])];
    std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(row) * width, width,
                sorted.begin() + place);
    place += width;
  }
  received->resize(static_cast<std::size_t>(to.back() + incoming.back()));
  PetscCallMPI(MPI_Alltoallv(sorted.data(), counts.data(), from.data(), MPIU_INT, received->data(),
                             incoming.data(), to.data(), MPIU_INT, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode partition_shares(MPI_Comm comm, const std::vector<PetscInt> &cells,
                                const CellShape &shape, PetscInt vertices,
                                const std::string &partitioner, Partition *partition) {
  PetscMPIInt ranks = 0;
  PetscInt total = static_cast<PetscInt>(cells.size()) / shape.nodes;
  DualGraph graph;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPIU_INT, MPI_SUM, comm));
  PetscCheck(ranks <= total && ranks <= vertices, comm, PETSC_ERR_USER_INPUT,
             "there are more ranks (%d) than %s (%" PetscInt_FMT
             "); start fewer ranks or refine the mesh",
             ranks, shape.plural, total);
  partition->rank_of_cell.assign(cells.size() / static_cast<std::size_t>(shape.nodes), 0);
  if (ranks == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(make_graph(comm, cells, shape, vertices, &graph));
  PetscCall(divide(comm, partitioner, graph, &partition->rank_of_cell));
  PetscCall(leave_none_empty(comm, ranks, &partition->rank_of_cell));
  PetscCall(count_cut_faces(comm, graph, partition));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
