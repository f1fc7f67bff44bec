#include <petscksp.h>

#include <cmath>

#include "hook/matrix_operations.hpp"
#include "hook/seen_sum.hpp"
#include "search/inertia.hpp"
#include "snes/solver.hpp"
#include "snes/split_jacobian.hpp"
#include "support/log_events.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// The weight of the Jacobian to be made: the rule's, from the last step that it may learn from; 0
/// where somebody else drives.
PetscErrorCode choose_weight(Solver &solver, double *weight) {
  const IterationRecord *lesson = solver.record.last_lesson();
  PetscFunctionBeginUser;
  if (!lesson && solver.goes_on && solver.last_lesson) lesson = &*solver.last_lesson;
  *weight = 0;
  if (!solver.driven || !solver.uses_hessian()) PetscFunctionReturn(PETSC_SUCCESS);
  if (solver.jacobian.imposed_weight) {
    *weight = *solver.jacobian.imposed_weight;
  } else {
    *weight = lesson ? solver.rule->next(*lesson) : solver.rule->first();
    PetscCall(static_cast<PetscErrorCode>(solver.rule->error()));
  }
  PetscCheck(*weight >= 0 && std::isfinite(*weight),
             PetscObjectComm(reinterpret_cast<PetscObject>(solver.snes)), PETSC_ERR_ARG_OUTOFRANGE,
             "rule '%s' chose the weight %g, which must be finite and not negative",
             solver.options.filter.c_str(), *weight);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Direct solvers may then use Cholesky factors; said after assembly, or PETSc forgets it.
PetscErrorCode say_symmetric(const Solver &solver, Mat H) {
  PetscFunctionBeginUser;
  PetscCall(MatSetOption(H, MAT_SYMMETRIC, PETSC_TRUE));
  // MUMPS keeps to what the first matrix was: a rule that may meet indefinite ones never says SPD.
  const bool definite =
      solver.jacobian.is_definite_by_construction() && !solver.rule->may_be_rejected();
  PetscCall(MatSetOption(H, MAT_SPD, definite ? PETSC_TRUE : PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether the linear solver multiplies by J beside solving with H.
PetscErrorCode multiplies_by(SNES snes, Mat J, Mat H, bool *multiplies) {
  KSP ksp = nullptr;
  PetscBool direct = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &direct));
  *multiplies = J != H && !direct;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A host may keep the operator J apart from the matrix H that is filtered. Where they are the same
/// numbers, J is filtered as well; otherwise a Krylov solver would go by what is not.
/// @param same whether J is to become the filtered matrix
PetscErrorCode check_operator(Solver &solver, Mat J, Mat H, InsertionCounts *counts, bool *same) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(solver.snes));
  PetscFunctionBeginUser;
  if (!is_matrix_free(J) && !is_matrix_free(H)) PetscCall(are_equal(J, H, same));
  if (*same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!solver.options.strict, comm, PETSC_ERR_SUP,
             "the Jacobian's two matrices differ, and the Krylov solver multiplies by the one that "
             "is not filtered: use one matrix for both, -ksp_type preonly, or "
             "-snes_trefoil_strict false to go on like that");
  counts->unseen = 1;
  PetscCall(solver.note("the Krylov solver multiplies by a matrix that is not filtered"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Assembles H and N, by whichever callback there is, and forms H + 2 w N.
PetscErrorCode assemble(Solver &solver, Vec x, Mat J, Mat H, double weight) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(solver.snes));
  const SolverOptions &options = solver.options;
  const bool filtered = weight != 0;
  const EigenvalueFloor floor = solver.floor(weight);
  InsertionCounts counts;
  double filter_seconds = 0;
  bool multiplies = false, same = false, at_once = false;
  PetscFunctionBeginUser;
  if (filtered) PetscCall(check_capabilities(comm, options, solver.split_jacobian, floor));
  solver.record.clock.switch_to(Phase::assembly);
  PetscCall(PetscLogEventBegin(event_assembly, solver.snes, x, H, nullptr));
  if (solver.split_jacobian) {
    PetscCall(forms_at_once(solver, weight, &at_once));
    PetscCall(compute_split(solver, x, H, filtered && !at_once, &counts, &filter_seconds));
  } else if (filtered) {
    PetscCall(solver.host_jacobian.compute_watched(solver.snes, x, J, H, options.fields,
                                                   options.strict, floor, solver.jacobian, &counts,
                                                   &filter_seconds));
  } else {
    PetscCall(solver.host_jacobian.compute(solver.snes, x, J, H));
  }
  if (J != H && is_matrix_free(J)) {  // -snes_mf_operator; hosts that only know H leave it out
    PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  }
  if (filtered && !at_once) PetscCall(solver.jacobian_test.run(solver.snes));
  PetscCall(multiplies_by(solver.snes, J, H, &multiplies));
  if (filtered && multiplies) PetscCall(check_operator(solver, J, H, &counts, &same));
  if (filtered && is_matrix_free(H)) {
    PetscCall(solver.note("the Jacobian is matrix-free: nothing of it is filtered"));
  }
  if (counts.changed > 0) {
    PetscCall(
        solver.note("the Jacobian is not the sum of the element blocks that were added to it"));
  }
  if (at_once) {
    const auto &product = solver.split_jacobian.product;
    PetscCall(solver.jacobian.take_formed(H, weight, counts, [&solver, product](Vec p, Vec Hp) {
      return product.function(solver.snes, p, Hp, product.context);
    }));
  } else {
    PetscCall(solver.jacobian.form(H, weight, filtered, counts));
  }
  if (same) PetscCall(MatCopy(H, J, DIFFERENT_NONZERO_PATTERN));
  if (solver.split_jacobian) PetscCall(say_symmetric(solver, H));
  PetscCall(PetscLogEventEnd(event_assembly, solver.snes, x, H, nullptr));
  PetscCallMPI(MPI_Barrier(comm));  // or waiting for each other would count as solving, too
  solver.record.clock.switch_to(Phase::linear_solve);
  solver.record.clock.move(Phase::assembly, Phase::filter, filter_seconds);
  const auto elements = static_cast<double>(counts.elements);
  solver.record.current.indefinite = !filtered ? IterationRecord::none
                                     : elements > 0
                                         ? static_cast<double>(counts.indefinite) / elements
                                         : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where the filter may leave the Jacobian indefinite and the linear solver's factors tell: makes
/// them here already and asks the rule for another weight as long as they say that it is. The
/// linear solve finds the factors done. (A package that raises an error where the matrix is not
/// positive definite would end the solve there.)
PetscErrorCode settle_weight(Solver &solver, Vec x, Mat J, Mat H) {
  IterationRecord &current = solver.record.current;
  KSP ksp = nullptr;
  PC pc = nullptr;
  bool factors = false;
  PetscFunctionBeginUser;
  if (!solver.driven || !solver.rule->may_be_rejected()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetKSP(solver.snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(makes_signed_factors(ksp, &factors));
  while (factors && current.weight < 0.5) {
    Inertia inertia = Inertia::indefinite;
    PetscErrorCode failure = PETSC_SUCCESS;
    PetscCall(KSPSetOperators(ksp, J, H));
    PetscCall(try_to_factor(pc, &failure));
    PetscCheck(!failure || failure == PETSC_ERR_MAT_CH_ZRPVT,
               PetscObjectComm(reinterpret_cast<PetscObject>(solver.snes)), failure,
               "the factorisation of the Hessian failed");
    if (!failure) PetscCall(inertia_of_factors(ksp, &inertia));
    if (inertia != Inertia::indefinite) break;
    const std::optional<double> weight = solver.rule->rejected(current);
    if (!weight) break;  // the linear solve will say so
    ++current.refused;
    ++solver.record.factorisations;
    current.weight = *weight;
    PetscCall(assemble(solver, x, J, H, *weight));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// SNES's Jacobian callback: asks the rule for w, the split callback or the host's own, watched,
/// for H and N, and forms H + 2 w N.
PetscErrorCode compute_filtered_jacobian(SNES snes, Vec x, Mat J, Mat H, void *ctx) {
  auto &solver = *static_cast<Solver *>(ctx);
  SolveRecord &record = solver.record;
  const bool again = solver.jacobian.imposed_weight.has_value();
  PetscInt iteration = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(snes, &iteration));
  // A solve that ended in an error has not said so.
  if (iteration == 0 && !again && !record.history.empty()) record.running = false;
  PetscCall(solver.begin_solve());
  record.clock.switch_to(Phase::assembly);
  PetscCall(solver.jacobian_test.restore(snes));
  PetscCall(is_driven(snes, &solver.driven));
  PetscCheck(solver.driven || !solver.energy.max_step_callback,
             PetscObjectComm(reinterpret_cast<PetscObject>(snes)), PETSC_ERR_SUP,
             "this solver knows no largest step (TrefoilSNESSetMaxStep()): use -snes_type trefoil");
  record.current.k = static_cast<int>(iteration);
  PetscCall(choose_weight(solver, &record.current.weight));
  if (!solver.driven) PetscCall(solver.allow_linear_failures(false));
  if (!solver.driven && solver.split_jacobian) PetscCall(record_foreign_iteration(solver, x));
  if (!again) record.current.refused = 0;
  if (solver.uses_hessian() || !solver.driven) {
    PetscCall(assemble(solver, x, J, H, record.current.weight));
    PetscCall(settle_weight(solver, x, J, H));
  } else {
    PetscCall(form_proxy(solver, J, H));
  }
  if (!again) {
    ++record.iterations;
    solver.jacobian_is_new = true;
  }
  ++record.linear_solves;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode install_jacobian(Solver &solver) {
  PetscErrorCode (*present)(SNES, Vec, Mat, Mat, void *) = nullptr;
  Mat J = nullptr, H = nullptr;
  void *context = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESGetJacobian(solver.snes, &J, &H, &present, &context));
  if (!present || present == compute_filtered_jacobian) PetscFunctionReturn(PETSC_SUCCESS);
  // A host's callback set after a split one replaces it, as SNESSetJacobian() promises.
  solver.split_jacobian = {};
  PetscCall(solver.host_jacobian.take_over(solver.snes, present, context));
  PetscCall(SNESSetJacobian(solver.snes, J, H, compute_filtered_jacobian, &solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode install_split_jacobian(Solver &solver, Mat H) {
  PetscFunctionBeginUser;
  PetscCall(solver.jacobian.forget_negative());
  PetscCall(SNESSetJacobian(solver.snes, H, H, compute_filtered_jacobian, &solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
