#include "mesh/mesh.hpp"

#include <limits>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

Mesh::~Mesh() {
  static_cast<void>(DMDestroy(&dm));  // an error has nowhere to go from here
}

double Mesh::bytes() const {
  return static_cast<double>((cells.capacity() + global_vertex.capacity()) * sizeof(PetscInt) +
                             coordinates.capacity() * sizeof(double) + owned.capacity() +
                             groups.capacity() * sizeof(PetscInt));
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
