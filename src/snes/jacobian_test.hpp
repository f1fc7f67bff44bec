#pragma once

#include <petscsnes.h>

#include <string>

namespace trefoil {

/// PETSc's own test of Jacobians by finite differences, -snes_test_jacobian, which looks at the
/// matrix after the callback: a right Jacobian H would fail it as H + 2 w N. So it is run here
/// while the matrix is H, and PETSc is kept from running it once more.
class JacobianTest {
 public:
  /// Whether the next Jacobian will be tested.
  static PetscErrorCode is_wanted(SNES snes, bool *wanted);
  /// Runs the test where the user wants it. Collective.
  PetscErrorCode run(SNES snes);
  /// Gives PETSc the option back.
  PetscErrorCode restore(SNES snes);

 private:
  bool hidden_ = false;
  std::string value_;
};

}  // namespace trefoil
