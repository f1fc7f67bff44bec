#include "solve/soft_start.hpp"

#include <petsctime.h>

#include <utility>

#include "scene/body_materials.hpp"
#include "scene/element_pressure.hpp"
#include "solve/pressure_steps.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

// Measured on the stretched and twisted cube of tests/accuracy/incompressible.py at nu .4999, with
// 6 cells an edge, before there were PressureSteps: 8 iterations in all, 9 to 11 by way of nu .45,
// .49, or several of them, 19 without. With them 7 at a tolerance of .001, 8 at .0001; at .01 they
// fail with 8 cells.
constexpr double softer = 24;           // lambda / mu at nu .48
constexpr double much = 4;              // times as stiff: worth a solve
constexpr double loose = 0.001;         // energy tolerance
constexpr int number_of_load_step = 0;  // what comes before the first

/// While it lives the body's volume is less dear.
class SoftBody {
 public:
  explicit SoftBody(Scene &scene)
      : scene_(scene),
        other_(body_materials(scene.options, scene.mesh, scene.cells->region_of_cell(), softer)) {
    scene_.elastic->exchange_materials(other_);
  }
  ~SoftBody() { scene_.elastic->exchange_materials(other_); }
  SoftBody(const SoftBody &) = delete;
  SoftBody &operator=(const SoftBody &) = delete;

 private:
  Scene &scene_;
  MaterialRuns other_;
};

/// Full steps want whole directions, and Hessians in batches.
bool takes_pressure_steps(const Scene &scene) {
  return scene.linear_solver.kind == SolverKind::direct && scene.options.assembly == "split";
}

/// The loose solve.
PetscErrorCode solve_softly(Scene &scene, double head_start, Checkpoint &checkpoint,
                            SolveOutcome *outcome, Attempt *attempt) {
  const AttemptOptions how{
      .head_start = head_start, .may_fail = true, .loose_tolerance = loose, .is_saved = false};
  Vec start = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm)),
                        "start: a softer body (nu 0.48), loosely\n"));
  PetscCall(VecDuplicate(scene.displacement, &start));
  PetscCall(VecCopy(scene.displacement, start));
  PetscCall(solve_from_start(scene, how, checkpoint, *outcome, attempt));
  if (!attempt->converged) {
    PetscCall(VecCopy(start, scene.displacement));
    PetscCall(PetscPrintf(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm)),
                          "start: the softer body has found no equilibrium; without it\n"));
  }
  PetscCall(VecDestroy(&start));
  if (!attempt->record.empty()) outcome->linear_solver = attempt->linear_solver;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

bool softens_start(const Scene &scene) {
  return element_pressure(scene.options) == ElementPressure::constant &&
         largest_volumetric(scene.options) > much * softer;
}

PetscErrorCode soften_start(Scene &scene, double head_start, Checkpoint &checkpoint,
                            SolveOutcome *outcome, std::vector<AttemptRecord> *records) {
  PressureSteps steps(scene);
  Attempt attempt;
  PetscLogDouble begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscTime(&begin));
  {
    const SoftBody body(scene);
    PetscCall(solve_softly(scene, head_start, checkpoint, outcome, &attempt));
    if (attempt.record.empty()) PetscFunctionReturn(PETSC_SUCCESS);
    records->push_back({attempt.record, number_of_load_step, !attempt.converged});
    if (!attempt.converged || !takes_pressure_steps(scene)) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(steps.hold());
  }
  PetscCall(PetscTime(&end));
  AttemptRecord record;
  PetscCall(steps.take(head_start + end - begin, checkpoint, *outcome, &record));
  records->push_back(std::move(record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
