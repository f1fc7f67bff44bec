#include "scene/factor_estimate.hpp"

#include <metis.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// The free vertices of a rank: first those that it owns, then its ghosts.
struct Graph {
  std::size_t owned = 0;           ///< vertices that this rank owns
  std::vector<std::size_t> start;  ///< of each vertex's neighbours
  std::vector<idx_t> neighbours;   ///< without the vertex itself
  double interface = 0;            ///< owned vertices beside ghosts

  [[nodiscard]] std::size_t size() const { return start.size() - 1; }
};

/// Numbers the free local vertices, owned ones first; -1 where held.
std::vector<idx_t> number_vertices(const Discretization &discretization, Graph *graph,
                                   std::size_t *count) {
  const Mesh &mesh = discretization.mesh();
  std::vector<idx_t> number(mesh.owned.size(), -1);
  idx_t next = 0;
  for (const bool owned : {true, false}) {
    for (std::size_t v = 0; v < number.size(); ++v) {
      const auto dofs = discretization.dofs_of_vertex(static_cast<PetscInt>(v));
      const bool is_free = *std::max_element(dofs.begin(), dofs.end()) >= 0;
      if (is_free && (mesh.owned[v] != 0) == owned) number[v] = next++;
    }
    if (owned) graph->owned = static_cast<std::size_t>(next);
  }
  *count = static_cast<std::size_t>(next);
  return number;
}

/// Leaves each neighbour of a vertex once.
void drop_repeated(Graph *graph) {
  std::size_t end = 0;
  for (std::size_t v = 0; v < graph->size(); ++v) {
    const auto begin = graph->neighbours.begin();
    const auto first = begin + static_cast<std::ptrdiff_t>(graph->start[v]);
    const auto last = begin + static_cast<std::ptrdiff_t>(graph->start[v + 1]);
    std::sort(first, last);
    const auto count = static_cast<std::size_t>(std::unique(first, last) - first);
    std::copy_n(first, count, begin + static_cast<std::ptrdiff_t>(end));
    graph->start[v] = end;
    end += count;
  }
  graph->start.back() = end;
  graph->neighbours.resize(end);
}

Graph make_graph(const Discretization &discretization) {
  const Mesh &mesh = discretization.mesh();
  const auto nodes = static_cast<std::size_t>(mesh.nodes_per_cell());
  Graph graph;
  std::size_t count = 0;
  const std::vector<idx_t> number = number_vertices(discretization, &graph, &count);
  const auto for_all_pairs = [&](const auto &act) {
    for (std::size_t first = 0; first < mesh.cells.size(); first += nodes) {
      for (std::size_t a = first; a < first + nodes; ++a) {
        for (std::size_t b = first; b < first + nodes; ++b) {
          const idx_t v = number[static_cast<std::size_t>(mesh.cells[a])];
          const idx_t w = number[static_cast<std::size_t>(mesh.cells[b])];
          if (v != w && v >= 0 && w >= 0) act(static_cast<std::size_t>(v), w);
        }
      }
    }
  };
  graph.start.assign(count + 1, 0);
  for_all_pairs([&](std::size_t v, idx_t) { ++graph.start[v + 1]; });
  std::partial_sum(graph.start.begin(), graph.start.end(), graph.start.begin());
  graph.neighbours.resize(graph.start.back());
  std::vector<std::size_t> next(graph.start.begin(), graph.start.end() - 1);
  for_all_pairs([&](std::size_t v, idx_t w) { graph.neighbours[next[v]++] = w; });
  drop_repeated(&graph);
  for (std::size_t v = 0; v < graph.owned; ++v) {
    // Neighbours are sorted: ghosts come last.
    const bool alone = graph.start[v] == graph.start[v + 1];
    graph.interface +=
        !alone && static_cast<std::size_t>(graph.neighbours[graph.start[v + 1] - 1]) >= graph.owned;
  }
  return graph;
}

/// METIS's order: the place of each vertex; ghosts keep theirs behind all others.
std::vector<idx_t> order_vertices(const Graph &graph) {
  std::vector<idx_t> place(graph.size()), vertex(graph.owned), start(1, 0), neighbours;
  std::iota(place.begin(), place.end(), 0);
  for (std::size_t v = 0; v < graph.owned; ++v) {
    for (std::size_t e = graph.start[v]; e < graph.start[v + 1]; ++e) {
      const idx_t w = graph.neighbours[e];
      if (static_cast<std::size_t>(w) < graph.owned) neighbours.push_back(w);
    }
    start.push_back(static_cast<idx_t>(neighbours.size()));
  }
  auto count = static_cast<idx_t>(graph.owned);
  // METIS ends the process where there are no edges.
  if (!neighbours.empty()) {
    METIS_NodeND(&count, start.data(), neighbours.data(), nullptr, nullptr, vertex.data(),
                 place.data());
  }
  return place;
}

/// Blocks of each column of the factor, the diagonal one included, by walks up the elimination tree
/// (Liu 1990, "The role of elimination trees in sparse factorization").
std::vector<double> column_counts(const Graph &graph, const std::vector<idx_t> &place) {
  const std::size_t size = graph.size();
  constexpr idx_t none = -1;
  std::vector<idx_t> vertex_at(size), parent(size, none), row_of_last_walk(size, none);
  std::vector<double> count(size, 1);
  for (std::size_t v = 0; v < size; ++v) {
    vertex_at[static_cast<std::size_t>(place[v])] = static_cast<idx_t>(v);
  }
  for (std::size_t row = 0; row < size; ++row) {
    const auto i = static_cast<idx_t>(row);
    const auto v = static_cast<std::size_t>(vertex_at[row]);
    row_of_last_walk[row] = i;
    for (std::size_t e = graph.start[v]; e < graph.start[v + 1]; ++e) {
      // Every column on the way from this entry to the row has an entry in it.
      for (idx_t j = place[static_cast<std::size_t>(graph.neighbours[e])];
           j < i && row_of_last_walk[static_cast<std::size_t>(j)] != i;
           j = parent[static_cast<std::size_t>(j)]) {
        const auto column = static_cast<std::size_t>(j);
        if (parent[column] == none) parent[column] = i;
        row_of_last_walk[column] = i;
        ++count[column];
      }
    }
  }
  return count;
}

void add_column(double blocks, FactorEstimate *sum) {
  sum->entries += blocks;
  sum->flops += blocks * (blocks + 1) / 2;
}

/// A binary tree of separators between the ranks, with the same number of vertices at each level;
/// those below the first one are surrounded by as many.
void add_separators_of_ranks(double vertices, int ranks, FactorEstimate *sum) {
  const int levels = static_cast<int>(std::ceil(std::log2(ranks)));
  for (int level = 0; level < levels; ++level) {
    const double separators = std::pow(2, level), size = vertices / levels / separators;
    FactorEstimate one;
    for (double k = 1; k <= size; ++k) add_column(k + (level > 0 ? vertices / levels : 0), &one);
    sum->entries += separators * one.entries;
    sum->flops += separators * one.flops;
  }
}

}  // namespace

PetscErrorCode estimate_factor(const Discretization &discretization, FactorEstimate *estimate) {
  const Mesh &mesh = discretization.mesh();
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscMPIInt ranks = 0;
  FactorEstimate mine;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  const Graph graph = make_graph(discretization);
  const std::vector<double> counts = column_counts(graph, order_vertices(graph));
  for (std::size_t column = 0; column < graph.owned; ++column) add_column(counts[column], &mine);
  double sums[3] = {mine.entries, mine.flops, graph.interface};
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_DOUBLE, MPI_SUM, comm));
  *estimate = {sums[0], sums[1]};
  add_separators_of_ranks(sums[2] / 2, ranks, estimate);  // the sum has both sides
  // From blocks to numbers, of which a vertex has as many as the body dimensions.
  const double unknowns = mesh.dimension();
  estimate->entries *= unknowns * unknowns;
  estimate->flops *= unknowns * unknowns * unknowns;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
