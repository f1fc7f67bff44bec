#include "solve/solve.hpp"

#include <petsctime.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "scene/initial_displacement.hpp"
#include "scene/unknown_options.hpp"
#include "solve/load_steps.hpp"
#include "solve/solver_help.hpp"
#include "solve/start_check.hpp"
#include "solve/step_sizes.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

namespace trefoil {
namespace {

PetscErrorCode is_set(const char *option, bool *set) {
  PetscBool found = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(nullptr, nullptr, option, &found));
  *set = found == PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A default for one of PETSc's own options.
PetscErrorCode set_unless_given(const char *option, const char *value) {
  bool given = false;
  PetscFunctionBeginUser;
  PetscCall(is_set(option, &given));
  if (!given) PetscCall(PetscOptionsSetValue(nullptr, option, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A direct solver for symmetric matrices: CHOLMOD on one rank, MUMPS on several, and MUMPS where
/// the matrix may be indefinite, which it survives and CHOLMOD does not, unless the rule goes on
/// from there. With a preconditioner of the user's, conjugate gradients.
PetscErrorCode choose_linear_solver(SNES snes, KSP ksp) {
  PC pc = nullptr;
  PetscMPIInt ranks = 0;
  PetscBool may_be_indefinite = PETSC_FALSE, retries = PETSC_FALSE;
  bool preconditioner_set = false, multigrid_option_set = false;
  PetscFunctionBeginUser;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(is_set("-pc_type", &preconditioner_set));
  PetscCall(is_set("-pc_gamg_reuse_interpolation", &multigrid_option_set));
  if (preconditioner_set) {
    PetscCall(KSPSetType(ksp, KSPCG));
    PetscCall(KSPSetTolerances(ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 2000));
    // Reused coarse spaces of the last Jacobian make the second one look indefinite (PETSc 3.18).
    if (!multigrid_option_set) {
      std::array<char, 64> type{};
      PetscCall(
          PetscOptionsGetString(nullptr, nullptr, "-pc_type", type.data(), type.size(), nullptr));
      if (std::string(type.data()) == PCGAMG) {
        PetscCall(PetscOptionsSetValue(nullptr, "-pc_gamg_reuse_interpolation", "false"));
      }
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(snes)), &ranks));
  PetscCall(TrefoilSNESJacobianMayBeIndefinite(snes, &may_be_indefinite));
  PetscCall(TrefoilSNESRetriesFactors(snes, &retries));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(PCSetType(pc, PCCHOLESKY));
#if defined(PETSC_HAVE_SUITESPARSE)
  if (ranks == 1 && (!may_be_indefinite || retries)) {
    PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERCHOLMOD));
    // Its other factors exist for indefinite matrices as well. These tell whether a point is a
    // minimum, and that it is none is an answer, not worth a warning.
    PetscCall(set_unless_given("-mat_cholmod_factor", "SUPERNODAL"));
    PetscCall(set_unless_given("-mat_cholmod_print", "0"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
#endif
#if defined(PETSC_HAVE_MUMPS)
  PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  // Negative pivots are counted, also those of the root, which several ranks would share.
  if (may_be_indefinite) PetscCall(set_unless_given("-mat_mumps_icntl_13", "1"));
  // Its own guess of the memory, 20 % more than the analysis says, is sometimes short of one
  // number.
  PetscCall(set_unless_given("-mat_mumps_icntl_14", "100"));
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The default linear solver, which depends on what the SNES was told; options have the last word.
PetscErrorCode set_linear_solver(SNES snes) {
  KSP ksp = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(choose_linear_solver(snes, ksp));
  PetscCall(KSPSetFromOptions(ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_defaults(SNES snes, const SolveOutcome &outcome, double head_start) {
  PetscReal absolute = 0, step = 0;
  PetscInt iterations = 0, functions = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESSetType(snes, SNESTREFOIL));
  // The residual at the start is that of crushed elements: no measure for the one at the end.
  PetscCall(SNESGetTolerances(snes, &absolute, nullptr, &step, &iterations, &functions));
  PetscCall(SNESSetTolerances(snes, absolute, 0, step, iterations, functions));
  PetscCall(set_program_defaults(snes));
  const bool trust = outcome.guess.linear_solves > 0 || outcome.inverted_at_start == 0;
  PetscCall(TrefoilSNESSetTrustStart(snes, trust ? PETSC_TRUE : PETSC_FALSE));
  PetscCall(TrefoilSNESSetHeadStart(snes, head_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Refuses what PETSc would fail on late, or without a record.
PetscErrorCode check_solver(SNES snes) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(snes));
  PetscBool keeps_record = PETSC_FALSE;
  PetscInt iterations = 0;
  SNESType type = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESGetType(snes, &type));
  PetscCall(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(snes), &keeps_record,
                                      SNESTREFOIL, SNESNEWTONLS, SNESNEWTONTR, ""));
  PetscCheck(keeps_record, comm, PETSC_ERR_USER_INPUT,
             "-snes_type %s cannot solve a scene; use trefoil, newtonls or newtontr", type);
  PetscCall(SNESGetTolerances(snes, nullptr, nullptr, nullptr, &iterations, nullptr));
  PetscCheck(iterations >= 0, comm, PETSC_ERR_USER_INPUT,
             "-snes_max_it is %" PetscInt_FMT " and must not be negative", iterations);
  PetscFunctionReturn(PETSC_SUCCESS);
}

EnergyFunctional::Assembly assembly_of(const SceneOptions &options) {
  if (options.assembly == "hook") return EnergyFunctional::Assembly::hook;
  return options.assembly == "plain" ? EnergyFunctional::Assembly::plain
                                     : EnergyFunctional::Assembly::split;
}

/// A monitor: when the first iteration has set up all solvers, what none of them has read is an
/// error.
PetscErrorCode refuse_unused_once(SNES snes, PetscInt iteration, PetscReal, void *) {
  PetscFunctionBeginUser;
  if (iteration == 1) {
    PetscCall(refuse_unused_of_solver(PetscObjectComm(reinterpret_cast<PetscObject>(snes))));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// CHOLMOD raises an error where a matrix is not positive definite; to a user that is a solve that
/// did not converge.
PetscErrorCode solve(SNES snes, Vec x) {
  PetscFunctionBeginUser;
  const PetscErrorCode error = SNESSolve(snes, nullptr, x);
  if (error == PETSC_ERR_MAT_CH_ZRPVT || error == PETSC_ERR_MAT_LU_ZRPVT) {
    PetscCall(TrefoilSNESEndSolve(snes, SNES_DIVERGED_LINEAR_SOLVE,
                                  "the linear solver met a matrix that is not positive definite"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The state the solve starts from, as -initial says.
PetscErrorCode make_start(Scene &scene, SolveOutcome *outcome) {
  const std::string initial = choose_initial(scene.options);
  PetscFunctionBeginUser;
  if (initial == "expression") {
    PetscCall(set_initial_displacement(scene.options.initial_displacement, scene.discretization,
                                       scene.displacement));
  } else if (initial != "rest") {
    PetscCall(spread_displacements(*scene.functional, scene.discretization, scene.hessian,
                                   initial == "arap" ? scene.options.initial_steps : 0,
                                   scene.displacement, &outcome->guess));
  }
  PetscCall(scene.functional->count_inverted(scene.displacement, &outcome->inverted_at_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// How one solve on the way went.
struct Attempt {
  bool converged = false;
  PetscInt iterations = 0;
  PetscInt64 inverted = 0;
  std::string record, reason, linear_solver;
};

PetscErrorCode set_up_solver(Scene &scene, double head_start, const SolveOutcome &outcome,
                             SNES *snes) {
  PetscFunctionBeginUser;
  PetscCall(SNESCreate(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm)), snes));
  PetscCall(scene.functional->attach(*snes, scene.hessian, assembly_of(scene.options)));
  PetscCall(set_defaults(*snes, outcome, head_start));
  PetscCall(SNESSetFromOptions(*snes));
  PetscCall(check_solver(*snes));
  PetscCall(TrefoilSNESSetFromOptions(*snes));     // also where another type does not read them
  PetscCall(TrefoilSNESSetRecordFile(*snes, ""));  // the program writes it, completed
  PetscCall(set_linear_solver(*snes));
  PetscCall(SNESMonitorSet(*snes, refuse_unused_once, nullptr, nullptr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Solves from the scene's displacement on.
/// @param may_fail whether a start of infinite energy is a failure like others, not bad input
PetscErrorCode solve_from_start(Scene &scene, double head_start, bool may_fail,
                                const SolveOutcome &outcome, Attempt *attempt) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
  SNES snes = nullptr;
  const char *record = nullptr;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt linear_iterations = 0;
  EnergySums start;
  PetscFunctionBeginUser;
  PetscCall(set_up_solver(scene, head_start, outcome, &snes));
  PetscCall(scene.functional->energy(scene.displacement, &start));
  if (may_fail && !std::isfinite(start.energy)) {
    attempt->reason = "its start has infinite energy";
    PetscCall(SNESDestroy(&snes));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(check_start(scene, start.energy));
  PetscCall(solve(snes, scene.displacement));
  PetscCall(SNESGetLinearSolveIterations(snes, &linear_iterations));
  // There may have been no second iteration.
  if (linear_iterations > 0) PetscCall(refuse_unused_of_solver(comm));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  PetscCall(TrefoilSNESGetRecord(snes, &record));
  LinearSolver linear;
  PetscCall(describe_linear_solver(snes, &linear));
  attempt->linear_solver = linear.text;
  attempt->converged = reason > 0;
  attempt->record = record;
  const auto json = nlohmann::json::parse(attempt->record, nullptr, false);
  PetscCheck(json.is_object(), comm, PETSC_ERR_PLIB, "the solver left no record");
  attempt->iterations = json["result"]["iterations"];
  attempt->reason = json["result"]["reason"];
  PetscCall(SNESDestroy(&snes));
  PetscCall(scene.functional->count_inverted(scene.displacement, &attempt->inverted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

StepSizes step_sizes_of(const SceneOptions &options) {
  const PetscInt steps = number_of_load_steps(options);
  return steps > 0 ? StepSizes::equal(static_cast<int>(steps))
                   : StepSizes::adaptive(options.first_load_step, options.least_load_step);
}

/// The way from t = 0 to 1, step by step.
class Walk {
 public:
  Walk(Scene &scene, const StateObserver &observe, SolveOutcome *outcome)
      : scene_(scene),
        observe_(observe),
        outcome_(outcome),
        comm_(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm))),
        sizes_(step_sizes_of(scene.options)),
        path_(scene) {}

  PetscErrorCode go();

 private:
  [[nodiscard]] bool has_steps() const { return sizes_.count() != 1; }
  PetscErrorCode say_step(double time) const;
  PetscErrorCode take_step(double time, Attempt *attempt);
  PetscErrorCode accept(double time, const Attempt &attempt);
  PetscErrorCode reject(double time, const Attempt &attempt, bool *goes_on);
  void record(double time, const Attempt &attempt, bool is_rejected);

  Scene &scene_;
  const StateObserver &observe_;
  SolveOutcome *outcome_;
  MPI_Comm comm_;
  StepSizes sizes_;
  LoadPath path_;
  std::vector<SolveRecord> records_;
  PetscLogDouble begin_ = 0;
  PetscInt64 inverted_ = 0;  ///< elements, at the last equilibrium that stands
};

PetscErrorCode Walk::say_step(double time) const {
  PetscFunctionBeginUser;
  std::ostringstream text;  // PETSc would print "t = 1."
  text << "load step " << sizes_.accepted() + 1;
  if (!sizes_.is_adaptive()) text << " of " << sizes_.count();
  text << ", t = " << time;
  PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Walk::take_step(double time, Attempt *attempt) {
  PetscLogDouble now = 0;
  PetscFunctionBeginUser;
  if (has_steps()) {
    PetscCall(say_step(time));
    PetscCall(path_.go_to(time, &outcome_->guess));
  }
  if (!path_.has_stand()) PetscCall(make_start(scene_, outcome_));
  PetscCall(PetscTime(&now));
  const double head_start = has_steps() ? now - begin_ : outcome_->guess.seconds;
  PetscCall(solve_from_start(scene_, head_start, sizes_.is_adaptive(), *outcome_, attempt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Walk::record(double time, const Attempt &attempt, bool is_rejected) {
  if (attempt.record.empty()) return;
  outcome_->linear_solver = attempt.linear_solver;
  records_.push_back({attempt.record, sizes_.accepted() + 1, time, is_rejected});
}

PetscErrorCode Walk::accept(double time, const Attempt &attempt) {
  constexpr PetscInt easy_iterations = 8;
  PetscFunctionBeginUser;
  record(time, attempt, false);
  inverted_ = attempt.inverted;
  if (has_steps()) PetscCall(path_.accept());
  sizes_.accept(attempt.iterations <= easy_iterations);
  PetscCall(observe_(time, attempt.iterations));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Back to the last equilibrium that stands. @param goes_on whether a shorter step is left
PetscErrorCode Walk::reject(double time, const Attempt &attempt, bool *goes_on) {
  PetscFunctionBeginUser;
  *goes_on = sizes_.halve();
  if (!*goes_on && attempt.converged) {  // elements are turned round however short the step is
    PetscCall(accept(time, attempt));
    *goes_on = true;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  // What counts of a way that ends here is how the last solve on it went.
  record(time, attempt, *goes_on);
  PetscCall(path_.go_back());
  std::ostringstream text;
  if (*goes_on) {
    text << "the step to t = " << time << " is halved: ";
  } else {
    text << "the load step from t = " << sizes_.time() << " to " << time << " failed: ";
  }
  if (attempt.converged) {
    text << "it turns " << attempt.inverted - inverted_ << " elements round";
  } else {
    text << attempt.reason;
  }
  if (*goes_on) {
    PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
  } else {
    outcome_->failure = text.str();
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Walk::go() {
  bool goes_on = true;
  PetscFunctionBeginUser;
  if (has_steps()) PetscCall(path_.check(sizes_.next() < 1 ? sizes_.next() : 0.5, 1));
  PetscCall(PetscTime(&begin_));
  while (!sizes_.is_done() && goes_on) {
    const double time = sizes_.next();
    Attempt attempt;
    PetscCall(take_step(time, &attempt));
    const bool turns_elements = sizes_.is_adaptive() && attempt.inverted > inverted_;
    if (attempt.converged && !turns_elements) {
      PetscCall(accept(time, attempt));
    } else if (has_steps()) {
      PetscCall(reject(time, attempt, &goes_on));
    } else {
      record(time, attempt, false);
      goes_on = false;
    }
  }
  outcome_->converged = sizes_.is_done();
  outcome_->time = has_steps() ? sizes_.time() : 1;
  outcome_->plugin_record = join_records(records_);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode solve_scene(Scene &scene, const StateObserver &observe, SolveOutcome *outcome) {
  EnergySums end;
  PetscFunctionBeginUser;
  PetscCall(scene.functional->energy_at_rest(&outcome->energy_rest));
  PetscCall(Walk(scene, observe, outcome).go());
  PetscCall(scene.functional->energy(scene.displacement, &end));
  outcome->energy_scale = end.scale;
  PetscCall(scene.functional->count_inverted(scene.displacement, &outcome->inverted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode expect_linear_solver(Scene &scene, LinearSolver *solver) {
  SNES snes = nullptr;
  SolveOutcome outcome;
  PetscFunctionBeginUser;
  PetscCall(set_up_solver(scene, 0, outcome, &snes));
  PetscCall(expect_linear_solver(snes, scene.hessian, solver));
  PetscCall(SNESDestroy(&snes));
  const std::string initial = choose_initial(scene.options);
  if (initial == "rest" || initial == "expression") {  // which takes no solve
    EnergySums start;
    PetscCall(make_start(scene, &outcome));
    PetscCall(scene.functional->energy(scene.displacement, &start));
    if (scene.options.load_steps == "1") PetscCall(check_start(scene, start.energy));
  }
  // Other preconditioners than a factor read their options when they are set up.
  if (solver->factor_bytes > 0) {
    PetscCall(
        refuse_unused_of_solver(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm))));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
