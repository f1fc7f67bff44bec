#include "element/element_energy.hpp"

#include <limits>
#include <vector>

#include "trefoil/deformation.hpp"
#include "trefoil/tangent_terms.hpp"

namespace trefoil {

ElementEnergy::ElementEnergy(const IsoparametricElement &element, const MaterialModel &material,
                             ElementPressure pressure, const double *displacements)
    : element_(element),
      on_mean_(pressure == ElementPressure::constant),
      at_points_(on_mean_ ? material.pointwise() : material),
      points_(element.reference().points) {
  double volume_change = 0;
  for (int q = 0; q < points_; ++q) {
    H_[q] = element.displacement_gradient(q, displacements);
    volume_ += element.weight(q);
    volume_change += element.weight(q) * Deformation<double>(H_[q]).J_minus_1();
  }
  if (on_mean_) law_ = material.mean_law(volume_change / volume_);
}

double ElementEnergy::energy() const {
  double sum = volume_ * law_.energy;
  for (int q = 0; q < points_; ++q) sum += element_.weight(q) * at_points_.energy_density(H_[q]);
  return sum;
}

double ElementEnergy::least_jacobian() const {
  double least = std::numeric_limits<double>::infinity();
  for (int q = 0; q < points_; ++q) {
    const double J = Deformation<double>(H_[q]).J();
    if (!(J >= least)) least = J;
  }
  return least;
}

Matrix3<double> ElementEnergy::stress(int point) const {
  Matrix3<double> P = at_points_.stress(H_[point]);
  const Matrix3<double> C = Deformation<double>(H_[point]).cofactor();
  for (std::size_t k = 0; k < 9; ++k) P.entries[k] += law_.slope * C.entries[k];
  return P;
}

void ElementEnergy::add_force(double *force) const {
  for (int q = 0; q < points_; ++q) element_.add_force(q, stress(q), force);
}

void ElementEnergy::add_hessian(double *hessian) const {
  for (int q = 0; q < points_; ++q) {
    Tangent<double> A;
    at_points_.tangent(H_[q], A);
    add_cofactor_derivative(law_.slope, Deformation<double>(H_[q]).F(), A);
    element_.add_hessian(q, A, hessian);
  }
  if (on_mean_) add_mean_stiffness(hessian);
}

void ElementEnergy::add_mean_stiffness(double *hessian) const {
  const int nodes = element_.reference().nodes, dim = element_.reference().dimension;
  std::vector<double> volume_slope(static_cast<std::size_t>(3 * nodes), 0);  // d(V theta)/du
  for (int q = 0; q < points_; ++q) {
    element_.add_force(q, Deformation<double>(H_[q]).cofactor(), volume_slope.data());
  }
  const auto of_row = [&](int r) {
    return volume_slope[static_cast<std::size_t>(3 * (r / dim) + r % dim)];
  };
  for (int r = 0, rows = dim * nodes; r < rows; ++r) {
    for (int s = 0; s < rows; ++s) {
      hessian[rows * r + s] += law_.curvature / volume_ * of_row(r) * of_row(s);
    }
  }
}

}  // namespace trefoil
