#include "snes/monitor.hpp"

#include <cmath>
#include <cstdio>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode print_iteration(MPI_Comm comm, const IterationRecord &iteration,
                               double energy_offset) {
  PetscFunctionBeginUser;
  if (iteration.k == 0) {
    PetscCall(PetscPrintf(comm, "%4s %21s %10s %7s %10s %8s %6s %6s %6s %5s %8s\n", "k", "energy",
                          "|gradient|", "weight", "decrement", "rho", "step", "trials", "solves",
                          "indef", "seconds"));
  }
  char rho[16] = "-", indefinite[16] = "-";
  if (std::isfinite(iteration.rho)) std::snprintf(rho, sizeof rho, "%.4f", iteration.rho);
  if (std::isfinite(iteration.indefinite)) {
    std::snprintf(indefinite, sizeof indefinite, "%.0f%%", 100 * iteration.indefinite);
  }
  PetscCall(PetscPrintf(comm, "%4d %21.14e %10.3e %7.3f %10.3e %8s %6.3f %6d %6d %5s %8.2f\n",
                        iteration.k, iteration.energy + energy_offset, iteration.gradient_norm,
                        iteration.weight, iteration.decrement, rho, iteration.step,
                        iteration.trials, 1 + iteration.shamanskii_steps, indefinite,
                        iteration.seconds));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
