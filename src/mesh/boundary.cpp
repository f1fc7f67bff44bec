#include "mesh/boundary.hpp"

#include <petscsf.h>

#include <algorithm>
#include <numeric>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Global numbers of a facet's corners, ascending, and -1 before them where there are fewer.
using Key = std::array<PetscInt, CellShape::most_facet_corners>;

Key key_of(const Mesh &mesh, const Facet &facet) {
  Key key;
  key.fill(-1);
  std::transform(facet.begin(), facet.begin() + facet.corners(), key.begin(),
                 [&](PetscInt v) { return mesh.global_vertex[static_cast<std::size_t>(v)]; });
  std::sort(key.begin(), key.end());
  return key;
}

Facet facet_of(const Mesh &mesh, PetscInt cell, std::size_t which) {
  Facet facet{mesh.shape->facet, {}, cell};
  const PetscInt *node = &mesh.cells[static_cast<std::size_t>(cell * mesh.nodes_per_cell())];
  for (std::size_t k = 0; k < static_cast<std::size_t>(facet.count()); ++k) {
    facet.vertices[k] = node[mesh.shape->facets[which][k]];
  }
  return facet;
}

/// The wanted facets that only one of this rank's cells has.
std::vector<Facet> single_facets(const Mesh &mesh,
                                 const std::function<bool(const Facet &)> &wanted) {
  struct Entry {
    Key key;
    PetscInt cell;
    std::size_t which;
  };
  std::vector<Entry> all;
  for (PetscInt cell = 0; cell < mesh.local_cells(); ++cell) {
    for (std::size_t which = 0; which < mesh.shape->facets.size(); ++which) {
      const Facet facet = facet_of(mesh, cell, which);
      if (wanted(facet)) all.push_back({key_of(mesh, facet), cell, which});
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Entry &a, const Entry &b) { return a.key < b.key; });
  std::vector<Facet> single;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool like_last = k > 0 && all[k - 1].key == all[k].key;
    const bool like_next = k + 1 < all.size() && all[k + 1].key == all[k].key;
    if (!like_last && !like_next) single.push_back(facet_of(mesh, all[k].cell, all[k].which));
  }
  return single;
}

/// Keeps the facets that no other rank has: all ranks that have one send it to the same rank, which
/// answers how many there are.
PetscErrorCode drop_shared(const Mesh &mesh, std::vector<Facet> *facets) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  constexpr int width = CellShape::most_facet_corners;
  PetscMPIInt ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  if (ranks == 1) PetscFunctionReturn(PETSC_SUCCESS);
  const auto judge = [&](const Facet &facet) {
    return static_cast<std::size_t>(key_of(mesh, facet).back() % ranks);
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
    send[judge(facet)] += width;
  }
  PetscCallMPI(MPI_Alltoall(send.data(), 1, MPI_INT, receive.data(), 1, MPI_INT, comm));
  std::exclusive_scan(send.begin(), send.end(), send_at.begin(), 0);
  std::exclusive_scan(receive.begin(), receive.end(), receive_at.begin(), 0);
  std::vector<PetscInt> judged(static_cast<std::size_t>(receive_at.back() + receive.back()));
  PetscCallMPI(MPI_Alltoallv(mine.data(), send.data(), send_at.data(), MPIU_INT, judged.data(),
                             receive.data(), receive_at.data(), MPIU_INT, comm));
  const auto key_at = [&](std::size_t k) {
    Key key;
    std::copy_n(judged.begin() + static_cast<std::ptrdiff_t>(k), width, key.begin());
    return key;
  };
  std::vector<Key> sorted;
  for (std::size_t k = 0; k < judged.size(); k += width) sorted.push_back(key_at(k));
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t k = 0; k < judged.size(); k += width) {  // the answer takes a key's first place
    const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), key_at(k));
    judged[k] = static_cast<PetscInt>(last - first);
  }
  PetscCallMPI(MPI_Alltoallv(judged.data(), receive.data(), receive_at.data(), MPIU_INT,
                             mine.data(), send.data(), send_at.data(), MPIU_INT, comm));
  std::vector<Facet> kept;
  for (std::size_t k = 0; k < facets->size(); ++k) {
    if (mine[width * k] == 1) kept.push_back((*facets)[k]);
  }
  facets->swap(kept);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode boundary_facets(const Mesh &mesh, const std::function<bool(const Facet &)> &wanted,
                               std::vector<Facet> *facets) {
  PetscFunctionBeginUser;
  *facets = single_facets(mesh, wanted);
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
