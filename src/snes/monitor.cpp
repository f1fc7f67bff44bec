#include "snes/monitor.hpp"

#include <cmath>
#include <cstdio>
#include <string>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// What an iteration has not got is a dash.
std::string text_of(double value, const char *format) {
  char text[32] = "-";
  if (std::isfinite(value)) std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace

PetscErrorCode print_iteration(MPI_Comm comm, const IterationRecord &iteration,
                               double energy_offset) {
  PetscFunctionBeginUser;
  if (iteration.k == 0) {
    PetscCall(PetscPrintf(comm, "%4s %21s %10s %7s %10s %8s %6s %6s %6s %5s %8s\n", "k", "energy",
                          "|gradient|", "weight", "decrement", "rho", "step", "trials", "solves",
                          "indef", "seconds"));
  }
  const std::string decrement = text_of(iteration.decrement, "%.3e"),
                    rho = text_of(iteration.rho, "%.4f"),
                    indefinite = text_of(100 * iteration.indefinite, "%.0f%%");
  // The state after the last step has no solve of its own.
  const bool has_solved = std::isfinite(iteration.decrement) || iteration.linear_iterations > 0;
  const int solves = has_solved ? 1 + iteration.newton_steps + iteration.shamanskii_steps : 0;
  PetscCall(PetscPrintf(comm, "%4d %21.14e %10.3e %7.3f %10s %8s %6.3f %6d %6d %5s %8.2f\n",
                        iteration.k, iteration.energy + energy_offset, iteration.gradient_norm,
                        iteration.weight, decrement.c_str(), rho.c_str(), iteration.step,
                        iteration.trials, solves, indefinite.c_str(), iteration.seconds));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
