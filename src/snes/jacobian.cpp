#include <petscksp.h>

#include <cstring>

#include "petsc_compatibility.hpp"
#include "snes/solve_context.hpp"

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
  const double seconds = context.clock.elapsed();
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
  return context.history.empty() ? context.rule->first()
                                 : context.rule->next(context.history.back());
}

PetscErrorCode count_indefinite(MPI_Comm comm, const TrefoilSplitStatistics &mine,
                                PetscInt64 *elements, PetscInt64 *indefinite) {
  PetscInt64 counts[2] = {mine.elements, mine.indefinite};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPIU_INT64, MPI_SUM, comm));
  *elements = counts[0];
  *indefinite = counts[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// SNES's Jacobian callback: asks the rule for w, the split callback for H and N, forms H + 2 w N.
PetscErrorCode compute_filtered_jacobian(SNES snes, Vec x, Mat, Mat H, void *ctx) {
  auto &context = *static_cast<SolveContext *>(ctx);
  IterationRecord &current = context.current;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(snes));
  TrefoilSplitStatistics mine{};
  PetscInt64 elements = 0, indefinite = 0;
  PetscInt iteration = 0;

  PetscFunctionBeginUser;
  PetscCall(begin_solve(context));
  context.clock.switch_to(Phase::assembly);
  PetscCall(is_driven(snes, &context.driven));
  PetscCall(SNESGetIterationNumber(snes, &iteration));
  current.k = static_cast<int>(iteration);
  current.weight = choose_weight(context);
  if (!context.driven) PetscCall(record_foreign_iteration(context, x));
  const bool filtered = current.weight != 0;

  context.clock.switch_to(Phase::assembly);
  PetscCall(PetscLogEventBegin(event_assembly, snes, x, H, nullptr));
  PetscCall(context.split_jacobian(snes, x, H, filtered ? &context.negative : nullptr, &mine,
                                   context.split_jacobian_context));
  PetscCall(count_indefinite(comm, mine, &elements, &indefinite));
  current.indefinite = !filtered ? IterationRecord::none
                       : elements ? static_cast<double>(indefinite) / static_cast<double>(elements)
                                  : 0;
  context.negative_present = filtered && context.negative && indefinite > 0;
  if (context.negative_present) {
    PetscCall(MatAXPY(H, 2 * current.weight, context.negative, SAME_NONZERO_PATTERN));
  }
  PetscCall(PetscLogEventEnd(event_assembly, snes, x, H, nullptr));

  // Direct solvers may then use Cholesky factors; set after assembly, or PETSc forgets it.
  PetscCall(MatSetOption(H, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(H, MAT_SPD, current.weight >= 0.5 ? PETSC_TRUE : PETSC_FALSE));
  PetscCallMPI(MPI_Barrier(comm));  // or waiting for each other would count as solving, too
  context.clock.switch_to(Phase::linear_solve);
  context.clock.move(Phase::assembly, Phase::filter, mine.filter_seconds);
  ++context.summary.linear_solves;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace
}  // namespace trefoil

using trefoil::SolveContext;

PetscErrorCode TrefoilSNESSetSplitJacobian(SNES snes, Mat H, TrefoilSplitJacobianFunction function,
                                           void *ctx) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(TrefoilInitializePackage());
  PetscCall(trefoil::get_solve_context(snes, &context));
  PetscCall(MatDestroy(&context->negative));
  context->split_jacobian = function;
  context->split_jacobian_context = ctx;
  PetscCall(SNESSetJacobian(snes, H, H, trefoil::compute_filtered_jacobian, context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetEnergyScale(SNES snes, TrefoilEnergyScaleFunction function,
                                         void *ctx) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solve_context(snes, &context));
  context->energy_scale = function;
  context->energy_scale_context = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetWeight(SNES snes, PetscReal *weight) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solve_context(snes, &context));
  *weight = context->current.weight;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetTrustRegionRatio(SNES snes, PetscReal *rho) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solve_context(snes, &context));
  *rho = trefoil::IterationRecord::none;
  // A last entry without a step closes the history; the ratio belongs to the step before it.
  for (auto entry = context->history.rbegin(); entry != context->history.rend(); ++entry) {
    if (entry->step == 0) continue;
    *rho = entry->rho;
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetRecord(SNES snes, const char **json) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solve_context(snes, &context));
  *json = context->record.c_str();
  PetscFunctionReturn(PETSC_SUCCESS);
}
