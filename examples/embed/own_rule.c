/*
   A filter rule of one's own: after a full step that the quadratic model predicted well, a quarter of
   the weight, so that the end is Newton's method; after any other step, absolute eigenvalues.

   The problem: many Rosenbrock functions 100 (b - a^2)^2 + (1 - a)^2 side by side, one element each;
   the Hessian is indefinite where b > a^2 + 1/200.

     mpirun -n 2 ./own_rule -snes_trefoil_monitor
     mpirun -n 2 ./own_rule -snes_trefoil_filter adaptive     the paper's rule instead

   Options: -elements <1000>
*/
static char help[] = "Rosenbrock functions; a rule of one's own.\n\n";

#include <trefoil.h>

static PetscErrorCode QuarterOrAbsolute(SNES snes, const TrefoilIteration *last, PetscReal *weight, void *ctx)
{
  PetscFunctionBeginUser;
  if (!last || last->step < 1 || PetscAbsReal(last->rho - 1) > *(PetscReal *)ctx || PetscIsNanReal(last->rho)) *weight = 1;
  else *weight = last->weight > 0.1 ? last->weight / 4 : 0;
  PetscFunctionReturn(0);
}

static PetscErrorCode Energy(SNES snes, Vec x, PetscReal *energy, void *ctx)
{
  const PetscScalar *u;
  PetscInt           n;

  PetscFunctionBeginUser;
  *energy = 0;
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(x, &u));
  for (PetscInt i = 0; i < n; i += 2) *energy += 100 * PetscSqr(u[i + 1] - u[i] * u[i]) + PetscSqr(1 - u[i]);
  PetscCall(VecRestoreArrayRead(x, &u));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, energy, 1, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)x)));
  PetscFunctionReturn(0);
}

static PetscErrorCode Gradient(SNES snes, Vec x, Vec g, void *ctx)
{
  const PetscScalar *u;
  PetscScalar       *f;
  PetscInt           n;

  PetscFunctionBeginUser;
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(x, &u));
  PetscCall(VecGetArrayWrite(g, &f));
  for (PetscInt i = 0; i < n; i += 2) {
    f[i]     = -400 * u[i] * (u[i + 1] - u[i] * u[i]) - 2 * (1 - u[i]);
    f[i + 1] = 200 * (u[i + 1] - u[i] * u[i]);
  }
  PetscCall(VecRestoreArrayWrite(g, &f));
  PetscCall(VecRestoreArrayRead(x, &u));
  PetscFunctionReturn(0);
}

static PetscErrorCode Hessian(SNES snes, Vec x, Mat J, Mat H, void *ctx)
{
  const PetscScalar *u;
  PetscInt           begin, end;

  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(H));
  PetscCall(VecGetOwnershipRange(x, &begin, &end));
  PetscCall(VecGetArrayRead(x, &u));
  for (PetscInt i = begin; i < end; i += 2) {
    const PetscScalar a = u[i - begin], b = u[i - begin + 1];
    const PetscInt    index[] = {i, i + 1};
    const PetscScalar He[]    = {1200 * a * a - 400 * b + 2, -400 * a, -400 * a, 200};
    PetscCall(MatSetValues(H, 2, index, 2, index, He, ADD_VALUES));
  }
  PetscCall(VecRestoreArrayRead(x, &u));
  PetscCall(MatAssemblyBegin(H, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(H, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  PetscInt            elements = 1000, n = 2, begin, end, iterations;
  PetscReal           well_predicted = 0.25, energy;
  Vec                 x;
  Mat                 H;
  SNES                snes;
  PetscBool           chosen;
  SNESConvergedReason reason;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(TrefoilRuleRegister("quarter_or_absolute", QuarterOrAbsolute, &well_predicted));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-elements", &elements, NULL));
  PetscCall(VecCreate(PETSC_COMM_WORLD, &x));
  PetscCall(VecSetSizes(x, PETSC_DECIDE, 2 * elements));
  PetscCall(VecSetBlockSize(x, 2));
  PetscCall(VecSetFromOptions(x));
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(MatCreateAIJ(PETSC_COMM_WORLD, n, n, PETSC_DETERMINE, PETSC_DETERMINE, 2, NULL, 0, NULL, &H));

  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(SNESSetType(snes, SNESTREFOIL));
  PetscCall(SNESSetObjective(snes, Energy, NULL));
  PetscCall(SNESSetFunction(snes, NULL, Gradient, NULL));
  PetscCall(SNESSetJacobian(snes, H, H, Hessian, NULL));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-snes_trefoil_filter", &chosen));
  if (!chosen) PetscCall(PetscOptionsSetValue(NULL, "-snes_trefoil_filter", "quarter_or_absolute"));
  PetscCall(SNESSetFromOptions(snes));

  /* Starts of every kind, indefinite ones among them. */
  PetscScalar *u;
  PetscCall(VecGetOwnershipRange(x, &begin, &end));
  PetscCall(VecGetArray(x, &u));
  for (PetscInt i = begin; i < end; i += 2) {
    u[i - begin]     = 1.5 * PetscSinReal(i);
    u[i - begin + 1] = 2 * PetscCosReal(3 * i);
  }
  PetscCall(VecRestoreArray(x, &u));
  PetscCall(SNESSolve(snes, NULL, x));
  PetscCall(Energy(snes, x, &energy, NULL));
  PetscCall(SNESGetIterationNumber(snes, &iterations));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s iterations %" PetscInt_FMT " energy %.3e\n", SNESConvergedReasons[reason], iterations, (double)energy));

  PetscCall(SNESDestroy(&snes));
  PetscCall(MatDestroy(&H));
  PetscCall(VecDestroy(&x));
  PetscCall(PetscFinalize());
  return 0;
}
