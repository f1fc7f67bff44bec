#pragma once

#include <memory>
#include <utility>

#include "trefoil/packed_functions.hpp"

namespace trefoil {

/// A material whose type is known at run time only.
class MaterialModel {
 public:
  /// @param material what the functions take
  MaterialModel(const PackedFunctions &functions, std::shared_ptr<const void> material)
      : functions_(functions), material_(std::move(material)) {}

  /// For the eight lanes of a pack, see PackedFunctions for the arrays.
  void energy_densities(const double *F, double *psi) const {
    functions_.energy_density(material_.get(), F, psi);
  }
  void stresses(const double *F, double *P) const { functions_.stress(material_.get(), F, P); }
  void tangents(const double *F, double *A) const { functions_.tangent(material_.get(), F, A); }

  /// The same for one deformation gradient, at the price of eight: psi(F), energy per rest volume.
  [[nodiscard]] double energy_density(const Matrix3<double> &F) const;
  /// The first Piola-Kirchhoff stress P = dpsi/dF.
  [[nodiscard]] Matrix3<double> stress(const Matrix3<double> &F) const;
  /// dP/dF.
  void tangent(const Matrix3<double> &F, Tangent<double> &A) const;

 private:
  PackedFunctions functions_;
  std::shared_ptr<const void> material_;
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
  return std::make_unique<MaterialModel>(packed_functions_of<M>(instructions),
                                         std::make_shared<M>(material));
}

}  // namespace trefoil
