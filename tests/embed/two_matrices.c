/* A chain of bistable bars whose SNES has an operator A beside the matrix P that preconditions it:
     -same   A has P's numbers;  otherwise its ground springs are ten times as stiff.
     -one    A is P. */
#include <petscsnes.h>

typedef struct {
  PetscInt n;
  PetscBool same;
} Chain;

static PetscErrorCode Residual(SNES snes, Vec x, Vec f, void *ctx)
{
  const PetscInt     n = ((Chain *)ctx)->n;
  const PetscScalar *v;
  PetscScalar       *g;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(x, &v));
  PetscCall(VecGetArray(f, &g));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal s = v[i] - (i ? v[i - 1] : 0), force = s * s * s - s;
    g[i] = force + 0.05 * (v[i] - 1.2 * (i + 1));
    if (i) g[i - 1] -= force;
  }
  PetscCall(VecRestoreArray(f, &g));
  PetscCall(VecRestoreArrayRead(x, &v));
  PetscFunctionReturn(0);
}

static PetscErrorCode Fill(PetscInt n, const PetscScalar *v, PetscScalar ground, Mat M)
{
  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(M));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal   s = v[i] - (i ? v[i - 1] : 0), k = 3 * s * s - 1;
    const PetscInt    index[] = {i - 1, i};
    const PetscScalar block[] = {k, -k, -k, k};
    PetscCall(MatSetValues(M, 2, index, 2, index, block, ADD_VALUES));
    PetscCall(MatSetValue(M, i, i, ground, ADD_VALUES));
  }
  PetscCall(MatAssemblyBegin(M, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(M, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

static PetscErrorCode Jacobian(SNES snes, Vec x, Mat A, Mat P, void *ctx)
{
  const Chain       *chain = (Chain *)ctx;
  const PetscScalar *v;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(x, &v));
  PetscCall(Fill(chain->n, v, 0.05, P));
  if (A != P) PetscCall(Fill(chain->n, v, chain->same ? 0.05 : 0.5, A));
  PetscCall(VecRestoreArrayRead(x, &v));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  Chain               chain = {20, PETSC_FALSE};
  SNES                snes;
  Mat                 A, P;
  Vec                 x;
  PetscReal           norm;
  PetscInt            iterations;
  SNESConvergedReason reason;
  PetscBool           one = PETSC_FALSE;

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-same", &chain.same, NULL));
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-one", &one, NULL));
  PetscCall(MatCreateSeqAIJ(PETSC_COMM_SELF, chain.n, chain.n, 3, NULL, &P));
  PetscCall(MatCreateSeqAIJ(PETSC_COMM_SELF, chain.n, chain.n, 3, NULL, &A));
  PetscCall(MatCreateVecs(P, &x, NULL));
  for (PetscInt i = 0; i < chain.n; i++) PetscCall(VecSetValue(x, i, 0.1 * (i + 1), INSERT_VALUES));
  PetscCall(VecAssemblyBegin(x));
  PetscCall(VecAssemblyEnd(x));
  PetscCall(SNESCreate(PETSC_COMM_SELF, &snes));
  PetscCall(SNESSetFunction(snes, NULL, Residual, &chain));
  PetscCall(SNESSetJacobian(snes, one ? P : A, P, Jacobian, &chain));
  PetscCall(SNESSetFromOptions(snes));
  PetscCall(SNESSolve(snes, NULL, x));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  PetscCall(SNESGetIterationNumber(snes, &iterations));
  PetscCall(VecNorm(x, NORM_2, &norm));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "%s iterations %d norm %.12e\n", SNESConvergedReasons[reason], (int)iterations, (double)norm));
  PetscCall(SNESDestroy(&snes));
  PetscCall(MatDestroy(&A));
  PetscCall(MatDestroy(&P));
  PetscCall(VecDestroy(&x));
  PetscCall(PetscFinalize());
  return 0;
}
