// A material of one's own in one file: a rubber that stiffens as it is stretched (Yeoh 1993, two
// terms of the first invariant), finite for every F.
//
//   psi(F) = mu/2 (I1 - 3) + mu/20 (I1 - 3)^2 - mu (J - 1) + kappa/2 (J - 1)^2,
//   I1 = F:F,  J = det F
//
// The term linear in J makes the rest state free of stress. Built as a shared library and loaded by
// name:
//
//   cmake -S examples/own_material -B build/own_material -Dtrefoil_DIR=<prefix>/lib/cmake/trefoil
//   cmake --build build/own_material
//   build/trefoil -options_file examples/knot.yaml -material_model mine
//     -dll_append build/own_material/libown_material.so         (both on one line)
//
// A program of one's own calls trefoil::register_material<Mine>() instead.
//
// `Real` is a pack of eight numbers, with which one calculates as with one: + - * /, comparisons
// with select(where, a, b) in place of a branch, min, max, abs, sqrt, log, log1p, exp, expm1, pow,
// cbrt, and by_lane(f, x) for any other function of a number. Compiled with -march=native they use
// what the machine has.
//
// What is 0 at rest is taken from the Deformation as it is, and never as F:F - 3 or det F - 1:
// small strains would lose their digits. So here
//
//   mu/2 (I1 - 3) - mu (J - 1) = mu/2 I1_distortion()
//
// whose two parts balance each other at rest. A logarithm is log1p(J_minus_1()), and log J - (J -
// 1) is log1pmx(J_minus_1()) of trefoil/log1pmx.hpp.

#include "trefoil/material_registry.hpp"
#include "trefoil/split_material.hpp"

// A sum psi = W(F) + U(J): the base makes energy, stress and tangent of the parts. A material that
// is no such sum has energy_density(), stress() and tangent() itself, see trefoil/material.hpp.
class Mine : public trefoil::SplitMaterial<Mine> {
 public:
  static constexpr const char *name = "mine";
  static constexpr bool has_volume_term = true;  // -material_volume is kappa

  // Around F = I, for a small strain e: I1 - 3 = 2 tr e + e:e, J - 1 = tr e + (tr^2 e - e:e)/2. So
  // psi = mu e:e + (mu/5 - mu/2 + kappa/2) tr^2 e; Hooke's law has mu e:e + lambda/2 tr^2 e.
  explicit Mine(const trefoil::MaterialParameters &parameters)
      : mu_(parameters.constants.mu()),
        kappa_(parameters.volume_weight(name, parameters.constants.lambda() + 0.6 * mu_)) {}

  // U(J) = kappa/2 (J - 1)^2, with its first and second derivative.
  template <class Real>
  trefoil::VolumetricLaw<Real> volumetric_law(const Real &J_minus_1) const {
    return {0.5 * kappa_ * J_minus_1 * J_minus_1, kappa_ * J_minus_1, kappa_};
  }

  // The shear modulus at small strains.
  double mu() const { return mu_; }

  // W = mu/2 (I1 - 3 - 2 (J - 1)) + mu/20 (I1 - 3)^2
  template <class Real>
  Real distortional_energy(const trefoil::Deformation<Real> &deformation) const {
    const Real stretch = deformation.I1_minus_3();
    return 0.5 * mu_ * deformation.I1_distortion() + 0.05 * mu_ * stretch * stretch;
  }

  // dW/dF + p cof F, with dI1/dF = 2 F and dJ/dF = cof F
  template <class Real>
  trefoil::Matrix3<Real> stress_at_pressure(const trefoil::Deformation<Real> &deformation,
                                            const Real &p) const {
    const Real slope = 0.2 * mu_ * deformation.I1_minus_3();
    const auto D = deformation.F_minus_cofactor(), F = deformation.F(), C = deformation.cofactor();
    trefoil::Matrix3<Real> P;
    for (std::size_t k = 0; k < 9; ++k) {
      P.entries[k] = mu_ * D.entries[k] + slope * F.entries[k] + p * C.entries[k];
    }
    return P;
  }

  // A += d^2W/dF^2 + p d(cof F)/dF
  template <class Real>
  void add_tangent_at_pressure(const trefoil::Deformation<Real> &deformation, const Real &p,
                               trefoil::Tangent<Real> &A) const {
    const trefoil::Matrix3<Real> F = deformation.F();
    trefoil::add_identity(mu_ + 0.2 * mu_ * deformation.I1_minus_3(), A);
    trefoil::add_square(0.4 * mu_, F, A);
    trefoil::add_cofactor_derivative(p - mu_, F, A);
  }

 private:
  double mu_, kappa_;
};

// PETSc calls this when it loads libown_material.so.
extern "C" int PetscDLLibraryRegister_own_material() {
  trefoil::register_material<Mine>();
  return 0;
}
