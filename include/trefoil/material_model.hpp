#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "trefoil/packed_functions.hpp"

namespace trefoil {

/// A material whose type is known at run time only. Deformations come as displacement gradients
/// H = F - I.
class MaterialModel {
 public:
  /// @param material what the functions take
  /// @param rest_energy_density what they leave out of psi: psi(I)
  /// @param pointwise what of psi stays at the points, where functions.pointwise does not say it
  MaterialModel(const PackedFunctions &functions, std::shared_ptr<const void> material,
                double rest_energy_density = 0,
                std::shared_ptr<const MaterialModel> pointwise = nullptr)
      : functions_(functions),
        material_(std::move(material)),
        rest_energy_density_(rest_energy_density),
        pointwise_(std::move(pointwise)) {
    if (functions.pointwise != nullptr) {
      pointwise_ = std::make_shared<MaterialModel>(*functions.pointwise, material_);
    }
  }

  /// For the eight lanes of a pack, see PackedFunctions for the arrays.
  void energy_densities(const double *H, double *psi) const {
    functions_.energy_density(material_.get(), H, psi);
  }
  void energy_changes(const double *H, const double *D, const double *S,
                      std::span<const PlanePoint> points, const double *weight,
                      double *sums) const {
    functions_.energy_changes(material_.get(), H, D, S, points, weight, sums);
  }
  void stresses(const double *H, double *P) const { functions_.stress(material_.get(), H, P); }
  void tangents(const double *H, double *A) const { functions_.tangent(material_.get(), H, A); }

  /// Whether elements may take a part s U of psi at their mean of J, see SplitMaterial.
  [[nodiscard]] bool splits_volume() const { return pointwise_ != nullptr; }
  /// What stays at the points, psi - s U, and s U with its derivatives: all of psi and nothing
  /// where the material does not split.
  [[nodiscard]] const MaterialModel &pointwise() const { return pointwise_ ? *pointwise_ : *this; }
  void mean_laws(const double *J_minus_1, double *law) const {
    if (functions_.mean_law == nullptr) {
      std::fill_n(law, 3 * lanes, 0.0);
    } else {
      functions_.mean_law(material_.get(), J_minus_1, law);
    }
  }

  /// For one deformation, at the price of eight: psi(F) - psi(I), energy per rest volume.
  [[nodiscard]] double energy_density(const Matrix3<double> &H) const;
  /// The first Piola-Kirchhoff stress P = dpsi/dF.
  [[nodiscard]] Matrix3<double> stress(const Matrix3<double> &H) const;
  /// The Cauchy stress P F' / J.
  [[nodiscard]] Matrix3<double> cauchy_stress(const Matrix3<double> &H) const;
  /// A = dP/dF.
  void tangent(const Matrix3<double> &H, Tangent<double> &A) const;
  /// s U and its derivatives at J; see mean_laws().
  [[nodiscard]] VolumetricLaw<double> mean_law(double J_minus_1) const;

  /// psi(I) of the formula as it is known.
  [[nodiscard]] double rest_energy_density() const { return rest_energy_density_; }

 private:
  PackedFunctions functions_;
  std::shared_ptr<const void> material_;
  double rest_energy_density_;
  std::shared_ptr<const MaterialModel> pointwise_;
};

/// The functions of M for an instruction set: those that M offers as a static member
/// packed_functions(), as the library's own materials do; else compiled here, where only what the
/// compiler was told to use is used.
template <Material M>
PackedFunctions packed_functions_of(InstructionSet instructions) {
  if constexpr (requires { M::packed_functions(instructions); }) {
    return M::packed_functions(instructions);
  } else {
    return make_packed_functions<M, InstructionSet::baseline>();
  }
}

/// A model that owns a copy of the material, with kernels for the chosen instruction set.
template <Material M>
std::unique_ptr<MaterialModel> make_material_model(
    const M &material, InstructionSet instructions = chosen_instruction_set()) {
  double rest_energy_density = 0;
  if constexpr (requires { material.rest_energy_density(); }) {
    rest_energy_density = material.rest_energy_density();
  }
  return std::make_unique<MaterialModel>(packed_functions_of<M>(instructions),
                                         std::make_shared<M>(material), rest_energy_density);
}

}  // namespace trefoil
