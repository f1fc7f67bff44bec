#include "output/mesh_output.hpp"

#include <algorithm>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

OutputMesh output_of(const Mesh &mesh) {
  OutputMesh output;
  output.shape = mesh.shape;
  output.points = values_of_owned(mesh, mesh.coordinates.data(), 3);
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (mesh.owned[v]) output.point_numbers.push_back(mesh.vertex_number[v]);
  }
  output.cells.reserve(mesh.cells.size());
  for (const PetscInt vertex : mesh.cells) {
    output.cells.push_back(mesh.vertex_number[static_cast<std::size_t>(vertex)]);
  }
  output.cell_numbers = mesh.cell_number;
  return output;
}

std::vector<double> values_of_owned(const Mesh &mesh, const double *values, int components) {
  std::vector<double> owned;
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    const double *row = values + static_cast<std::size_t>(components) * v;
    if (mesh.owned[v]) owned.insert(owned.end(), row, row + components);
  }
  return owned;
}

PetscErrorCode add_original_vertices(const Mesh &mesh, std::vector<Field> *fields) {
  Field original{"original_vertex", true, 1, {}};
  PetscFunctionBeginUser;
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (!mesh.owned[v]) continue;
    const PetscInt number = mesh.vertex_number[v];
    original.values.push_back(number < mesh.file_vertices ? static_cast<double>(number) : -1);
  }
  auto of_file = static_cast<PetscInt>(
      original.values.size() -
      static_cast<std::size_t>(std::count(original.values.begin(), original.values.end(), -1)));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &of_file, 1, MPIU_INT, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm))));
  const bool is_as_in_file = of_file == mesh.file_vertices && of_file == mesh.total_vertices;
  if (!is_as_in_file) fields->push_back(std::move(original));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
