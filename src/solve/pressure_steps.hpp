#pragma once

#include <vector>

#include "solve/run_record.hpp"
#include "solve/scene_solver.hpp"

namespace trefoil {

/// Newton's method for the displacements and the elements' pressures as unknowns of their own, of
/// which each step eliminates the pressures p:
///   (W'' + sum_e p_e V_e theta_e'' + V_e U''(theta_e) g_e g_e') d = -f'(u),   g = d(theta)/du,
///   p_e <- U'(theta_e) + U''(theta_e) g_e'd,   u <- u + d.
/// Newton's method for the displacements alone has U'(theta) for p, which the second order of a
/// step makes so large near incompressibility that full steps lead nowhere, as they do for stresses
/// at points in [Magisano, Leonetti, Garcea 2017, "How to improve efficiency and robustness of the
/// Newton method in geometrically non-linear structural problem discretized via displacement-based
/// finite elements"]. At a solution both are the same.
class PressureSteps {
 public:
  explicit PressureSteps(Scene &scene) : scene_(scene) {}
  PressureSteps(const PressureSteps &) = delete;
  PressureSteps &operator=(const PressureSteps &) = delete;
  ~PressureSteps();

  /// Begins with the pressures of the scene's displacement and materials as they are.
  PetscErrorCode hold();
  /// Takes steps from the scene's displacement, which stays where they do not lower the energy, or
  /// turn elements round. After hold(). Collective.
  /// @param head_start seconds that went before
  /// @param record of the steps, as load step 1
  PetscErrorCode take(double head_start, Checkpoint &checkpoint, const SolveOutcome &outcome,
                      AttemptRecord *record);

 private:
  static PetscErrorCode follow(SNES snes, PetscInt iteration, PetscReal norm, void *steps);
  PetscErrorCode solve(double head_start, Checkpoint &checkpoint, const SolveOutcome &outcome,
                       Attempt *attempt);

  Scene &scene_;
  std::vector<double> last_;  ///< local displacements where pressures were held last
};

}  // namespace trefoil
