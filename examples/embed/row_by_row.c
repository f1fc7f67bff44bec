/*
   A code that adds its element matrices row by row, as many do, so that nobody can see the elements:
   one call, TrefoilMatSetElementValues(), takes the place of the loop over the rows.

   The problem: a chain of bistable links on an elastic foundation, fixed at one end and pulled at
   the other. Energy: sum over the links of h [ (e^2 - 1)^2 / 4 + k/4 (u_a^2 + u_b^2) ], where
   e = (u_b - u_a) / h; concave, and the Hessian indefinite, wherever |e| < 0.577.

     mpirun -n 2 ./row_by_row                 through Trefoil
     mpirun -n 2 ./row_by_row -by_rows        Trefoil says what it cannot see
     mpirun -n 2 ./row_by_row -by_rows -snes_type newtonls    without it

   Options: -links <200>, -pull <0.3>, -by_rows
*/
static char help[] = "A chain of bistable links; Trefoil's call for whole elements.\n\n";

#include <petscdmda.h>
#include <trefoil.h>

typedef struct {
  PetscInt  links;
  PetscReal pull, foundation;
  PetscBool by_rows;
} Chain;

/* Energy of a link, its gradient and its Hessian (2 x 2). */
static PetscReal Link(const Chain *chain, const PetscScalar u[2], PetscReal g[2], PetscReal H[4])
{
  const PetscReal h = 1.0 / chain->links, k = chain->foundation, e = (u[1] - u[0]) / h, well = e * e - 1;
  const PetscReal slope = e * well, curvature = (3 * e * e - 1) / h;

  g[0] = -slope + k * h / 2 * u[0];
  g[1] = slope + k * h / 2 * u[1];
  H[0] = H[3] = curvature + k * h / 2;
  H[1] = H[2] = -curvature;
  return h * (well * well / 4 + k / 4 * (u[0] * u[0] + u[1] * u[1]));
}

/* The links that begin at this rank's nodes: energy, gradient, Hessian, each where wanted. */
static PetscErrorCode Assemble(SNES snes, Vec x, PetscReal *energy, Vec gradient, Mat hessian, const Chain *chain)
{
  DM                     dm;
  Vec                    local_x, local_g;
  PetscScalar           *u, *f;
  PetscInt               begin, count;

  PetscFunctionBeginUser;
  PetscCall(SNESGetDM(snes, &dm));
  PetscCall(DMGetLocalVector(dm, &local_x));
  PetscCall(DMGetLocalVector(dm, &local_g));
  PetscCall(DMGlobalToLocal(dm, x, INSERT_VALUES, local_x));
  PetscCall(VecSet(local_g, 0));
  PetscCall(DMDAVecGetArray(dm, local_x, &u));
  PetscCall(DMDAVecGetArray(dm, local_g, &f));
  PetscCall(DMDAGetCorners(dm, &begin, NULL, NULL, &count, NULL, NULL));
  for (PetscInt node = begin; node < begin + count; node++) {
    PetscReal g[2], H[4];
    PetscInt  ends[2] = {node, node + 1}, index[2];
    if (node == chain->links) break;
    const PetscReal e = Link(chain, u + node, g, H);
    if (energy) *energy += e;
    f[node] += g[0];
    f[node + 1] += g[1];
    /* Held ends take no part: their rows and columns are left out as negative indices. */
    for (int i = 0; i < 2; i++) index[i] = ends[i] == 0 || ends[i] == chain->links ? -1 : ends[i];
    if (hessian && chain->by_rows) {
      for (int i = 0; i < 2; i++) PetscCall(MatSetValues(hessian, 1, &index[i], 2, index, &H[2 * i], ADD_VALUES));
    } else if (hessian) {
      PetscCall(TrefoilMatSetElementValues(hessian, 2, index, H));
    }
  }
  for (PetscInt node = begin; node < begin + count; node++) {
    if (node > 0 && node < chain->links) continue;
    if (hessian) PetscCall(MatSetValue(hessian, node, node, 1, ADD_VALUES));
  }
  PetscCall(DMDAVecRestoreArray(dm, local_g, &f));
  if (gradient) {
    PetscScalar *r;
    PetscCall(VecSet(gradient, 0));
    PetscCall(DMLocalToGlobal(dm, local_g, ADD_VALUES, gradient));
    PetscCall(DMDAVecGetArray(dm, gradient, &r));
    if (begin == 0) r[0] = u[0];
    if (begin + count == chain->links + 1) r[chain->links] = u[chain->links] - chain->pull;
    PetscCall(DMDAVecRestoreArray(dm, gradient, &r));
  }
  PetscCall(DMDAVecRestoreArray(dm, local_x, &u));
  PetscCall(DMRestoreLocalVector(dm, &local_g));
  PetscCall(DMRestoreLocalVector(dm, &local_x));
  PetscFunctionReturn(0);
}

static PetscErrorCode Energy(SNES snes, Vec x, PetscReal *energy, void *ctx)
{
  PetscFunctionBeginUser;
  *energy = 0;
  PetscCall(Assemble(snes, x, energy, NULL, NULL, (Chain *)ctx));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, energy, 1, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
  PetscFunctionReturn(0);
}

static PetscErrorCode Gradient(SNES snes, Vec x, Vec g, void *ctx)
{
  PetscFunctionBeginUser;
  PetscCall(Assemble(snes, x, NULL, g, NULL, (Chain *)ctx));
  PetscFunctionReturn(0);
}

static PetscErrorCode Hessian(SNES snes, Vec x, Mat J, Mat H, void *ctx)
{
  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(H));
  PetscCall(Assemble(snes, x, NULL, NULL, H, (Chain *)ctx));
  PetscCall(MatAssemblyBegin(H, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(H, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  Chain               chain = {200, 0.3, 100, PETSC_FALSE};
  DM                  dm;
  SNES                snes;
  Vec                 x;
  Mat                 H;
  PetscReal           energy;
  PetscInt            begin, count, iterations;
  SNESConvergedReason reason;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(TrefoilInitializePackage());
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-links", &chain.links, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-pull", &chain.pull, NULL));
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-by_rows", &chain.by_rows, NULL));
  PetscCall(DMDACreate1d(PETSC_COMM_WORLD, DM_BOUNDARY_NONE, chain.links + 1, 1, 1, NULL, &dm));
  PetscCall(DMSetUp(dm));
  PetscCall(DMCreateGlobalVector(dm, &x));
  PetscCall(DMCreateMatrix(dm, &H));

  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(SNESSetDM(snes, dm));
  PetscCall(SNESSetType(snes, SNESTREFOIL));
  PetscCall(SNESSetObjective(snes, Energy, &chain));
  PetscCall(SNESSetFunction(snes, NULL, Gradient, &chain));
  PetscCall(SNESSetJacobian(snes, H, H, Hessian, &chain));
  PetscCall(SNESSetFromOptions(snes));

  /* A gentle wave to begin with: every link is in the concave part. */
  PetscScalar *u;
  PetscCall(DMDAVecGetArray(dm, x, &u));
  PetscCall(DMDAGetCorners(dm, &begin, NULL, NULL, &count, NULL, NULL));
  for (PetscInt i = begin; i < begin + count; i++) {
    const PetscReal s = (PetscReal)i / chain.links;
    u[i]              = chain.pull * s + 0.01 * PetscSinReal(3 * PETSC_PI * s);
  }
  PetscCall(DMDAVecRestoreArray(dm, x, &u));
  PetscCall(SNESSolve(snes, NULL, x));
  PetscCall(Energy(snes, x, &energy, &chain));
  PetscCall(SNESGetIterationNumber(snes, &iterations));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s iterations %" PetscInt_FMT " energy %.12e\n", SNESConvergedReasons[reason], iterations, (double)energy));

  PetscCall(SNESDestroy(&snes));
  PetscCall(MatDestroy(&H));
  PetscCall(VecDestroy(&x));
  PetscCall(DMDestroy(&dm));
  PetscCall(PetscFinalize());
  return 0;
}
