#pragma once

#include <concepts>

#include "material/matrix3.hpp"

namespace trefoil {

/// Isotropic elastic constants of a body at small strain.
struct ElasticConstants {
  double young = 0;    ///< Young's modulus E > 0, force per area
  double poisson = 0;  ///< Poisson's ratio, -1 < nu < 1/2

  /// First Lame constant, E nu / ((1 + nu)(1 - 2 nu)).
  [[nodiscard]] double lambda() const {
    return young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  }
  /// Shear modulus, E / (2 (1 + nu)).
  [[nodiscard]] double mu() const { return young / (2 * (1 + poisson)); }
};

/// What a material supplies: energy density psi(F) per rest volume, first Piola-Kirchhoff stress
/// P = dpsi/dF and tangent dP/dF, for a number or a pack of numbers. A material knows no element.
template <class M>
concept Material = requires(const M &material, const Matrix3<double> &F, Tangent<double> &tangent) {
  { material.energy_density(F) } -> std::same_as<double>;
  { material.stress(F) } -> std::same_as<Matrix3<double>>;
  {material.tangent(F, tangent)};
};

}  // namespace trefoil
