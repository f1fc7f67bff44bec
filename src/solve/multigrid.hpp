#pragma once

#include <petscpc.h>

#include "assembly/discretization.hpp"

namespace trefoil {

/// Smoothed aggregation. Coarse spaces stay as long as the preconditioner; the smoothers' bounds
/// are estimated anew, for those of the first Jacobian make it indefinite later on.
PetscErrorCode set_aggregation(PC pc);

/// Aggregates of neighbours' neighbours on the two finest levels, unless options say otherwise, and
/// not on PETSc's one: with six modes each, the third level's product would take longer than the
/// first two. Nothing for other preconditioners. To be called when the options have been read,
/// since PETSc 3.18 forgets it then.
PetscErrorCode set_large_aggregates(PC pc);

/// Multigrid with two levels for a quadratic mesh: quadratic displacements, smoothed by Chebyshev's
/// polynomials of SSOR, and under them the linear ones of the same mesh, with Galerkin's matrix.
/// These are solved by Cholesky factors while they are few, and by a cycle of smoothed aggregation
/// with the rigid-body modes beyond. Its options are those of any PCMG: -mg_levels_*, -mg_coarse_*.
/// Collective; sets the preconditioner up for the pattern of H, whose values do not matter yet.
PetscErrorCode set_p_multigrid(const Discretization &discretization, Mat H, PC pc);

}  // namespace trefoil
