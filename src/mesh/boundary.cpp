#include "mesh/boundary.hpp"

#include <petscsf.h>

#include <algorithm>
#include <numeric>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using Key = std::array<PetscInt, 3>;  ///< global numbers of the corners, ascending

Key key_of(const Mesh &mesh, const Facet &facet) {
  Key key{-1, -1, -1};
  for (std::size_t i = 0; i < static_cast<std::size_t>(facet.corners); ++i) {
    key[i] = mesh.global_vertex[static_cast<std::size_t>(facet.vertices[i])];
  }
  return key;
}

/// Place of the midpoint between two corners in a quadratic cell.
int midpoint_of(int dimension, int a, int b) {
  constexpr int edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  int e = 0;
  while (edges[e][0] != std::min(a, b) || edges[e][1] != std::max(a, b)) ++e;
  return dimension + 1 + e;
}

/// The facet of a cell that is opposite to a corner.
Facet facet_of(const Mesh &mesh, const PetscInt *cell, int opposite) {
  std::vector<int> corner;
  Facet facet;
  facet.corners = mesh.dimension;
  for (int i = 1; i <= facet.corners; ++i) corner.push_back((opposite + i) % (mesh.dimension + 1));
  std::sort(corner.begin(), corner.end(), [&](int a, int b) {
    return mesh.global_vertex[static_cast<std::size_t>(cell[a])] <
           mesh.global_vertex[static_cast<std::size_t>(cell[b])];
  });
  facet.count = 0;
  const auto add = [&](int node) {
    facet.vertices[static_cast<std::size_t>(facet.count++)] = cell[node];
  };
  for (const int node : corner) add(node);
  if (mesh.nodes_per_cell == mesh.dimension + 1) return facet;
  add(midpoint_of(mesh.dimension, corner[0], corner[1]));
  if (mesh.dimension == 3) {
    add(midpoint_of(3, corner[1], corner[2]));
    add(midpoint_of(3, corner[2], corner[0]));
  }
  return facet;
}

/// The facets that only one of this rank's cells has.
std::vector<Facet> single_facets(const Mesh &mesh) {
  std::vector<std::pair<Key, Facet>> all;
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell);
  all.reserve(mesh.cells.size() / width * static_cast<std::size_t>(mesh.dimension + 1));
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    for (int opposite = 0; opposite <= mesh.dimension; ++opposite) {
      const Facet facet = facet_of(mesh, &mesh.cells[c], opposite);
      all.emplace_back(key_of(mesh, facet), facet);
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto &a, const auto &b) { return a.first < b.first; });
  std::vector<Facet> single;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool like_last = k > 0 && all[k - 1].first == all[k].first;
    const bool like_next = k + 1 < all.size() && all[k + 1].first == all[k].first;
    if (!like_last && !like_next) single.push_back(all[k].second);
  }
  return single;
}

/// Keeps the facets that no other rank has: all ranks that have one send it to the same rank, which
/// answers how many there are.
PetscErrorCode drop_shared(const Mesh &mesh, std::vector<Facet> *facets) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscMPIInt ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  if (ranks == 1) PetscFunctionReturn(PETSC_SUCCESS);
  const auto judge = [&](const Facet &facet) {
    return static_cast<std::size_t>(key_of(mesh, facet)[0] % ranks);
  };
  std::stable_sort(facets->begin(), facets->end(),
                   [&](const Facet &a, const Facet &b) { return judge(a) < judge(b); });
  const auto parts = static_cast<std::size_t>(ranks);
  std::vector<PetscMPIInt> send(parts, 0), receive(parts, 0), send_at(parts, 0),
      receive_at(parts, 0);
  std::vector<PetscInt> mine;
  for (const Facet &facet : *facets) {
    const Key key = key_of(mesh, facet);
    mine.insert(mine.end(), key.begin(), key.end());
    send[judge(facet)] += 3;
  }
  PetscCallMPI(MPI_Alltoall(send.data(), 1, MPI_INT, receive.data(), 1, MPI_INT, comm));
  std::exclusive_scan(send.begin(), send.end(), send_at.begin(), 0);
  std::exclusive_scan(receive.begin(), receive.end(), receive_at.begin(), 0);
  std::vector<PetscInt> judged(static_cast<std::size_t>(receive_at.back() + receive.back()));
  PetscCallMPI(MPI_Alltoallv(mine.data(), send.data(), send_at.data(), MPIU_INT, judged.data(),
                             receive.data(), receive_at.data(), MPIU_INT, comm));
  std::vector<Key> sorted;
  for (std::size_t k = 0; k < judged.size(); k += 3) {
    sorted.push_back({judged[k], judged[k + 1], judged[k + 2]});
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t k = 0; k < judged.size(); k += 3) {  // the answer takes the first number's place
    const Key key{judged[k], judged[k + 1], judged[k + 2]};
    const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), key);
    judged[k] = static_cast<PetscInt>(last - first);
  }
  PetscCallMPI(MPI_Alltoallv(judged.data(), receive.data(), receive_at.data(), MPIU_INT,
                             mine.data(), send.data(), send_at.data(), MPIU_INT, comm));
  std::vector<Facet> kept;
  for (std::size_t k = 0; k < facets->size(); ++k) {
    if (mine[3 * k] == 1) kept.push_back((*facets)[k]);
  }
  facets->swap(kept);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode boundary_facets(const Mesh &mesh, const std::function<bool(const Facet &)> &wanted,
                               std::vector<Facet> *facets) {
  PetscFunctionBeginUser;
  facets->clear();
  for (const Facet &facet : single_facets(mesh)) {
    if (wanted(facet)) facets->push_back(facet);
  }
  PetscCall(drop_shared(mesh, facets));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode sum_at_owners(const Mesh &mesh, std::vector<double> *values) {
  PetscSF points = nullptr;
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(DMGetPointSF(mesh.dm, &points));
  PetscCall(DMPlexGetChart(mesh.dm, &begin, &end));
  const auto first = static_cast<std::size_t>(mesh.first_vertex - begin);
  std::vector<double> component(static_cast<std::size_t>(end - begin), 0), sum;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t v = 0; v < mesh.owned.size(); ++v) component[first + v] = (*values)[3 * v + i];
    sum = component;
    PetscCall(PetscSFReduceBegin(points, MPI_DOUBLE, component.data(), sum.data(), MPI_SUM));
    PetscCall(PetscSFReduceEnd(points, MPI_DOUBLE, component.data(), sum.data(), MPI_SUM));
    for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
      (*values)[3 * v + i] = mesh.owned[v] ? sum[first + v] : 0;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
