#include "mesh/mesh.hpp"

#include <limits>

#include "petsc_compatibility.hpp"

namespace trefoil {

Mesh::~Mesh() {
  static_cast<void>(DMDestroy(&dm));  // an error has nowhere to go from here
}

double Mesh::bytes() const {
  return static_cast<double>((cells.capacity() + global_vertex.capacity()) * sizeof(PetscInt) +
                             coordinates.capacity() * sizeof(double) + owned.capacity() +
                             groups.capacity() * sizeof(PetscInt));
}

}  // namespace trefoil
