#pragma once

#include <concepts>
#include <optional>
#include <string>

#include "trefoil/deformation.hpp"
#include "trefoil/pack.hpp"

namespace trefoil {

/// Isotropic elastic constants of a body at small strain.
struct ElasticConstants {
  double young = 0;    ///< Young's modulus E > 0, force per area
  double poisson = 0;  ///< Poisson's ratio, -1 < nu < 1/2

  /// E and nu of Lame's constants: mu > 0 and lambda > -2 mu / 3, force per area.
  static ElasticConstants from_lame(double mu, double lambda) {
    return {mu * (3 * lambda + 2 * mu) / (lambda + mu), lambda / (2 * (lambda + mu))};
  }
  /// First Lame constant, E nu / ((1 + nu)(1 - 2 nu)).
  [[nodiscard]] double lambda() const {
    return young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  }
  /// Shear modulus, E / (2 (1 + nu)).
  [[nodiscard]] double mu() const { return young / (2 * (1 + poisson)); }
};

/// How E and nu become mu and lambda of a stable Neo-Hookean energy.
enum class Lame {
  physical,  ///< lambda = lambda_Lame + mu, so that small strains obey E and nu
  raw        ///< lambda = lambda_Lame, as Chen et al. 2024 use it; needs nu > 0
};

/// What a user says about a material. Each material makes its own constants from it.
struct MaterialParameters {
  ElasticConstants constants;
  /// Weight kappa >= 0, force per area, of the term kappa/2 (J - 1)^2 in the energies that have
  /// one. Absent: what makes small strains obey E and nu.
  std::optional<double> volume = std::nullopt;
  Lame lame = Lame::physical;
  /// Mooney-Rivlin: the part of the shear modulus that comes from the second invariant, 0 to 1.
  /// Absent: half of it.
  std::optional<double> second_invariant = std::nullopt;

  /// kappa as the user gives it, else `suggested`. InputError where that is negative: the energy
  /// would have no least value.
  [[nodiscard]] double volume_weight(const std::string &material, double suggested) const;
  /// Lame's lambda; InputError where it is negative.
  [[nodiscard]] double nonnegative_lambda(const std::string &material) const;
};

/// Stands for packs of all instruction sets in what is asked of a material.
using AnyPack = Pack<InstructionSet::baseline>;

/// What a material supplies: energy density psi(F) per rest volume, 0 at rest; first
/// Piola-Kirchhoff stress P = dpsi/dF; and tangent A = dP/dF, all of it written. Templates, for
/// packs of any instruction set. A material knows no element. It is copied about, and read by
/// several threads at once.
///
/// It may also have rest_energy_density(), where its formula as it is known is not 0 at rest:
/// reported energies have it added.
template <class M>
concept Material = requires(const M &material, const Deformation<AnyPack> &F, Tangent<AnyPack> &A) {
  { material.energy_density(F) } -> std::same_as<AnyPack>;
  { material.stress(F) } -> std::same_as<Matrix3<AnyPack>>;
  {material.tangent(F, A)};
};

/// An isotropic material may offer its energy as one of invariants as well. They are polynomials in
/// a plane of deformations, where its energy then costs little.
template <class M>
concept HasEnergyOfInvariants = requires(const M &material, const Invariants<AnyPack> &invariants) {
  { material.energy_of_invariants(invariants) } -> std::same_as<AnyPack>;
};

/// A material of which elements may take a part of the volumetric energy at their mean of J: a
/// SplitMaterial that knows its shear modulus.
template <class M>
concept VolumeSplittingMaterial = Material<M> &&
    requires(const M &material, const AnyPack &J_minus_1) {
  typename M::PointwisePart;
  { material.mu() } -> std::convertible_to<double>;
  {material.mean_law(J_minus_1)};
};

/// A material that scenes may ask for: it has a name, and makes itself of what the user says.
template <class M>
concept SceneMaterial = Material<M> && std::constructible_from<M, MaterialParameters> && requires {
  { M::name } -> std::convertible_to<std::string>;
};

}  // namespace trefoil
