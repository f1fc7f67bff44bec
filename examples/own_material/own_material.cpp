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
// A program of one's own calls trefoil::register_material<Mine>() instead. The functions are
// written once, for numbers and for packs of eight: + - * /, sqrt, log, abs and select() serve
// both. Compiled with -march=native they use what the machine has.

#include "trefoil/material_registry.hpp"
#include "trefoil/volume_term.hpp"

class Mine {
 public:
  static constexpr const char *name = "mine";
  static constexpr bool has_volume_term = true;  // -material_volume is kappa

  // Around F = I, for a small strain e: I1 - 3 = 2 tr e + e:e, J - 1 = tr e + (tr^2 e - e:e)/2. So
  // psi = mu e:e + (mu/5 - mu/2 + kappa/2) tr^2 e; Hooke's law has mu e:e + lambda/2 tr^2 e.
  explicit Mine(const trefoil::MaterialParameters &parameters)
      : mu_(parameters.constants.mu()),
        volume_(parameters.volume_weight(name, parameters.constants.lambda() + 0.6 * mu_), mu_) {}

  template <class Real>
  Real energy_density(const trefoil::Matrix3<Real> &F) const {
    const Real change = squared_norm(F) - 3.0;
    return (0.5 * mu_ + 0.05 * mu_ * change) * change + volume_.energy_density(F);
  }

  // dI1/dF = 2 F
  template <class Real>
  trefoil::Matrix3<Real> stress(const trefoil::Matrix3<Real> &F) const {
    const Real slope = mu_ + 0.2 * mu_ * (squared_norm(F) - 3.0);
    trefoil::Matrix3<Real> P;
    for (std::size_t k = 0; k < 9; ++k) P.entries[k] = slope * F.entries[k];
    volume_.add_stress(F, P);
    return P;
  }

  template <class Real>
  void tangent(const trefoil::Matrix3<Real> &F, trefoil::Tangent<Real> &A) const {
    A.fill(Real(0.0));
    trefoil::add_identity(mu_ + 0.2 * mu_ * (squared_norm(F) - 3.0), A);
    trefoil::add_square(0.4 * mu_, F, A);
    volume_.add_tangent(F, A);
  }

 private:
  double mu_;
  trefoil::VolumeTerm volume_;
};

// PETSc calls this when it loads libown_material.so.
extern "C" int PetscDLLibraryRegister_own_material() {
  trefoil::register_material<Mine>();
  return 0;
}
