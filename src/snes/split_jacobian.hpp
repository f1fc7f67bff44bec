#pragma once

#include "snes/solver.hpp"

namespace trefoil {

/// Refuses what the options ask of a callback that cannot do it.
PetscErrorCode check_capabilities(MPI_Comm comm, const SolverOptions &options,
                                  const SplitJacobian &split, const EigenvalueFloor &floor);

/// Whether the split callback makes H + 2 w N in one matrix.
PetscErrorCode forms_at_once(const Solver &solver, double weight, bool *at_once);

/// H and N from a split callback, which knows its elements. Collective.
/// @param keeps_negative N in a matrix of its own
PetscErrorCode compute_split(Solver &solver, Vec x, Mat H, bool keeps_negative,
                             InsertionCounts *counts, double *filter_seconds);

}  // namespace trefoil
