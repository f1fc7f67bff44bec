#pragma once

#include <petscsnes.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "filter/filter.hpp"
#include "hook/element_hook.hpp"
#include "rule/iteration_record.hpp"
#include "rule/rule.hpp"
#include "snes/phase_clock.hpp"
#include "support/log_events.hpp"
#include "support/text_file.hpp"
#include "trefoil.h"

namespace trefoil {

/// The plugin's options, see options.cpp for their names and help texts.
struct SolverOptions {
  std::string filter = "adaptive";
  RuleParameters rule;
  std::string search = "armijo";
  /// With search `subspace`: most further directions an iteration; -1: 8 where the linear solver is
  /// direct, none where it is iterative and each costs nearly as much as the first.
  int corrections = -1;
  double correction_gain = 0.03;   ///< least share of the first step's decrease to go on correcting
  double floor = -1;               ///< share of an element's largest |eigenvalue|; < 0: the rule's
  bool trust_start = false;        ///< the start has no crushed elements
  double decrement_tolerance = 0;  ///< energy units; 0: off
  double energy_tolerance = 1e-8;  ///< predicted decrease over energy scale; 0: off
  bool energy_tolerance_set = false;  ///< by the user, so decrement_tolerance does not turn it off
  double shrink = 0.8;
  double armijo = 1e-8;
  bool verify_minimum = false;      ///< look for negative curvature where the stop test is met
  bool verify_minimum_set = false;  ///< by the user, so decrement_tolerance does not turn it off
  bool monitor = false;
  std::string record_file;        ///< empty: no record
  bool strict = true;             ///< a Jacobian that cannot be filtered is an error
  std::string fields;             ///< names of the fields to filter; empty: all
  std::string space = "element";  ///< or "deformation": at quadrature points
};

/// What the unfiltered Hessian says of the point where a solve ended.
enum class StationaryPoint { unknown, minimum, saddle };

/// What is known of a finished or running solve besides its iterations.
struct SolveSummary {
  bool converged = false;
  std::string reason;  ///< one phrase for people
  double energy_scale = IterationRecord::none;
  int iterations = 0;     ///< Jacobians that were solved with
  int linear_solves = 0;  ///< corrections included
  StationaryPoint end = StationaryPoint::unknown;
  int saddles_left = 0;  ///< along negative curvature, after the stop test was met
  /// g'H^-1 g / 2 at the end, with the unfiltered Hessian: how far above its minimum the energy
  /// still is, to second order. Not-a-number where nobody has factored H.
  double error_estimate = IterationRecord::none;
  int verification_solves = 0;  ///< with the factors of the last Jacobian, to look for it
};

/// Everything the plugin keeps for one SNES; composed with it, so that it lives as long.
struct SolveContext {
  SNES snes = nullptr;  ///< borrowed: this context belongs to it
  SolverOptions options;
  std::unique_ptr<Rule> rule;
  /// The weight of a Jacobian that is made once more because it was indefinite.
  std::optional<double> instead_of_rejected;
  /// -snes_max_linear_solve_fail of before a rule that needs all of them.
  std::optional<PetscInt> linear_failures;

  Mat negative = nullptr;         ///< N, created when the first element is indefinite
  bool negative_present = false;  ///< N is part of the present Jacobian, H + 2 w N
  TrefoilSplitJacobianFunction split_jacobian = nullptr;
  void *split_jacobian_context = nullptr;
  bool obeys_floor = false;         ///< that callback obeys -snes_trefoil_floor
  bool splits_deformation = false;  ///< that callback obeys -snes_trefoil_space deformation
  // A host that knows nothing of us: its Jacobian callback, run with its Mat watched.
  PetscErrorCode (*host_jacobian)(SNES, Vec, Mat, Mat, void *) = nullptr;
  void *host_jacobian_context = nullptr;
  PetscObject host_context_keeper = nullptr;  ///< what owns that context, kept alive
  Mat watched = nullptr;                      ///< the host's Mat, with our hook on it
  std::vector<char> in_field;                 ///< unknowns to filter; empty: all
  PetscInt64 elements = 0;                    ///< in the last Jacobian, over all ranks
  InsertionCounts unfiltered;                 ///< what passed as it was, over the whole solve

  TrefoilEnergyScaleFunction energy_scale = nullptr;
  void *energy_scale_context = nullptr;
  double energy_offset = 0;  ///< that monitor and record add to energies
  TrefoilEnergyChangesFunction energy_changes = nullptr;
  void *energy_changes_context = nullptr;

  Vec previous_step = nullptr;       ///< kept for search `subspace` only
  bool previous_step_known = false;  ///< in this solve
  bool trusted = false;              ///< the search has begun to use planes, see searches_plane()

  bool running = false;          ///< between the start of a solve and its end
  bool driven = false;           ///< by our line search; otherwise the Jacobian stays unfiltered
  bool jacobian_is_new = false;  ///< made in this iteration; a SNES may lag it
  PhaseClock clock;
  double head_start = 0;    ///< seconds spent on a starting guess: history counts them
  IterationRecord current;  ///< the iteration under way
  std::vector<IterationRecord> history;
  SolveSummary summary;
  std::string record;  ///< JSON of the last finished solve

  /// Dirichlet values of a host may not be met yet: true at a solve's start, false once they are.
  bool boundary_values_open = false;

  double energy = IterationRecord::none;  ///< at the state below
  PetscObjectId energy_vector = 0;
  PetscObjectState energy_state = -1;

  ~SolveContext();
};

/// The context of `snes`, made when first asked for.
PetscErrorCode get_solve_context(SNES snes, SolveContext **context);

/// The floor under filtered eigenvalues with the weight of the iteration under way: the user's,
/// else the rule's.
EigenvalueFloor eigenvalue_floor(const SolveContext &context);

/// Begins a solve unless one is running: forgets the last one and starts the clock.
PetscErrorCode begin_solve(SolveContext &context);
/// Ends it: closes the history, makes the JSON record and writes it where the user wants it.
/// Collective. Harmless where no solve is running.
PetscErrorCode end_solve(SolveContext &context);

/// Reads -snes_trefoil_* and -snes_linesearch_{shrink,armijo}; a misspelt name is an error.
PetscErrorCode set_options(SolveContext &context);
PetscErrorCode view_options(const SolveContext &context, PetscViewer viewer);

/// Puts our callback before the SNES's present Jacobian callback, whoever set it and when. Called
/// before each Jacobian, because a host may set its own after reading options.
PetscErrorCode install_jacobian(SolveContext &context);
/// Makes the split callback the SNES's Jacobian.
PetscErrorCode set_split_jacobian(SolveContext &context, Mat H);
/// Runs the host's callback and collects N from the element blocks that it adds to H. What cannot
/// be filtered is an error on all ranks, or counted with -snes_trefoil_strict false. Collective.
PetscErrorCode watch_host_jacobian(SolveContext &context, Vec x, Mat J, Mat H, bool filtered,
                                   InsertionCounts *counts, double *filter_seconds);
/// Keeps what owns the host's callback context from being destroyed when ours replaces it.
PetscErrorCode keep_host_context(SolveContext &context);
/// Takes the hook off the host's Mat and forgets N.
PetscErrorCode release_host_matrix(SolveContext &context);

/// The energy at x from the SNES's objective, evaluated once for each state of x. Without an
/// objective energies count from the solve's start: what the searches have added up.
PetscErrorCode energy_at(SolveContext &context, Vec x, double *energy);
/// Says that the energy at x is known to be `energy`.
PetscErrorCode remember_energy(SolveContext &context, Vec x, double energy);

/// The size of the energy at x: the callback's, or what has been gained since the start.
/// Collective.
PetscErrorCode scale_of_energy(SolveContext &context, Vec x, double *scale);

/// Whether the present iteration ends the solve, before its direction is taken.
/// Newton decrement against the absolute and the relative tolerance. Collective.
PetscErrorCode stop_test(SolveContext &context, Vec x, bool *stop);

/// One line an iteration on the SNES's communicator, where -snes_trefoil_monitor asks for it.
PetscErrorCode monitor_iteration(const SolveContext &context, const IterationRecord &iteration);

/// The JSON record of a finished solve. Collective: phases and counts are reduced over the ranks.
PetscErrorCode make_record(SolveContext &context, std::string *json);

}  // namespace trefoil

extern "C" {
PetscErrorCode SNESCreate_Trefoil(SNES snes);
PetscErrorCode SNESLineSearchCreate_Trefoil(SNESLineSearch search);
}
