#include "mesh/mesh.hpp"

#include <limits>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

Mesh::~Mesh() {
  static_cast<void>(DMDestroy(&dm));  // an error has nowhere to go from here
}

double Mesh::bytes() const {
  std::size_t numbers = cells.capacity() + global_vertex.capacity() + vertex_number.capacity() +
                        cell_number.capacity() + part.capacity() + groups.set_of_cell.capacity();
  for (const GroupedEntities &entities : groups.below) {
    numbers += entities.vertices.capacity() + entities.sets.capacity();
  }
  return static_cast<double>(numbers * sizeof(PetscInt) + coordinates.capacity() * sizeof(double) +
                             owned.capacity());
}

std::array<double, 3> centroid_of_cell(const Mesh &mesh, std::size_t cell) {
  std::array<double, 3> sum{};
  const int corners = mesh.shape->corners;
  for (std::size_t a = 0; a < static_cast<std::size_t>(corners); ++a) {
    const auto vertex = static_cast<std::size_t>(
        mesh.cells[static_cast<std::size_t>(mesh.nodes_per_cell()) * cell + a]);
    for (std::size_t i = 0; i < 3; ++i) sum[i] += mesh.coordinates[3 * vertex + i] / corners;
  }
  return sum;
}

}  // namespace trefoil
