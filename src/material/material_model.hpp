#pragma once

#include <memory>

#include "material/packed_functions.hpp"

namespace trefoil {

/// A material whose type is known at run time only: one deformation gradient at a time for the
/// plain path and for output, eight at a time for the kernels.
class MaterialModel {
 public:
  explicit MaterialModel(const PackedFunctions &functions) : functions_(functions) {}
  virtual ~MaterialModel();

  /// psi(F), energy per rest volume.
  [[nodiscard]] virtual double energy_density(const Matrix3<double> &F) const = 0;
  /// The first Piola-Kirchhoff stress P = dpsi/dF.
  [[nodiscard]] virtual Matrix3<double> stress(const Matrix3<double> &F) const = 0;
  /// dP/dF.
  virtual void tangent(const Matrix3<double> &F, Tangent<double> &A) const = 0;

  /// The same for the eight lanes of a pack, see PackedFunctions for the arrays.
  void energy_densities(const double *F, double *psi) const {
    functions_.energy_density(data(), F, psi);
  }
  void stresses(const double *F, double *P) const { functions_.stress(data(), F, P); }
  void tangents(const double *F, double *A) const { functions_.tangent(data(), F, A); }

 private:
  [[nodiscard]] virtual const void *data() const = 0;
  PackedFunctions functions_;
};

/// The functions of M for an instruction set: from the library where it has compiled them, else
/// compiled here, without more than the compiler's own instruction set.
template <Material M>
PackedFunctions packed_functions(InstructionSet instructions);

/// A model that owns a copy of the material, with kernels for the chosen instruction set.
template <Material M>
std::unique_ptr<MaterialModel> make_material_model(
    const M &material, InstructionSet instructions = chosen_instruction_set());

// ---- implementation of the templates

/// Position of a type in a tuple's list; the length where it is not in it.
template <class M, class... Others>
constexpr std::size_t position_in(std::tuple<Others...> *) {
  std::size_t position = 0;
  static_cast<void>(((std::is_same_v<M, Others> ? false : (++position, true)) && ...));
  return position;
}

/// packed_functions_table() of an instruction set that is not known when compiling.
const PackedFunctions *find_packed_functions_table(InstructionSet instructions);

template <Material M>
PackedFunctions packed_functions(InstructionSet instructions) {
  constexpr std::size_t position = position_in<M>(static_cast<MaterialList *>(nullptr));
  if constexpr (position < std::tuple_size_v<MaterialList>) {
    return find_packed_functions_table(instructions)[position];
  } else {
    return make_packed_functions<M, InstructionSet::baseline>();
  }
}

template <Material M>
class MaterialModelOf final : public MaterialModel {
 public:
  MaterialModelOf(const M &material, InstructionSet instructions)
      : MaterialModel(packed_functions<M>(instructions)), material_(material) {}
  [[nodiscard]] double energy_density(const Matrix3<double> &F) const override {
    return material_.energy_density(F);
  }
  [[nodiscard]] Matrix3<double> stress(const Matrix3<double> &F) const override {
    return material_.stress(F);
  }
  void tangent(const Matrix3<double> &F, Tangent<double> &A) const override {
    material_.tangent(F, A);
  }

 private:
  [[nodiscard]] const void *data() const override { return &material_; }
  M material_;
};

template <Material M>
std::unique_ptr<MaterialModel> make_material_model(const M &material, InstructionSet instructions) {
  return std::make_unique<MaterialModelOf<M>>(material, instructions);
}

}  // namespace trefoil
