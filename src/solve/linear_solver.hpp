#pragma once

#include <petscsnes.h>

#include <string>

namespace trefoil {

/// What solves a run's linear systems.
struct LinearSolver {
  std::string text;         ///< in words: "Cholesky by cholmod"
  double factor_bytes = 0;  ///< of a direct solver's factor, all ranks; 0: not known
};

/// Says what a SNES that is set up will use.
PetscErrorCode describe_linear_solver(SNES snes, LinearSolver *solver);

/// The same with the size of the factor, which a direct solver's package finds from the pattern of
/// the matrix. Collective.
PetscErrorCode expect_linear_solver(SNES snes, Mat matrix, LinearSolver *solver);

}  // namespace trefoil
