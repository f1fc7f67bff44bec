#pragma once

#include <petscsnes.h>

#include <memory>
#include <optional>
#include <string>

#include "hook/filtered_jacobian.hpp"
#include "rule/rule.hpp"
#include "search/energy.hpp"
#include "search/search_memory.hpp"
#include "search/solve_record.hpp"
#include "snes/host_jacobian.hpp"
#include "snes/jacobian_test.hpp"
#include "snes/solver_options.hpp"
#include "support/callback.hpp"
#include "trefoil.h"

namespace trefoil {

/// A host's callback that makes H and N at once, and what it can do (TrefoilSplitCapability).
struct SplitJacobian : Callback<TrefoilSplitJacobianFunction> {
  int capabilities = 0;
  Callback<TrefoilHessianProductFunction> product;  ///< H + 2 w N is formed at once
};

/// What is composed with an SNES of ours: it owns the parts. PETSc's callbacks unpack it;
/// everything below them takes the parts that it needs.
struct Solver {
  explicit Solver(SNES owner) : snes(owner), energy(owner) {}

  SNES snes;  ///< borrowed: this belongs to it
  SolverOptions options;
  std::vector<std::string> idle_options;  ///< a sentence for each that has no effect
  std::unique_ptr<Rule> rule;
  /// -snes_max_linear_solve_fail of before; the search decides what a failure ends.
  std::optional<PetscInt> linear_failures;

  SplitJacobian split_jacobian;
  HostJacobian host_jacobian;
  Callback<TrefoilProxyFunction> mass_proxy;
  FilteredJacobian jacobian;
  JacobianTest jacobian_test;
  bool driven = false;           ///< by our line search; otherwise the Jacobian stays unfiltered
  bool jacobian_is_new = false;  ///< made in this iteration; a SNES may lag it
  bool proxy_is_formed = false;  ///< in this solve

  Energy energy;
  SearchMemory memory;
  SolveRecord record;
  /// The last step of the last solve, for rules that go on from there.
  std::optional<IterationRecord> last_lesson;
  /// Where the next solve goes on from what is remembered, of another run even.
  bool resumes = false;
  bool goes_on = false;  ///< in this solve: rules learn from the last lesson
  std::string json;      ///< the record of the last finished solve

  /// Begins a solve unless one is running.
  PetscErrorCode begin_solve();
  /// Closes an iteration: into the history, and onto the screen where the user wants that.
  PetscErrorCode close_iteration(const IterationRecord &iteration);
  /// Keeps a sentence that the user should know for the record, and says it once. Collective.
  PetscErrorCode note(const std::string &sentence);
  /// Ends it: closes the history, makes the JSON record and writes it where the user wants it.
  /// Collective. Harmless where no solve is running.
  PetscErrorCode end_solve();

  /// Reads the options and makes the rule. Collective.
  PetscErrorCode set_from_options();
  /// Makes the rule that the options name.
  PetscErrorCode make_rule();
  /// Whether the SNES goes on after linear solves that fail: what a rule or a fresh preconditioner
  /// has an answer to is not the end of the solve. The limit that it had is given back; one that
  /// the user gives stays.
  PetscErrorCode allow_linear_failures(bool allowed);
  [[nodiscard]] bool uses_hessian() const { return options.search.proxy == TREFOIL_PROXY_HESSIAN; }
  /// The floor under filtered eigenvalues for a weight: the user's, else the rule's.
  [[nodiscard]] EigenvalueFloor floor(double weight) const {
    return {options.floor >= 0 ? options.floor : rule->floor(), weight};
  }
};

/// The solver of `snes`, made when first asked for.
PetscErrorCode get_solver(SNES snes, Solver **solver);

/// An iteration in the words of trefoil.h.
TrefoilIteration as_hosts_see(const IterationRecord &iteration);

/// Whether our line search, and thus the rule, drives this SNES.
PetscErrorCode is_driven(SNES snes, bool *driven);

/// Puts our callback before the SNES's present Jacobian callback, whoever set it and when. Called
/// before each Jacobian, because a host may set its own after reading options.
PetscErrorCode install_jacobian(Solver &solver);
/// Where another method of PETSc drives, its iterations are recorded when it asks for a Jacobian,
/// so that a record compares the two: the energy is the SNES's objective, the step its line
/// search's last one. Collective.
PetscErrorCode record_foreign_iteration(Solver &solver, Vec x);
/// Makes `H` the matrix of a proxy of the Hessian, once a solve: it stays the same, and so do its
/// factors. Collective.
PetscErrorCode form_proxy(Solver &solver, Mat J, Mat H);
/// Makes the split callback the SNES's Jacobian.
PetscErrorCode install_split_jacobian(Solver &solver, Mat H);

}  // namespace trefoil

extern "C" {
PetscErrorCode SNESCreate_Trefoil(SNES snes);
PetscErrorCode SNESLineSearchCreate_Trefoil(SNESLineSearch search);
}
