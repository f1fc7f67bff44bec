#include "scene/cell_states.hpp"

#include <petscsys.h>

// PETSc's names for LAPACK need the types of the header above.
#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "element/element_energy.hpp"
#include "scene/element_pressure.hpp"
#include "trefoil/deformation.hpp"
#include "trefoil/polar.hpp"

namespace trefoil {
namespace {

IsoparametricElement element_of(const Mesh &mesh, std::size_t cell) {
  const int nodes = mesh.nodes_per_cell();
  const PetscInt *node = &mesh.cells[static_cast<std::size_t>(nodes) * cell];
  double positions[3 * ReferenceElement::most_nodes];
  for (int a = 0; a < nodes; ++a) {
    std::copy_n(&mesh.coordinates[static_cast<std::size_t>(3 * node[a])], 3, positions + 3 * a);
  }
  return {reference_element(mesh.dimension(), nodes), positions};
}

void add(double factor, const Matrix3<double> &A, Matrix3<double> &sum) {
  for (std::size_t k = 0; k < 9; ++k) sum.entries[k] += factor * A.entries[k];
}

}  // namespace

CellStates::CellStates(const Mesh &mesh, const SceneOptions &options,
                       std::vector<int> region_of_cell)
    : mesh_(mesh),
      pressure_(element_pressure(options)),
      region_of_cell_(std::move(region_of_cell)) {
  materials_.push_back(make_material(options.material));
  for (const RegionOptions &region : options.regions) {
    materials_.push_back(make_material(region.material));
  }
}

void CellStates::visit(
    const double *u,
    const std::function<void(std::size_t cell, const CellState &state)> &visitor) const {
  const int nodes = mesh_.nodes_per_cell();
  for (std::size_t c = 0; c < region_of_cell_.size(); ++c) {
    const MaterialModel &material = *materials_[static_cast<std::size_t>(region_of_cell_[c])];
    const IsoparametricElement element = element_of(mesh_, c);
    const PetscInt *node = &mesh_.cells[static_cast<std::size_t>(nodes) * c];
    double displacement[3 * ReferenceElement::most_nodes];
    for (int a = 0; a < nodes; ++a) std::copy_n(u + 3 * node[a], 3, displacement + 3 * a);
    const ElementEnergy energy(element, material, pressure_, displacement);
    CellState state;
    state.least_determinant = std::numeric_limits<double>::infinity();
    for (int q = 0; q < element.reference().points; ++q) {
      const double weight = element.weight(q);
      const Deformation<double> deformation(element.displacement_gradient(q, displacement));
      const Matrix3<double> P = energy.stress(q);
      const double J = deformation.J();
      state.volume += weight;
      state.deformed_volume += weight * J;
      state.least_determinant = std::min(state.least_determinant, J);
      add(weight, deformation.F(), state.F);
      add(weight, P, state.first_piola);
      add(weight, cauchy_stress(deformation, P), state.cauchy);
      add(weight, deformation.green_strain(), state.green_lagrange);
    }
    for (Matrix3<double> *mean :
         {&state.F, &state.first_piola, &state.cauchy, &state.green_lagrange}) {
      for (double &entry : mean->entries) entry /= state.volume;
    }
    visitor(c, state);
  }
}

double CellStates::rest_volume(std::size_t cell) const {
  const IsoparametricElement element = element_of(mesh_, cell);
  double volume = 0;
  for (int q = 0; q < element.reference().points; ++q) volume += element.weight(q);
  return volume;
}

double von_mises(const Matrix3<double> &stress) {
  const double a = stress(0, 0) - stress(1, 1), b = stress(1, 1) - stress(2, 2),
               c = stress(2, 2) - stress(0, 0), xy = stress(0, 1), yz = stress(1, 2),
               xz = stress(0, 2);
  return std::sqrt((a * a + b * b + c * c) / 2 + 3 * (xy * xy + yz * yz + xz * xz));
}

std::array<double, 3> principal_values(const Matrix3<double> &symmetric) {
  constexpr PetscBLASInt size = 3, work_size = 32;
  Matrix3<double> A = symmetric;
  double values[3], work[work_size];
  PetscBLASInt info = 0;
  LAPACKsyev_("N", "U", &size, A.entries.data(), &size, values, work, &work_size, &info);
  if (info != 0) return {std::nan(""), std::nan(""), std::nan("")};
  return {values[2], values[1], values[0]};
}

std::array<double, 3> principal_stretches(const Matrix3<double> &F) {
  return signed_svd(F).stretch;
}

}  // namespace trefoil
