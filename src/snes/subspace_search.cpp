#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "petsc_compatibility.hpp"
#include "snes/line.hpp"
#include "snes/polynomial.hpp"

namespace trefoil {
namespace {

/// The plane x + a d + b p, d the direction and p the previous step scaled to d's size in the
/// filtered Hessian's norm; only a line where there is no previous step.
struct Plane {
  Vec directions[2] = {nullptr, nullptr};
  PetscInt dimension = 1;
  double previous_scale = 0;
};

constexpr double env_default(const char *) {
  return 0;
}
double env(const char *name, double fallback) {
  const char *text = std::getenv(name);
  return text ? std::atof(text) : fallback;
}

}  // namespace

PetscErrorCode steer_direction(SolveContext &context, Line &line, bool *steered) {
  static_cast<void>(env_default);
  static const double lo = env("SUB_LO", 0), hi = env("SUB_HI", 2), half_b = env("SUB_B", 1);
  static const int global = static_cast<int>(env("SUB_GLOBAL", 0));
  static const int use_line = static_cast<int>(env("SUB_LINE", 0));
  const int degree = context.energy_changes ? 6 : 2;
  PetscFunctionBegin;
  *steered = false;
  Mat filtered = nullptr;
  PetscScalar product = 0;
  PetscCall(SNESGetJacobian(context.snes, nullptr, &filtered, nullptr, nullptr));
  if (!context.previous_step) PetscCall(VecDuplicate(line.x, &context.previous_step));
  int m = 1;
  double scale = 0;
  if (context.previous_step_known && !use_line) {
    PetscCall(MatMult(filtered, context.previous_step, line.point));
    PetscCall(VecDot(line.point, context.previous_step, &product));
    if (product > 0 && line.slope < 0) {
      scale = std::sqrt(-line.slope / product);
      m = 2;
    }
  }
  const auto nodes = Polynomial::nodes(m, degree);
  Vec directions[2] = {line.point, line.point_residual};
  PetscCall(VecAXPBY(line.point, -1, 0, line.minus_d));
  if (m > 1) PetscCall(VecAXPBY(line.point_residual, scale, 0, context.previous_step));
  std::vector<double> coefficients, changes(nodes.size());
  const double mid = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
  for (const auto &node : nodes) {
    coefficients.push_back(mid + half * node[0]);
    if (m > 1) coefficients.push_back(half_b * node[1]);
  }
  if (context.energy_changes) {
    PetscCall(context.energy_changes(context.snes, line.x, m, directions,
                                     static_cast<PetscInt>(nodes.size()), coefficients.data(),
                                     changes.data(), context.energy_changes_context));
  } else {
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (double change : changes) {
    if (!std::isfinite(change)) PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Polynomial polynomial(m, degree, changes);
  Polynomial::Point best{(1 - mid) / half, 0};
  const double bound = global >= 2 ? 5 : 3;
  best = polynomial.minimum_from(best, bound);
  if (global) {
    for (const auto &node : nodes) {
      const auto other = polynomial.minimum_from(node, bound);
      if (polynomial.at(other) < polynomial.at(best)) best = other;
    }
  }
  const double a = mid + half * best[0], b = m > 1 ? half_b * best[1] * scale : 0;
  if (std::getenv("SUB_PRINT"))
    PetscCall(PetscPrintf(
        PETSC_COMM_WORLD, "   plane a %.3f b %.3f (scaled %.3f) change %.3e; full %.3e\n", a,
        half_b * best[1], b, polynomial.at(best), polynomial.at({(1 - mid) / half, 0})));
  // minus_d := -(a d + b p)
  PetscCall(VecCopy(line.minus_d, line.point_residual));
  PetscCall(VecScale(line.minus_d, a));
  if (b != 0) PetscCall(VecAXPY(line.minus_d, -b, context.previous_step));
  PetscScalar slope = 0;
  PetscCall(VecDot(line.residual, line.minus_d, &slope));
  if (-slope >= 0) {
    PetscCall(VecCopy(line.point_residual, line.minus_d));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  line.slope = -slope;
  *steered = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
