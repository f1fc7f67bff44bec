#include "snes/solve_context.hpp"

#include <petsc/private/petscimpl.h>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

SolveContext::~SolveContext() {
  // Errors, if any, have nowhere to go from a destructor; PETSc has printed them.
  static_cast<void>(release_host_matrix(*this));
  static_cast<void>(MatDestroy(&negative));
  static_cast<void>(VecDestroy(&previous_step));
  static_cast<void>(PetscObjectDereference(host_context_keeper));
}

TREFOIL_CONTEXT_DESTROY(destroy_solve_context, context) {
  PetscFunctionBeginUser;
  delete TREFOIL_CONTEXT_OF(SolveContext, context);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// PETSc calls this at the end of every SNESSolve, whatever SNES type drives our line search.
static PetscErrorCode end_of_solve(SNES, void *context) {
  PetscFunctionBeginUser;
  PetscCall(end_solve(*static_cast<SolveContext *>(context)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode get_solve_context(SNES snes, SolveContext **context) {
  constexpr const char *key = "trefoil_solve_context";
  PetscContainer container = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectQuery(reinterpret_cast<PetscObject>(snes), key,
                             reinterpret_cast<PetscObject *>(&container)));
  if (container) {
    void *stored = nullptr;
    PetscCall(PetscContainerGetPointer(container, &stored));
    *context = static_cast<SolveContext *>(stored);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  auto *made = new SolveContext;
  made->snes = snes;
  made->rule = make_rule(made->options.filter, made->options.rule);
  PetscCall(PetscContainerCreate(PetscObjectComm(reinterpret_cast<PetscObject>(snes)), &container));
  PetscCall(PetscContainerSetPointer(container, made));
  PetscCall(PetscContainerSetCtxDestroy(container, destroy_solve_context));
  PetscCall(PetscObjectCompose(reinterpret_cast<PetscObject>(snes), key,
                               reinterpret_cast<PetscObject>(container)));
  PetscCall(PetscContainerDestroy(&container));
  PetscCall(SNESConvergedReasonViewSet(snes, end_of_solve, made, nullptr));
  *context = made;
  PetscFunctionReturn(PETSC_SUCCESS);
}

EigenvalueFloor eigenvalue_floor(const SolveContext &context) {
  const double own = context.options.floor;
  return {own >= 0 ? own : context.rule->floor(), context.current.weight};
}

PetscErrorCode begin_solve(SolveContext &context) {
  PetscFunctionBeginUser;
  if (context.running) PetscFunctionReturn(PETSC_SUCCESS);
  context.running = true;
  context.clock.start(Phase::assembly);          // the first residual
  const double weight = context.current.weight;  // of the Jacobian, which a SNES may keep
  context.current = IterationRecord{};
  context.current.weight = weight;
  context.jacobian_is_new = false;
  context.instead_of_rejected.reset();
  context.history.clear();
  context.summary = SolveSummary{};
  context.energy_state = -1;
  context.energy = 0;
  context.unfiltered = {};
  context.previous_step_known = false;
  PetscCall(VecDestroy(&context.previous_step));  // the next problem may have another size
  context.trusted = context.options.trust_start;
  context.boundary_values_open = !context.split_jacobian;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode energy_at(SolveContext &context, Vec x, double *energy) {
  PetscErrorCode (*objective)(SNES, Vec, PetscReal *, void *) = nullptr;
  PetscObjectId id = 0;
  PetscObjectState state = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESGetObjective(context.snes, &objective, nullptr));
  if (!objective) {
    *energy = context.energy;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscObjectGetId(reinterpret_cast<PetscObject>(x), &id));
  PetscCall(PetscObjectStateGet(reinterpret_cast<PetscObject>(x), &state));
  if (id != context.energy_vector || state != context.energy_state) {
    PetscReal value = 0;
    PetscCall(SNESComputeObjective(context.snes, x, &value));
    PetscCall(remember_energy(context, x, value));
  }
  *energy = context.energy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode remember_energy(SolveContext &context, Vec x, double energy) {
  PetscFunctionBeginUser;
  PetscCall(PetscObjectGetId(reinterpret_cast<PetscObject>(x), &context.energy_vector));
  PetscCall(PetscObjectStateGet(reinterpret_cast<PetscObject>(x), &context.energy_state));
  context.energy = energy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
