#include <petscksp.h>

#include <cmath>

#include "hook/matrix_operations.hpp"
#include "snes/solve_context.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Whether our line search, and thus the rule, drives this SNES.
PetscErrorCode is_driven(SNES snes, bool *driven) {
  PetscBool newton = PETSC_FALSE, ours = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(snes), &newton, SNESNEWTONLS,
                                      SNESTREFOIL, ""));
  if (newton) {
    SNESLineSearch search = nullptr;
    PetscCall(SNESGetLineSearch(snes, &search));
    PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(search), SNESLINESEARCHTREFOIL,
                                     &ours));
  }
  *driven = ours == PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode after_linear_solve(KSP ksp, Vec, Vec, void *ctx) {
  auto &context = *static_cast<SolveContext *>(ctx);
  PetscInt iterations = 0;
  PetscFunctionBeginUser;
  PetscCall(KSPGetIterationNumber(ksp, &iterations));
  context.current.linear_iterations = static_cast<int>(iterations);
  context.clock.switch_to(Phase::other);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where another method of PETSc drives, its iterations are recorded from here, so that a record
/// compares the two: the energy is the SNES's objective, the step its line search's last one.
PetscErrorCode record_foreign_iteration(SolveContext &context, Vec x) {
  KSP ksp = nullptr;
  Vec residual = nullptr;
  IterationRecord &current = context.current;
  const double seconds = context.head_start + context.clock.elapsed();
  PetscFunctionBeginUser;
  if (current.k > 0) {
    SNESLineSearch search = nullptr;
    PetscReal step = 0;
    PetscCall(SNESGetLineSearch(context.snes, &search));
    PetscCall(SNESLineSearchGetLambda(search, &step));
    context.history.back().linear_iterations = current.linear_iterations;
    context.history.back().step = step;
    PetscCall(monitor_iteration(context, context.history.back()));
  }
  PetscCall(energy_at(context, x, &current.energy));
  PetscCall(SNESGetFunction(context.snes, &residual, nullptr, nullptr));
  PetscCall(VecNorm(residual, NORM_2, &current.gradient_norm));
  current.linear_solves = context.summary.linear_solves + 1;  // with the one to come
  current.seconds = seconds;
  current.indefinite = IterationRecord::none;
  context.history.push_back(current);
  PetscCall(SNESGetKSP(context.snes, &ksp));
  PetscCall(KSPSetPostSolve(ksp, after_linear_solve, &context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The rule's weight for the iteration that begins; 0 where somebody else drives.
double choose_weight(SolveContext &context) {
  if (!context.driven) return 0;
  if (context.instead_of_rejected) return *context.instead_of_rejected;
  return context.history.empty() ? context.rule->first()
                                 : context.rule->next(context.history.back());
}

/// H and N from a split callback, which knows its elements.
PetscErrorCode split_jacobian(SolveContext &context, Vec x, Mat H, bool filtered,
                              InsertionCounts *counts, double *filter_seconds) {
  TrefoilSplitStatistics mine{};
  PetscFunctionBeginUser;
  PetscCall(context.split_jacobian(context.snes, x, H, filtered ? &context.negative : nullptr,
                                   &mine, context.split_jacobian_context));
  PetscInt64 sums[2] = {mine.elements, mine.indefinite};
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPIU_INT64, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(context.snes))));
  counts->elements = sums[0];
  counts->indefinite = sums[1];
  *filter_seconds = mine.filter_seconds;
  // Direct solvers may then use Cholesky factors; set after assembly, or PETSc forgets it.
  PetscCall(MatSetOption(H, MAT_SYMMETRIC, PETSC_TRUE));
  // MUMPS keeps to what the first matrix was: a rule that may meet indefinite ones never says SPD.
  const bool definite = context.current.weight >= 0.5 && !context.rule->may_be_rejected();
  PetscCall(MatSetOption(H, MAT_SPD, definite ? PETSC_TRUE : PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds 2 w N to the assembled H, in place; N has H's nonzero pattern, whoever made it.
PetscErrorCode add_negative_part(SolveContext &context, Mat H, bool filtered,
                                 PetscInt64 indefinite) {
  PetscFunctionBeginUser;
  context.negative_present = filtered && context.negative && indefinite > 0;
  if (context.negative_present) {
    PetscCall(add_multiple(H, 2 * context.current.weight, context.negative));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// SNES's Jacobian callback: asks the rule for w, the split callback or the host's own, watched,
/// for H and N, and forms H + 2 w N.
PetscErrorCode compute_filtered_jacobian(SNES snes, Vec x, Mat J, Mat H, void *ctx) {
  auto &context = *static_cast<SolveContext *>(ctx);
  IterationRecord &current = context.current;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(snes));
  InsertionCounts counts;
  PetscInt iteration = 0;
  double filter_seconds = 0;

  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(snes, &iteration));
  // A solve that ended in an error has not said so.
  const bool again = context.instead_of_rejected.has_value();
  if (iteration == 0 && !again && !context.history.empty()) context.running = false;
  PetscCall(begin_solve(context));
  context.clock.switch_to(Phase::assembly);
  PetscCall(is_driven(snes, &context.driven));
  current.k = static_cast<int>(iteration);
  current.weight = choose_weight(context);
  PetscCheck(current.weight >= 0 && std::isfinite(current.weight), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "rule '%s' chose the weight %g, which must be finite and not negative",
             context.options.filter.c_str(), current.weight);
  if (!context.driven && context.split_jacobian) PetscCall(record_foreign_iteration(context, x));
  const bool filtered = current.weight != 0;
  PetscCheck(!filtered || context.options.space == "element" || context.splits_deformation, comm,
             PETSC_ERR_USER_INPUT,
             "-snes_trefoil_space deformation filters at quadrature points, which are not to be "
             "seen in whole element matrices; use -snes_trefoil_space element");

  PetscCheck(
      !filtered || eigenvalue_floor(context).share == 0 ||
          (context.options.space == "element" && (!context.split_jacobian || context.obeys_floor)),
      comm, PETSC_ERR_USER_INPUT,
      "-snes_trefoil_filter %s keeps eigenvalues above %g of an element's largest "
      "(-snes_trefoil_floor), in whole element matrices that Trefoil splits; with "
      "-snes_trefoil_space deformation or split callbacks of your own use another filter, or "
      "-snes_trefoil_floor 0",
      context.options.filter.c_str(), eigenvalue_floor(context).share);

  context.clock.switch_to(Phase::assembly);
  PetscCall(PetscLogEventBegin(event_assembly, snes, x, H, nullptr));
  if (context.split_jacobian) {
    PetscCall(split_jacobian(context, x, H, filtered, &counts, &filter_seconds));
  } else {
    PetscCall(watch_host_jacobian(context, x, J, H, filtered, &counts, &filter_seconds));
  }
  current.indefinite = !filtered         ? IterationRecord::none
                       : counts.elements ? static_cast<double>(counts.indefinite) /
                                               static_cast<double>(counts.elements)
                                         : 0;
  context.elements = counts.elements;
  PetscCall(add_negative_part(context, H, filtered, counts.indefinite));
  PetscCall(PetscLogEventEnd(event_assembly, snes, x, H, nullptr));
  PetscCallMPI(MPI_Barrier(comm));  // or waiting for each other would count as solving, too
  context.clock.switch_to(Phase::linear_solve);
  context.clock.move(Phase::assembly, Phase::filter, filter_seconds);
  if (!again) {
    ++context.summary.iterations;
    context.jacobian_is_new = true;
  }
  ++context.summary.linear_solves;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode install_jacobian(SolveContext &context) {
  PetscErrorCode (*present)(SNES, Vec, Mat, Mat, void *) = nullptr;
  Mat J = nullptr, H = nullptr;
  void *present_context = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESGetJacobian(context.snes, &J, &H, &present, &present_context));
  if (!present || present == compute_filtered_jacobian) PetscFunctionReturn(PETSC_SUCCESS);
  // A host's callback set after a split one replaces it, as SNESSetJacobian() promises.
  context.split_jacobian = nullptr;
  context.host_jacobian = present;
  context.host_jacobian_context = present_context;
  PetscCall(keep_host_context(context));
  PetscCall(SNESSetJacobian(context.snes, J, H, compute_filtered_jacobian, &context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_split_jacobian(SolveContext &context, Mat H) {
  PetscFunctionBeginUser;
  PetscCall(MatDestroy(&context.negative));
  PetscCall(SNESSetJacobian(context.snes, H, H, compute_filtered_jacobian, &context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
