#include "scene/cell_tensors.hpp"

#include <algorithm>
#include <array>

#include "mesh/boundary.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// All entries of the tensors, and the volume they stand for: rounded up to whole vectors.
constexpr std::size_t entries = 36, vectors = entries / 3 + 1;

std::array<double, 3 * vectors> as_numbers(const MeanTensors &tensors, double volume) {
  std::array<double, 3 * vectors> numbers{};
  std::size_t k = 0;
  for (const Matrix3<double> *tensor :
       {&tensors.F, &tensors.first_piola, &tensors.cauchy, &tensors.green_lagrange}) {
    for (const double entry : tensor->entries) numbers[k++] = volume * entry;
  }
  numbers[k] = volume;
  return numbers;
}

MeanTensors as_tensors(const std::array<double, 3 * vectors> &numbers) {
  MeanTensors tensors;
  std::size_t k = 0;
  for (Matrix3<double> *tensor :
       {&tensors.F, &tensors.first_piola, &tensors.cauchy, &tensors.green_lagrange}) {
    for (double &entry : tensor->entries) entry = numbers[k++] / numbers[entries];
  }
  return tensors;
}

/// Sums over the cells of one region around each vertex; on return complete at its owner.
class VertexSums {
 public:
  explicit VertexSums(const Mesh &mesh)
      : mesh_(mesh), sums_(vectors, std::vector<double>(mesh.coordinates.size(), 0)) {}

  void add(std::size_t cell, const std::array<double, 3 * vectors> &numbers) {
    const auto nodes = static_cast<std::size_t>(mesh_.nodes_per_cell());
    for (std::size_t a = 0; a < nodes; ++a) {
      const auto v = static_cast<std::size_t>(mesh_.cells[nodes * cell + a]);
      for (std::size_t k = 0; k < numbers.size(); ++k) sums_[k / 3][3 * v + k % 3] += numbers[k];
    }
  }
  PetscErrorCode complete() {
    PetscFunctionBeginUser;
    for (std::vector<double> &sum : sums_) PetscCall(sum_at_owners(mesh_, &sum));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  [[nodiscard]] std::array<double, 3 * vectors> of(std::size_t vertex) const {
    std::array<double, 3 * vectors> numbers{};
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      numbers[k] = sums_[k / 3][3 * vertex + k % 3];
    }
    return numbers;
  }

 private:
  const Mesh &mesh_;
  std::vector<std::vector<double>> sums_;
};

}  // namespace

PetscErrorCode compute_mean_tensors(const Mesh &mesh, const CellStates &cells, const double *u,
                                    std::vector<MeanTensors> *of_cells,
                                    std::vector<MeanTensors> *of_vertices) {
  const std::vector<int> &region_of_cell = cells.region_of_cell();
  std::vector<double> volumes;
  std::vector<double> stress(mesh.owned.size(), -1);
  std::vector<MeanTensors> best(mesh.owned.size());
  PetscFunctionBeginUser;
  of_cells->clear();
  cells.visit(u, [&](std::size_t, const CellState &state) {
    of_cells->push_back({state.F, state.first_piola, state.cauchy, state.green_lagrange});
    volumes.push_back(state.volume);
  });
  for (int region = 0; region < cells.regions(); ++region) {
    VertexSums sums(mesh);
    for (std::size_t c = 0; c < region_of_cell.size(); ++c) {
      if (region_of_cell[c] == region) sums.add(c, as_numbers((*of_cells)[c], volumes[c]));
    }
    PetscCall(sums.complete());
    for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
      const auto numbers = sums.of(v);
      if (!mesh.owned[v] || !(numbers[entries] > 0)) continue;
      const MeanTensors mean = as_tensors(numbers);
      const double equivalent = von_mises(mean.cauchy);
      if (equivalent <= stress[v]) continue;
      stress[v] = equivalent;
      best[v] = mean;
    }
  }
  of_vertices->clear();
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (mesh.owned[v]) of_vertices->push_back(best[v]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
