#pragma once

#include <petscsnes.h>

#include <string>

#include "solve/checkpoint.hpp"
#include "solve/solve.hpp"
#include "solve/solve_progress.hpp"

namespace trefoil {

/// How one solve on the way went.
struct Attempt {
  bool converged = false;
  PetscInt iterations = 0;
  PetscInt64 inverted = 0;    ///< elements, at its end
  bool is_hopeless = false;   ///< a shorter step would end in the same way
  bool is_cut_short = false;  ///< by -snes_max_it
  std::string record, reason, linear_solver;
};

/// The SNES of a scene: its energy, the program's defaults, the user's options. One can solve again
/// and again: matrices, what a linear solver knows of their pattern and the rule's weight are kept.
class SceneSolver {
 public:
  explicit SceneSolver(Scene &scene) : scene_(scene), progress_(scene.progress) {}
  SceneSolver(const SceneSolver &) = delete;
  SceneSolver &operator=(const SceneSolver &) = delete;
  ~SceneSolver();

  /// Collective; once. @param head_start seconds that were spent before
  PetscErrorCode set_up(const SolveOutcome &outcome, double head_start);

  /// Ends solves where the direction takes no vertex farther, unless the user's options say where.
  /// Collective.
  PetscErrorCode set_direction_tolerance(double tolerance);

  /// Ends solves at this energy tolerance, whatever the user says, and verifies none. Collective.
  PetscErrorCode loosen(double energy_tolerance);

  /// Makes it Newton's method: unfiltered, with full steps whatever they do to the energy, until
  /// the residual has fallen to a share of that at the start, at most so many, and no more than the
  /// user allows. It calls `follow` with `context` before each Hessian, as a monitor. Collective.
  PetscErrorCode take_full_steps(PetscInt most, double residual_share,
                                 PetscErrorCode (*follow)(SNES, PetscInt, PetscReal, void *),
                                 void *context);

  /// Says what will solve its linear systems. Collective.
  PetscErrorCode expect(LinearSolver *solver) {
    return expect_linear_solver(snes_, scene_.hessian, solver);
  }

  /// Lets each iteration be a moment at which the run can be saved. Collective.
  /// @param saves_iterate whether it is saved as it stands within a solve, and the moment counts
  PetscErrorCode watch(Checkpoint &checkpoint, bool saves_iterate);
  /// Adds the scene's displacement, and what the search knows, to what is saved. Collective.
  PetscErrorCode save(const Checkpoint &checkpoint, SavedRun *run) const;
  /// The numbers of what the search knows.
  PetscErrorCode describe_search(Checkpoint::Json *numbers) const;
  /// The next solve goes on with what the search knew. Collective.
  PetscErrorCode go_on(const Checkpoint &checkpoint);

  /// Solves from the scene's displacement on, where the energy must be finite. Collective.
  PetscErrorCode solve(Attempt *attempt);

 private:
  PetscErrorCode explain_by_contact(Attempt *attempt) const;
  static PetscErrorCode pass_iteration(SNES snes, PetscInt iteration, PetscReal norm, void *solver);

  Scene &scene_;
  SolveProgress progress_;
  SNES snes_ = nullptr;
  Checkpoint *checkpoint_ = nullptr;
  bool saves_iterate_ = false;
};

/// How one solve is to go.
struct AttemptOptions {
  double head_start = 0;  ///< seconds that went before it
  bool may_fail = false;  ///< a start of infinite energy is a failure like others, not bad input
  double loose_tolerance = 0;  ///< > 0: see SceneSolver::loosen()
  bool goes_on = false;        ///< within a solve that was saved
  bool is_saved = true;        ///< as it stands on its way; else what was before it
  bool is_last = false;        ///< its end is saved
};

/// Solves from the scene's displacement on. Collective.
PetscErrorCode solve_from_start(Scene &scene, const AttemptOptions &options, Checkpoint &checkpoint,
                                const SolveOutcome &outcome, Attempt *attempt);

}  // namespace trefoil
