#pragma once

#include <petscsnes.h>

#include "scene/solver_choice.hpp"

namespace trefoil {

struct Scene;

/// Chooses the scene's linear solver, by choose_solver() unless -pc_type is given: `cholesky` and
/// `lu` are the direct solver, `gamg`, and `mg` with quadratic elements, the iterative one.
/// Collective.
PetscErrorCode choose_linear_solver(const Scene &scene, SolverChoice *choice);

/// What the plugin's options are by default beside it, before the SNES reads its options.
PetscErrorCode set_defaults_of_linear_solver(const SolverChoice &choice, SNES snes);

/// Sets the scene's choice for a SNES that has read its options; then -ksp_* and -pc_*.
///
/// - direct: CHOLMOD on one rank, MUMPS on several, and MUMPS where the matrix may be indefinite,
///   which it survives and CHOLMOD does not, unless the rule goes on from there; LU factors by
///   MUMPS;
/// - iterative: conjugate gradients to a tenth of the residual, and smoothed aggregation with the
///   rigid-body modes, or, with quadratic elements, p-multigrid, see multigrid.hpp;
/// - with another -pc_type, conjugate gradients to 1e-8.
///
/// Collective.
PetscErrorCode set_linear_solver(const Scene &scene, SNES snes);

}  // namespace trefoil
