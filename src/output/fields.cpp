#include <algorithm>

#include "output/result.hpp"
#include "output/snapshot.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"

namespace trefoil {
namespace {

/// This rank's owned vertices and its cells by global vertex numbers.
void take_geometry(const Mesh &mesh, Snapshot *snapshot) {
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (!mesh.owned[v]) continue;
    const auto position = mesh.coordinates.begin() + static_cast<std::ptrdiff_t>(3 * v);
    snapshot->points.insert(snapshot->points.end(), position, position + 3);
  }
  snapshot->corners = mesh.nodes_per_cell();
  for (PetscInt node : mesh.cells) {
    snapshot->cells.push_back(mesh.global_vertex[static_cast<std::size_t>(node)]);
  }
}

std::vector<double> owned_displacements(const Mesh &mesh, const PetscScalar *u) {
  std::vector<double> values;
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (mesh.owned[v]) values.insert(values.end(), u + 3 * v, u + 3 * v + 3);
  }
  return values;
}

}  // namespace

PetscErrorCode check_outputs(MPI_Comm comm, const SceneOptions &options) {
  const std::string &path = options.output_file;
  PetscFunctionBeginUser;
  if (!path.empty()) PetscCall(check_writable(comm, path));
  if (!options.record_file.empty()) PetscCall(check_text_file(comm, options.record_file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode write_fields(const Scene &scene) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  PetscMPIInt rank = 0;
  Snapshot snapshot;
  EnergyFunctional::CellReport report;
  PetscFunctionBeginUser;
  if (scene.options.output_file.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  take_geometry(scene.mesh, &snapshot);
  PetscCall(scene.discretization.get_local(scene.displacement, &local, &u));
  snapshot.fields.push_back({"displacement", true, 3, owned_displacements(scene.mesh, u)});
  PetscCall(scene.discretization.restore_local(&local, &u));
  PetscCall(scene.functional->describe_cells(scene.displacement, &report));
  const std::vector<double> ranks(static_cast<std::size_t>(scene.mesh.local_cells()), rank);
  snapshot.fields.push_back({"determinant_F", false, 1, report.determinant});
  snapshot.fields.push_back({"energy_density", false, 1, report.energy_density});
  snapshot.fields.push_back({"negative_eigenvalues", false, 1, report.negative_eigenvalues});
  snapshot.fields.push_back({"rank", false, 1, ranks});
  PetscCall(write_snapshot(comm, scene.options.output_file, snapshot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
