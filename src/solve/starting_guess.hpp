#pragma once

#include <petscksp.h>

#include "assembly/energy_functional.hpp"
#include "output/progress.hpp"

namespace trefoil {

/// What a starting guess cost.
struct GuessCost {
  PetscInt linear_solves = 0;      ///< with scalar matrices, of one component each
  PetscInt linear_iterations = 0;  ///< of conjugate gradients, in all of them
  PetscInt rotations = 0;          ///< local/global steps
  double seconds = 0;
};

/// Spreads the prescribed displacements over the body: x, at rest, becomes their harmonic
/// extension, and then, after each of `rotation_steps`, as rigid as possible: local/global
/// steps of the energy sum |F - R|^2 (rotations R of the elements, then one solve with Laplace's
/// matrix, which is factored once). Nothing is done where nothing is displaced.
///
/// A start for static problems with prescribed displacements; the minimum that is found from it is
/// one of the same energy.
/// @param iterative by conjugate gradients with multigrid, which Laplace's matrix is made for,
/// instead of Cholesky factors
/// @param H a matrix with the Hessian's pattern; its values are lost
/// Collective. Options of the solver have the prefix guess_.
PetscErrorCode spread_displacements(const EnergyFunctional &functional,
                                    const Discretization &discretization, Mat H,
                                    PetscInt rotation_steps, bool iterative, Progress &progress,
                                    Vec x, GuessCost *cost);

/// Of the residual, where nothing is made of the guess before the energy's own steps.
inline constexpr PetscReal guess_tolerance = 1e-4;

/// A solver for symmetric positive definite matrices, whose options begin with -guess_: direct, or
/// conjugate gradients with multigrid to a tolerance.
PetscErrorCode set_guess_solver(KSP ksp, bool iterative, PetscReal tolerance = guess_tolerance);

}  // namespace trefoil
