#include <petsc/private/snesimpl.h>

#include "snes/solver.hpp"
#include "support/petsc_compatibility.hpp"

extern "C" PetscErrorCode SNESCreate_NEWTONLS(SNES);

using trefoil::Solver;

namespace {

// PETSc's own line-search Newton method; the type `trefoil` is that with other defaults, its line
// search, and a beginning and an end for the record. Its operations are the same for every SNES.
struct _SNESOps newton_operations;

PetscErrorCode SNESSetUp_Trefoil(SNES snes) {
  SNESLineSearch search = nullptr;
  PetscBool ours = PETSC_FALSE;
  const char *type = nullptr;
  PetscFunctionBegin;
  PetscCall(SNESGetLineSearch(snes, &search));
  PetscCall(
      PetscObjectTypeCompare(reinterpret_cast<PetscObject>(search), SNESLINESEARCHTREFOIL, &ours));
  PetscCall(SNESLineSearchGetType(search, &type));
  PetscCheck(ours, PetscObjectComm(reinterpret_cast<PetscObject>(snes)), PETSC_ERR_USER_INPUT,
             "-snes_type trefoil has its own line search and cannot use '%s'; for another line "
             "search use -snes_type newtonls",
             type ? type : "none");
  PetscCall(newton_operations.setup(snes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SNESSolve_Trefoil(SNES snes) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  solver->record.running = false;  // also where the last solve ended in an error
  PetscCall(solver->begin_solve());
  PetscCall(trefoil::install_jacobian(*solver));
  PetscCall(newton_operations.solve(snes));
  PetscCall(solver->end_solve());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

/*MC
   SNESTREFOIL - minimises an energy by Newton's method with trust-region eigenvalue filtering

   SNESNEWTONLS with line search SNESLINESEARCHTREFOIL; the step and divergence tolerances of SNES
   are off, max_it is 200. See SNESLINESEARCHTREFOIL for the options.

   Level: intermediate
M*/
PetscErrorCode SNESCreate_Trefoil(SNES snes) {
  SNESLineSearch search = nullptr;
  Solver *solver = nullptr;
  PetscReal absolute = 0, relative = 0;
  PetscInt functions = 0;

  PetscFunctionBegin;
  PetscCall(SNESCreate_NEWTONLS(snes));
  newton_operations = *snes->ops;
  snes->ops->setup = SNESSetUp_Trefoil;
  snes->ops->solve = SNESSolve_Trefoil;
  PetscCall(SNESGetLineSearch(snes, &search));
  PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHTREFOIL));
  // A tiny step of a damped search is no convergence, and energies may rise far from the start.
  PetscCall(SNESGetTolerances(snes, &absolute, &relative, nullptr, nullptr, &functions));
  PetscCall(SNESSetTolerances(snes, absolute, relative, 0, 200, functions));
  PetscCall(SNESSetDivergenceTolerance(snes, PETSC_UNLIMITED));
  PetscCall(trefoil::get_solver(snes, &solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}
