#include <petscsf.h>

#include <algorithm>
#include <numeric>

#include "mesh/mesh.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// The parts of this rank's cells that hang together: for each local vertex a representative.
std::vector<PetscInt> local_components(const Mesh &mesh) {
  std::vector<PetscInt> parent(mesh.global_vertex.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto representative = [&parent](PetscInt v) {
    while (parent[static_cast<std::size_t>(v)] != v) {
      auto &up = parent[static_cast<std::size_t>(v)];
      up = parent[static_cast<std::size_t>(up)];
      v = up;
    }
    return v;
  };
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    const PetscInt root = representative(mesh.cells[c]);
    for (std::size_t a = 1; a < width; ++a) {
      parent[static_cast<std::size_t>(representative(mesh.cells[c + a]))] = root;
    }
  }
  for (PetscInt v = 0; v < static_cast<PetscInt>(parent.size()); ++v) {
    parent[static_cast<std::size_t>(v)] = representative(v);
  }
  return parent;
}

/// Gives every vertex of a local component the smallest label among them.
void level(const std::vector<PetscInt> &representative, std::vector<PetscInt> &label) {
  for (std::size_t v = 0; v < label.size(); ++v) {
    PetscInt &least = label[static_cast<std::size_t>(representative[v])];
    least = std::min(least, label[v]);
  }
  for (std::size_t v = 0; v < label.size(); ++v) {
    label[v] = label[static_cast<std::size_t>(representative[v])];
  }
}

}  // namespace

PetscErrorCode connected_components(const Mesh &mesh, std::vector<PetscInt> *component,
                                    PetscInt *count) {
  PetscSF points = nullptr;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscInt chart_begin = 0, chart_end = 0;
  PetscFunctionBeginUser;
  PetscCall(DMGetPointSF(mesh.dm, &points));
  PetscCall(DMPlexGetChart(mesh.dm, &chart_begin, &chart_end));
  const std::vector<PetscInt> representative = local_components(mesh);
  std::vector<PetscInt> label(mesh.global_vertex);
  // The star forest of the mesh numbers points, cells first: labels live behind the cells'.
  const auto points_count = static_cast<std::size_t>(chart_end - chart_begin);
  std::vector<PetscInt> at_leaves(points_count, PETSC_MAX_INT);
  std::vector<PetscInt> at_roots(points_count, PETSC_MAX_INT);
  for (PetscMPIInt changed = 1; changed;) {
    const std::vector<PetscInt> before(label);
    level(representative, label);
    std::copy(label.begin(), label.end(), at_leaves.begin() + mesh.first_vertex);
    at_roots = at_leaves;
    PetscCall(PetscSFReduceBegin(points, MPIU_INT, at_leaves.data(), at_roots.data(), MPI_MIN));
    PetscCall(PetscSFReduceEnd(points, MPIU_INT, at_leaves.data(), at_roots.data(), MPI_MIN));
    at_leaves = at_roots;
    PetscCall(PetscSFBcastBegin(points, MPIU_INT, at_roots.data(), at_leaves.data(), MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(points, MPIU_INT, at_roots.data(), at_leaves.data(), MPI_REPLACE));
    std::copy_n(at_leaves.begin() + mesh.first_vertex, label.size(), label.begin());
    changed = label != before;
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, comm));
  }

  // A component is named by its smallest vertex, which keeps its own number as label; the owners
  // of such vertices number them.
  std::vector<PetscInt> names;
  for (std::size_t v = 0; v < label.size(); ++v) {
    if (mesh.owned[v] && label[v] == mesh.global_vertex[v]) names.push_back(label[v]);
  }
  IS mine = nullptr, all = nullptr;
  const PetscInt *name = nullptr;
  PetscCall(ISCreateGeneral(comm, static_cast<PetscInt>(names.size()), names.data(),
                            PETSC_USE_POINTER, &mine));
  PetscCall(ISAllGather(mine, &all));
  PetscCall(ISSort(all));
  PetscCall(ISGetLocalSize(all, count));
  PetscCall(ISGetIndices(all, &name));
  component->resize(label.size());
  for (std::size_t v = 0; v < label.size(); ++v) {
    (*component)[v] = static_cast<PetscInt>(std::lower_bound(name, name + *count, label[v]) - name);
  }
  PetscCall(ISRestoreIndices(all, &name));
  PetscCall(ISDestroy(&all));
  PetscCall(ISDestroy(&mine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
