// A host that ends PETSc from the destructor of a static object, in the manner of legacy DOLFIN:
// after the destructors of libraries that were loaded later, the plugin's for one.
#include <petscsnes.h>

namespace {

/// f(x) = sum of x_i^4 / 4 - x_i, in blocks of two unknowns.
PetscErrorCode residual(SNES, Vec x, Vec f, void *) {
  const PetscScalar *v = nullptr;
  PetscScalar *g = nullptr;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(x, &v));
  PetscCall(VecGetArray(f, &g));
  for (PetscInt i = 0; i < n; ++i) g[i] = v[i] * v[i] * v[i] - 1;
  PetscCall(VecRestoreArray(f, &g));
  PetscCall(VecRestoreArrayRead(x, &v));
  PetscFunctionReturn(0);
}

PetscErrorCode jacobian(SNES, Vec x, Mat, Mat H, void *) {
  const PetscScalar *v = nullptr;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(x, &v));
  PetscCall(MatZeroEntries(H));
  for (PetscInt i = 0; i < n; i += 2) {
    const PetscInt index[] = {i, i + 1};
    const PetscScalar block[] = {3 * v[i] * v[i], 0, 0, 3 * v[i + 1] * v[i + 1]};
    PetscCall(MatSetValues(H, 2, index, 2, index, block, ADD_VALUES));
  }
  PetscCall(VecRestoreArrayRead(x, &v));
  PetscCall(MatAssemblyBegin(H, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(H, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/// What outlives main().
struct Session {
  SNES snes = nullptr;
  Mat H = nullptr;
  Vec x = nullptr;
  bool begun = false;

  ~Session() {
    if (!begun) return;
    static_cast<void>(SNESDestroy(&snes));
    static_cast<void>(MatDestroy(&H));
    static_cast<void>(VecDestroy(&x));
    static_cast<void>(PetscFinalize());
  }
} session;

}  // namespace

int main(int argc, char **argv) {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  PetscReal norm = 0;
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  session.begun = true;
  PetscCall(MatCreateSeqAIJ(PETSC_COMM_SELF, 10, 10, 2, nullptr, &session.H));
  PetscCall(MatCreateVecs(session.H, &session.x, nullptr));
  PetscCall(VecSet(session.x, 3));
  PetscCall(SNESCreate(PETSC_COMM_SELF, &session.snes));
  PetscCall(SNESSetFunction(session.snes, nullptr, residual, nullptr));
  PetscCall(SNESSetJacobian(session.snes, session.H, session.H, jacobian, nullptr));
  PetscCall(SNESSetFromOptions(session.snes));
  PetscCall(SNESSolve(session.snes, nullptr, session.x));
  PetscCall(SNESGetConvergedReason(session.snes, &reason));
  PetscCall(SNESGetIterationNumber(session.snes, &iterations));
  PetscCall(VecNorm(session.x, NORM_INFINITY, &norm));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "%s iterations %d norm %.12e\n",
                        SNESConvergedReasons[reason], static_cast<int>(iterations),
                        static_cast<double>(norm)));
  return 0;
}
