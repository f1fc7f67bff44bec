/*
   Time steps by PETSc's TSALPHA2, generalised-alpha for M u'' + f(u) = 0, in a code that knows nothing
   of Trefoil. A rope of elastic bars in the plane swings about a stiff spring at its upper end:

     mpirun -n 2 ./swing                                                  PETSc's Newton
     mpirun -n 2 ./swing -dll_append libtrefoil.so -snes_type trefoil     filtered, an option only

   A bar of length h and stiffness EA has the energy EA h e^2 / 2 of Green's strain
   e = (|d|^2 / h^2 - 1) / 2, d from its one end to the other; compressed ones have a negative
   eigenvalue. The Jacobian of a step is shiftA M + K, symmetric. A bar adds its part of both in one
   MatSetValues(), so that the filter sees stiffness and inertia together.

   Options: -bars <40>, and PETSc's -ts_dt, -ts_max_time, -ts_alpha_radius
*/
static char help[] = "A rope that swings, by TSALPHA2.\n\n";

#include <petscdmda.h>
#include <petscts.h>

typedef struct {
  PetscInt  bars;
  PetscReal stiffness, density, gravity, spring;
} Rope;

/* Forces (4) and stiffness (4 x 4) of the bar between displacements a and b; it lies along x at rest. */
static void Bar(const Rope *rope, const PetscScalar *a, const PetscScalar *b, PetscReal f[4], PetscReal K[16])
{
  const PetscReal h = 1.0 / rope->bars, d[2] = {h + b[0] - a[0], b[1] - a[1]};
  const PetscReal e = ((d[0] * d[0] + d[1] * d[1]) / (h * h) - 1) / 2;

  for (int i = 0; i < 2; ++i) {
    f[2 + i] = rope->stiffness * e * d[i] / h;
    f[i]     = -f[2 + i];
    for (int j = 0; j < 2; ++j) {
      const PetscReal k = rope->stiffness / h * ((i == j ? e : 0) + d[i] * d[j] / (h * h));
      K[4 * i + j] = K[4 * (2 + i) + 2 + j] = k;
      K[4 * i + 2 + j] = K[4 * (2 + i) + j] = -k;
    }
  }
}

/* M a + f(u) where F is given, shift M + K where J is. Each rank has the bars that begin at its nodes. */
static PetscErrorCode Assemble(TS ts, Vec U, Vec A, Vec F, PetscReal shift, Mat J, const Rope *rope)
{
  DM              dm;
  Vec             local_u, local_a, local_f;
  PetscScalar    *u, *a, *f;
  PetscInt        begin, count;
  const PetscReal mass = rope->density / rope->bars / 2; /* of a bar, at each of its ends */

  PetscFunctionBeginUser;
  PetscCall(TSGetDM(ts, &dm));
  PetscCall(DMGetLocalVector(dm, &local_u));
  PetscCall(DMGetLocalVector(dm, &local_a));
  PetscCall(DMGetLocalVector(dm, &local_f));
  PetscCall(DMGlobalToLocal(dm, U, INSERT_VALUES, local_u));
  PetscCall(DMGlobalToLocal(dm, A, INSERT_VALUES, local_a));
  PetscCall(VecSet(local_f, 0));
  PetscCall(VecGetArray(local_u, &u));
  PetscCall(VecGetArray(local_a, &a));
  PetscCall(VecGetArray(local_f, &f));
  {
    PetscInt ghost_begin, ghost_count;

    PetscCall(DMDAGetCorners(dm, &begin, NULL, NULL, &count, NULL, NULL));
    PetscCall(DMDAGetGhostCorners(dm, &ghost_begin, NULL, NULL, &ghost_count, NULL, NULL));
    for (PetscInt bar = begin; bar < begin + count && bar < rope->bars; ++bar) {
      const PetscInt node = bar - ghost_begin, dofs[4] = {2 * node, 2 * node + 1, 2 * node + 2, 2 * node + 3};
      PetscReal      force[4], K[16];

      Bar(rope, u + dofs[0], u + dofs[2], force, K);
      for (int i = 0; i < 4; ++i) {
        f[dofs[i]] += mass * a[dofs[i]] + force[i] + (i % 2 ? mass * rope->gravity : 0);
        K[4 * i + i] += shift * mass;
      }
      for (int i = 0; bar == 0 && i < 2; ++i) {
        f[dofs[i]] += rope->spring * u[dofs[i]];
        K[4 * i + i] += rope->spring;
      }
      if (J) PetscCall(MatSetValuesLocal(J, 4, dofs, 4, dofs, K, ADD_VALUES));
    }
  }
  PetscCall(VecRestoreArray(local_f, &f));
  PetscCall(VecRestoreArray(local_a, &a));
  PetscCall(VecRestoreArray(local_u, &u));
  if (F) {
    PetscCall(VecSet(F, 0));
    PetscCall(DMLocalToGlobal(dm, local_f, ADD_VALUES, F));
  }
  PetscCall(DMRestoreLocalVector(dm, &local_f));
  PetscCall(DMRestoreLocalVector(dm, &local_a));
  PetscCall(DMRestoreLocalVector(dm, &local_u));
  PetscFunctionReturn(0);
}

static PetscErrorCode Residual(TS ts, PetscReal t, Vec U, Vec V, Vec A, Vec F, void *rope)
{
  PetscFunctionBeginUser;
  PetscCall(Assemble(ts, U, A, F, 0, NULL, (const Rope *)rope));
  PetscFunctionReturn(0);
}

static PetscErrorCode Jacobian(TS ts, PetscReal t, Vec U, Vec V, Vec A, PetscReal shift_v, PetscReal shift_a, Mat J, Mat P, void *rope)
{
  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(P));
  PetscCall(Assemble(ts, U, A, NULL, shift_a, P, (const Rope *)rope));
  PetscCall(MatAssemblyBegin(P, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(P, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  Rope      rope = {40, 1e3, 1, 9.81, 1e5};
  DM        dm;
  TS        ts;
  Mat       J;
  Vec       U, V;
  PetscInt  iterations, steps;
  PetscReal norm;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bars", &rope.bars, NULL));
  PetscCall(DMDACreate1d(PETSC_COMM_WORLD, DM_BOUNDARY_NONE, rope.bars + 1, 2, 1, NULL, &dm));
  PetscCall(DMSetUp(dm));
  PetscCall(DMCreateMatrix(dm, &J));
  PetscCall(DMCreateGlobalVector(dm, &U));
  PetscCall(VecDuplicate(U, &V));
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(TSSetDM(ts, dm));
  PetscCall(TSSetType(ts, TSALPHA2));
  PetscCall(TSSetI2Function(ts, NULL, Residual, &rope));
  PetscCall(TSSetI2Jacobian(ts, J, J, Jacobian, &rope));
  PetscCall(TSSetTimeStep(ts, 0.01));
  PetscCall(TSSetMaxTime(ts, 0.5));
  PetscCall(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
  PetscCall(TS2SetSolution(ts, U, V));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSSolve(ts, NULL));
  PetscCall(TSGetSNESIterations(ts, &iterations));
  PetscCall(TSGetStepNumber(ts, &steps));
  PetscCall(VecNorm(U, NORM_2, &norm));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%d steps, CONVERGED iterations %d norm %.14g\n", (int)steps, (int)iterations, (double)norm));
  PetscCall(TSDestroy(&ts));
  PetscCall(MatDestroy(&J));
  PetscCall(VecDestroy(&U));
  PetscCall(VecDestroy(&V));
  PetscCall(DMDestroy(&dm));
  PetscCall(PetscFinalize());
  return 0;
}
