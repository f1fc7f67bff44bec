#include "output/mesh_fingerprint.hpp"

#include <cmath>

#include "support/petsc_compatibility.hpp"
#include "support/split_mix.hpp"

namespace trefoil {
namespace {

std::uint64_t hash_of_cells(const Mesh &mesh) {
  const auto nodes = static_cast<std::size_t>(mesh.nodes_per_cell());
  std::uint64_t sum = 0;  // of all cells, in any order
  for (std::size_t c = 0; c < mesh.cell_number.size(); ++c) {
    std::uint64_t hash = mixed(static_cast<std::uint64_t>(mesh.cell_number[c]));
    for (std::size_t a = 0; a < nodes; ++a) {
      const auto vertex = static_cast<std::size_t>(mesh.cells[nodes * c + a]);
      hash = mixed(hash ^ static_cast<std::uint64_t>(mesh.vertex_number[vertex]));
    }
    sum += hash;
  }
  return sum;
}

}  // namespace

PetscErrorCode MeshFingerprint::take(const Mesh &mesh) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  std::array<double, 4> sums{};
  PetscFunctionBeginUser;
  element = mesh.element_name();
  vertices = mesh.total_vertices;
  cells = mesh.total_cells;
  connectivity = hash_of_cells(mesh);
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (!mesh.owned[v]) continue;
    const double weight = random_number(mesh.vertex_number[v]);
    for (std::size_t i = 0; i < 3; ++i) {
      const double x = mesh.coordinates[3 * v + i];
      sums[i] += weight * x;
      sums[3] += std::abs(weight * x);
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &connectivity, 1, MPI_UINT64_T, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums.data(), 4, MPI_DOUBLE, MPI_SUM, comm));
  coordinates = {sums[0], sums[1], sums[2]};
  size = sums[3];
  PetscFunctionReturn(PETSC_SUCCESS);
}

nlohmann::ordered_json MeshFingerprint::json() const {
  return {{"element", element},           {"vertices", vertices},       {"cells", cells},
          {"connectivity", connectivity}, {"coordinates", coordinates}, {"size", size}};
}

std::string MeshFingerprint::difference(const nlohmann::ordered_json &other) const {
  constexpr double rounding = 1e-12;
  const auto its_element = other.at("element").get<std::string>();
  if (its_element != element) return "cells there are " + its_element + ", here " + element;
  const auto its_vertices = other.at("vertices").get<PetscInt>();
  const auto its_cells = other.at("cells").get<PetscInt>();
  if (its_vertices != vertices || its_cells != cells) {
    return std::to_string(its_vertices) + " vertices and " + std::to_string(its_cells) +
           " cells there, " + std::to_string(vertices) + " and " + std::to_string(cells) + " here";
  }
  if (other.at("connectivity").get<std::uint64_t>() != connectivity) {
    return "as many cells there as here, but of other vertices";
  }
  const auto its_coordinates = other.at("coordinates").get<std::array<double, 3>>();
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(its_coordinates[i] - coordinates[i]) > rounding * size) {
      return "the same cells there as here, but vertices in other places";
    }
  }
  return "";
}

}  // namespace trefoil
