#include "solve/pressure_steps.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr PetscInt most = 8;       // where they work they are three
constexpr double fallen = 1e-6;    // of the residual: quadratic convergence leaves less
constexpr int number_of_step = 1;  // of the body itself

}  // namespace

PressureSteps::~PressureSteps() {
  scene_.elastic->release_pressures();
}

PetscErrorCode PressureSteps::hold() {
  PetscFunctionBeginUser;
  PetscCall(scene_.discretization.copy_local(scene_.displacement, &last_));
  const std::vector<double> no_step(last_.size(), 0);
  scene_.elastic->hold_pressures(last_.data(), no_step.data());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A monitor: the pressures after the step that has led here.
PetscErrorCode PressureSteps::follow(SNES snes, PetscInt iteration, PetscReal, void *context) {
  auto &steps = *static_cast<PressureSteps *>(context);
  Vec x = nullptr;
  std::vector<double> u;
  PetscFunctionBeginUser;
  if (iteration == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetSolution(snes, &x));
  PetscCall(steps.scene_.discretization.copy_local(x, &u));
  std::vector<double> step(u);
  for (std::size_t k = 0; k < u.size(); ++k) step[k] -= steps.last_[k];
  steps.scene_.elastic->hold_pressures(steps.last_.data(), step.data());
  steps.last_ = std::move(u);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PressureSteps::solve(double head_start, Checkpoint &checkpoint,
                                    const SolveOutcome &outcome, Attempt *attempt) {
  SceneSolver solver(scene_);
  PetscFunctionBeginUser;
  PetscCall(solver.set_up(outcome, head_start));
  PetscCall(solver.watch(checkpoint, false));
  PetscCall(solver.take_full_steps(most, fallen, follow, this));
  PetscCall(solver.solve(attempt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PressureSteps::take(double head_start, Checkpoint &checkpoint,
                                   const SolveOutcome &outcome, AttemptRecord *record) {
  Vec start = nullptr;
  EnergySums before, after;
  PetscInt64 inverted = 0;
  Attempt attempt;
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm)),
                        "start: full steps, with the elements' pressures as unknowns\n"));
  PetscCall(VecDuplicate(scene_.displacement, &start));
  PetscCall(VecCopy(scene_.displacement, start));
  PetscCall(scene_.functional->energy(start, &before));
  PetscCall(scene_.functional->count_inverted(start, &inverted));
  PetscCall(solve(head_start, checkpoint, outcome, &attempt));
  PetscCall(scene_.functional->energy(scene_.displacement, &after));
  const bool leads_on = after.energy < before.energy && attempt.inverted <= inverted;
  if (!leads_on) PetscCall(VecCopy(start, scene_.displacement));
  PetscCall(VecDestroy(&start));
  *record = {attempt.record, number_of_step, !leads_on};
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
