#include <algorithm>

#include "output/mesh_output.hpp"
#include "output/result.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"

namespace trefoil {

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
  std::vector<Field> fields;
  EnergyFunctional::CellReport report;
  PetscFunctionBeginUser;
  if (scene.options.output_file.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(scene.discretization.get_local(scene.displacement, &local, &u));
  fields.push_back({"displacement", true, 3, values_of_owned(scene.mesh, u, 3)});
  PetscCall(scene.discretization.restore_local(&local, &u));
  PetscCall(scene.functional->describe_cells(scene.displacement, &report));
  const std::vector<double> ranks(static_cast<std::size_t>(scene.mesh.local_cells()), rank);
  fields.push_back({"determinant_F", false, 1, report.determinant});
  fields.push_back({"energy_density", false, 1, report.energy_density});
  fields.push_back({"negative_eigenvalues", false, 1, report.negative_eigenvalues});
  fields.push_back({"rank", false, 1, ranks});
  PetscCall(add_original_vertices(scene.mesh, &fields));
  PetscCall(write_snapshot(comm, scene.options.output_file, output_of(scene.mesh), fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
