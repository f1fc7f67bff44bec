#pragma once

#include <petscsnes.h>

#include "support/callback.hpp"
#include "trefoil.h"

namespace trefoil {

/// The energy f that a SNES minimises, its gradient, and what the host's callbacks know of them:
/// the SNES's objective, less b'x where SNESSolve() was given a right-hand side b, which PETSc
/// takes off the residual and no objective knows of. Where there is no objective, energies count
/// from the solve's start: what the steps have changed. All functions but the setters are
/// collective.
class Energy {
 public:
  explicit Energy(SNES snes) : snes_(snes) {}

  Callback<TrefoilEnergyScaleFunction> scale_callback;
  Callback<TrefoilEnergyChangesFunction> changes_callback;
  Callback<TrefoilMaxStepFunction> max_step_callback;
  Callback<TrefoilDirectionSizeFunction> direction_size_callback;
  double offset = 0;  ///< a constant that the objective leaves out, for monitor and record

  /// Forgets energies of the solve before.
  void begin_solve();

  /// An objective that is the norm of the residual g, or its square, is no energy: it is taken for
  /// none from now on in this solve. Energies may have such values too, f = x'x / 2 say; so its
  /// slope along a direction d has to be that of the norm. Where g is zero one cannot tell yet.
  /// @param slope g'd   @param slope_of_half_square g'Hd
  PetscErrorCode examine_objective(double objective, double norm_of_gradient, double slope,
                                   double slope_of_half_square, bool *is_norm);
  /// Whether that is still to be done in this solve.
  PetscErrorCode wants_examination(bool *wants) const;

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
  /// Shortens `step` to the largest that the host allows along d from x, which may be 0: none;
  /// `truncated` where it did.
  PetscErrorCode limit_step(Vec x, Vec d, double *step, bool *truncated);
  /// How far d leads, as the host measures it; else the largest |entry|.
  PetscErrorCode direction_size(Vec d, double *size);

 private:
  /// b'v of the right-hand side; 0 where there is none.
  PetscErrorCode work_of_right_hand_side(Vec v, double *work) const;

  SNES snes_;  ///< borrowed
  bool objective_examined_ = false;
  bool objective_is_norm_ = false;  ///< and so no energy
  double known_energy_ = 0;
  PetscObjectId known_vector_ = 0;
  PetscObjectState known_state_ = -1;
};

}  // namespace trefoil
