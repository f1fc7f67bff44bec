#include "solve/soft_start.hpp"

#include "scene/body_materials.hpp"
#include "scene/element_pressure.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

// Measured on the stretched and twisted cube of tests/accuracy/incompressible.py at nu .4999, with
// 6 cells an edge: 8 iterations in all, 9 to 11 by way of nu .45, .49, or several of them, 19
// without.
constexpr double softer = 24;           // lambda / mu at nu .48
constexpr double much = 4;              // times as stiff: worth a solve
constexpr double loose = 0.01;          // energy tolerance
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

}  // namespace

bool softens_start(const Scene &scene) {
  return element_pressure(scene.options) == ElementPressure::constant &&
         largest_volumetric(scene.options) > much * softer;
}

PetscErrorCode soften_start(Scene &scene, double head_start, Checkpoint &checkpoint,
                            SolveOutcome *outcome, AttemptRecord *record) {
  const SoftBody body(scene);
  const AttemptOptions how{
      .head_start = head_start, .may_fail = true, .loose_tolerance = loose, .is_saved = false};
  Vec start = nullptr;
  Attempt attempt;
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm)),
                        "start: a softer body (nu 0.48), loosely\n"));
  PetscCall(VecDuplicate(scene.displacement, &start));
  PetscCall(VecCopy(scene.displacement, start));
  PetscCall(solve_from_start(scene, how, checkpoint, *outcome, &attempt));
  if (!attempt.converged) {
    PetscCall(VecCopy(start, scene.displacement));
    PetscCall(PetscPrintf(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm)),
                          "start: the softer body has found no equilibrium; without it\n"));
  }
  PetscCall(VecDestroy(&start));
  if (!attempt.record.empty()) outcome->linear_solver = attempt.linear_solver;
  *record = {attempt.record, number_of_load_step, !attempt.converged};
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
