#include "trefoil/material_model.hpp"

#include <algorithm>

namespace trefoil {
namespace {

/// The result of a packed function for numbers that all lanes share.
template <std::size_t size, std::size_t inputs, class Function>
std::array<double, size> in_one_lane(const std::array<double, inputs> &input,
                                     const Function &function) {
  alignas(64) double copies[inputs * lanes], results[size * lanes];
  for (std::size_t k = 0; k < inputs; ++k) std::fill_n(copies + lanes * k, lanes, input[k]);
  function(copies, results);
  std::array<double, size> result;
  for (std::size_t k = 0; k < size; ++k) result[k] = results[lanes * k];
  return result;
}

}  // namespace

double MaterialModel::energy_density(const Matrix3<double> &H) const {
  return in_one_lane<1>(H.entries,
                        [this](const double *in, double *psi) { energy_densities(in, psi); })[0];
}

Matrix3<double> MaterialModel::stress(const Matrix3<double> &H) const {
  return {in_one_lane<9>(H.entries, [this](const double *in, double *P) { stresses(in, P); })};
}

Matrix3<double> MaterialModel::cauchy_stress(const Matrix3<double> &H) const {
  return trefoil::cauchy_stress(Deformation<double>(H), stress(H));
}

void MaterialModel::tangent(const Matrix3<double> &H, Tangent<double> &A) const {
  A = in_one_lane<81>(H.entries, [this](const double *in, double *out) { tangents(in, out); });
}

VolumetricLaw<double> MaterialModel::mean_law(double J_minus_1) const {
  const auto law =
      in_one_lane<3, 1>({J_minus_1}, [this](const double *in, double *out) { mean_laws(in, out); });
  return {law[0], law[1], law[2]};
}

}  // namespace trefoil
