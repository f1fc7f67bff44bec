#pragma once

#include <petscsnes.h>

#include "support/callback.hpp"
#include "trefoil.h"

namespace trefoil {

/// The energy f that a SNES minimises, its gradient, and what the host's callbacks know of them.
/// Where the SNES has no objective, energies count from the solve's start: what the steps have
/// changed. All functions but the setters are collective.
class Energy {
 public:
  explicit Energy(SNES snes) : snes_(snes) {}

  Callback<TrefoilEnergyScaleFunction> scale_callback;
  Callback<TrefoilEnergyChangesFunction> changes_callback;
  Callback<TrefoilMaxStepFunction> max_step_callback;
  double offset = 0;  ///< a constant that the objective leaves out, for monitor and record

  /// Forgets energies of the solve before.
  void begin_solve();

  /// Whether energies come from an objective.
  PetscErrorCode has_objective(bool *has) const;
  /// f(x) from the objective, always evaluated.
  PetscErrorCode evaluate(Vec x, double *energy);
  /// f(x), evaluated once for each state of x.
  PetscErrorCode at(Vec x, double *energy);
  /// Says that f(x) is known to be `energy`.
  PetscErrorCode remember(Vec x, double energy);
  /// g(x), the SNES's residual.
  PetscErrorCode gradient(Vec x, Vec g) { return SNESComputeFunction(snes_, x, g); }

  /// The size of the energy at x from the callback; 0 where there is none.
  PetscErrorCode scale(Vec x, double *size);
  /// f(x + sum_k c[p][k] d[k]) - f(x) at many points in one pass; needs the callback.
  PetscErrorCode changes(Vec x, PetscInt directions, const Vec d[], PetscInt points,
                         const double coefficients[], double changes[]);
  /// Shortens `step` to the largest that the host allows along d from x; `truncated` where it did.
  PetscErrorCode limit_step(Vec x, Vec d, double *step, bool *truncated);

 private:
  SNES snes_;  ///< borrowed
  double known_energy_ = 0;
  PetscObjectId known_vector_ = 0;
  PetscObjectState known_state_ = -1;
};

}  // namespace trefoil
