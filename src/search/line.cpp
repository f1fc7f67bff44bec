#include "search/line.hpp"

#include <algorithm>
#include <cmath>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Differences of energies below this are rounding: a sum over many elements of terms of f's size.
double energy_noise(const Line &line) {
  return 8 * PETSC_MACHINE_EPSILON * std::max(std::abs(line.energy), std::abs(line.trial_energy));
}

/// The slope g(x + s d)'d at a point of the line.
PetscErrorCode slope_at(SolveContext &context, const Line &line, double s, double *slope) {
  PetscScalar product = 0;
  PetscFunctionBegin;
  PetscCall(VecWAXPY(line.point, -s, line.minus_d, line.x));
  PetscCall(SNESComputeFunction(context.snes, line.point, line.point_residual));
  PetscCall(VecDot(line.point_residual, line.minus_d, &product));
  *slope = -PetscRealPart(product);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Integral of the slope from a to b by the Gauss-Lobatto rule with five points (exact for
/// polynomials of degree 7, so for a stable Neo-Hookean energy). Where Simpson's rule on three of
/// these points disagrees by a tenth, in halves.
PetscErrorCode integrate_slope(SolveContext &context, const Line &line, double a, double b,
                               double slope_a, double slope_b, int halvings, double *integral) {
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a), node = std::sqrt(3.0 / 7.0);
  double left = 0, centre = 0, right = 0;
  PetscFunctionBegin;
  PetscCall(slope_at(context, line, middle - node * half, &left));
  PetscCall(slope_at(context, line, middle, &centre));
  PetscCall(slope_at(context, line, middle + node * half, &right));
  *integral = half * ((slope_a + slope_b) / 10 + (left + right) * 49 / 90 + centre * 32 / 45);
  const double simpson = half * (slope_a + 4 * centre + slope_b) / 3;
  if (halvings > 0 && std::abs(*integral - simpson) > 0.1 * std::abs(*integral)) {
    double first = 0, second = 0;
    PetscCall(integrate_slope(context, line, a, middle, slope_a, centre, halvings - 1, &first));
    PetscCall(integrate_slope(context, line, middle, b, centre, slope_b, halvings - 1, &second));
    *integral = first + second;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode evaluate_trial(SolveContext &context, Line &line, double step, bool *finite) {
  constexpr int most_halvings = 3;
  PetscFunctionBegin;
  line.step = step;
  line.trial_residual_known = false;
  PetscCall(VecWAXPY(line.trial, -step, line.minus_d, line.x));
  if (line.has_objective) {
    PetscReal energy = 0;
    PetscCall(SNESComputeObjective(context.snes, line.trial, &energy));
    line.trial_energy = energy;
  } else {
    double change = 0;
    PetscCall(evaluate_trial_residual(context, line));
    if (!std::isfinite(line.trial_slope)) {
      change = line.trial_slope;
    } else if (!line.lifted) {
      PetscCall(integrate_slope(context, line, 0, step, line.slope, line.trial_slope, most_halvings,
                                &change));
    }
    line.trial_energy = line.energy + change;
  }
  *finite = std::isfinite(line.trial_energy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode evaluate_trial_residual(SolveContext &context, Line &line) {
  PetscScalar slope = 0;
  PetscFunctionBegin;
  if (line.trial_residual_known) PetscFunctionReturn(PETSC_SUCCESS);
  const Phase phase = context.clock.switch_to(Phase::assembly);
  PetscCall(SNESComputeFunction(context.snes, line.trial, line.trial_residual));
  PetscCall(VecDot(line.trial_residual, line.minus_d, &slope));
  context.clock.switch_to(phase);  // after the dot product, in which ranks wait for each other
  line.trial_slope = -PetscRealPart(slope);
  line.trial_residual_known = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode energy_change(SolveContext &context, Line &line, double predicted, double *change) {
  PetscFunctionBegin;
  *change = line.trial_energy - line.energy;
  // A ratio to the prediction is wanted to three digits. Where the difference drowns in rounding,
  // the slopes at both ends keep theirs (trapezoidal rule, exact to third order in the step).
  if (line.has_objective && std::abs(predicted) < 1e3 * energy_noise(line)) {
    PetscCall(evaluate_trial_residual(context, line));
    *change = 0.5 * line.step * (line.slope + line.trial_slope);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode moves_boundary_values(Mat H, Vec direction, bool *moves) {
  Vec probe = nullptr, product = nullptr, diagonal = nullptr;
  PetscReal largest = 0;
  PetscInt size = 0;
  PetscFunctionBegin;
  PetscCall(VecDuplicate(direction, &probe));
  PetscCall(VecDuplicate(direction, &product));
  PetscCall(VecDuplicate(direction, &diagonal));
  PetscCall(MatGetDiagonal(H, diagonal));
  PetscCall(VecGetLocalSize(direction, &size));
  // (H z)_i = H_ii z_i for random z: row i has nothing beside its diagonal.
  std::vector<char> alone(static_cast<std::size_t>(size), 1);
  for (int k = 0; k < 2; ++k) {
    const PetscScalar *z = nullptr, *Hz = nullptr, *d = nullptr;
    PetscCall(VecSetRandom(probe, nullptr));
    PetscCall(MatMult(H, probe, product));
    PetscCall(VecGetArrayRead(probe, &z));
    PetscCall(VecGetArrayRead(product, &Hz));
    PetscCall(VecGetArrayRead(diagonal, &d));
    for (PetscInt i = 0; i < size; ++i) {
      const double own = PetscRealPart(d[i] * z[i]);
      if (!(std::abs(PetscRealPart(Hz[i]) - own) <= 1e-14 * std::abs(own))) {
        alone[static_cast<std::size_t>(i)] = 0;
      }
    }
    PetscCall(VecRestoreArrayRead(diagonal, &d));
    PetscCall(VecRestoreArrayRead(product, &Hz));
    PetscCall(VecRestoreArrayRead(probe, &z));
  }
  PetscCall(VecNorm(direction, NORM_INFINITY, &largest));
  double moved = 0;
  const PetscScalar *y = nullptr;
  PetscCall(VecGetArrayRead(direction, &y));
  for (PetscInt i = 0; i < size; ++i) {
    if (alone[static_cast<std::size_t>(i)]) moved = std::max(moved, std::abs(PetscRealPart(y[i])));
  }
  PetscCall(VecRestoreArrayRead(direction, &y));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moved, 1, MPI_DOUBLE, MPI_MAX,
                             PetscObjectComm(reinterpret_cast<PetscObject>(H))));
  *moves = moved > 1e-9 * largest;
  PetscCall(VecDestroy(&probe));
  PetscCall(VecDestroy(&product));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
