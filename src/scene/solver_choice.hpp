#pragma once

#include <petscsys.h>

#include <string>

#include "scene/factor_estimate.hpp"

namespace trefoil {

/// What the choice of a linear solver goes by.
struct SolverTask {
  PetscInt64 cells = 0;
  std::string cell = "tets";  ///< what they are called
  int order = 1;              ///< of the elements
  double poisson = 0;         ///< the largest of the scene's materials
  bool one_pressure = false;  ///< -element_pressure constant
  int ranks = 1;
  bool can_factor = true;  ///< whether this PETSc has Cholesky factors on so many ranks
  FactorEstimate factor;
  double free_bytes = 0;   ///< that all ranks may still take together
  double other_bytes = 0;  ///< of these, what is needed beside the solver
};

enum class SolverKind {
  direct,     ///< Cholesky factors
  iterative,  ///< conjugate gradients to a tenth, with multigrid
  users       ///< what -pc_type names
};

/// The solver, and why.
struct SolverChoice {
  SolverKind kind = SolverKind::direct;
  double factor_bytes = 0;  ///< that Cholesky factors take, or would take
  std::string reason;       ///< in words, without the solver's name
};

/// Poisson's ratio up to which multigrid on displacements alone is a solver, not a last resort;
/// with one pressure an element it is one beyond, where an iteration takes 2.4 times as long
/// (tests/benchmarks/README.md).
constexpr double most_poisson_for_multigrid = 0.495;

/// Chooses by memory, and where both fit by the seconds of one Newton iteration: one set-up and six
/// solves. The models' constants were fitted to boxes, knots and horses of 10 000 to 400 000
/// tetrahedra on one machine; what counts is their ratio (tests/benchmarks/large.py prints models
/// and measurements side by side).
/// @param wish "auto", "direct" or "iterative": `-solver`
SolverChoice choose_solver(const SolverTask &task, const std::string &wish);

/// Seconds of one Newton iteration, as the models say.
double direct_seconds(const SolverTask &task);
double iterative_seconds(const SolverTask &task);

/// "9.1 GB"
std::string bytes_text(double bytes);

}  // namespace trefoil
