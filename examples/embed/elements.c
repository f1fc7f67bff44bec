/*
   A PETSc code of one's own: linear tetrahedra, written by hand, on a block of rubber whose bottom
   is held and whose top is pulled. It knows nothing of Trefoil.

     mpirun -n 2 ./elements -cells 4
     mpirun -n 2 ./elements -cells 4 -dll_append ../../build/libtrefoil.so -snes_type trefoil

   Options: -cells <4> along an edge, -stretch <4> height over rest height, -poisson <0.3>,
   -blocked inserts by MatSetValuesBlocked, -objective gives SNES the energy, -mat_type aij|baij|sbaij
*/
static char help[] = "A block of rubber, stretched; elements by hand.\n\n";

#include <petscsnes.h>

typedef struct {
  PetscInt   cells, first, last; /* cells along an edge; this rank's layers of cells */
  PetscReal  mu, lambda, stretch;
  PetscBool  blocked;
  Vec        local; /* displacements of the vertices of this rank's cells */
  VecScatter to_local;
} Block;

/* Six tetrahedra of a cube around its main diagonal; bit i of a corner is its offset along axis i. */
static const PetscInt tetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                          {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

static PetscInt Vertex(const Block *block, PetscInt i, PetscInt j, PetscInt k)
{
  return i + (block->cells + 1) * (j + (block->cells + 1) * k);
}

static void Cofactor(PetscReal F[3][3], PetscReal C[3][3])
{
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      C[i][j] = F[i1][j1] * F[i2][j2] - F[i1][j2] * F[i2][j1];
    }
  }
}

/* Energy, force and Hessian of one tetrahedron with psi = mu/2 (F:F - 3) + lambda/2 (J - 1 - mu/lambda)^2. */
static PetscReal Element(const Block *block, PetscReal x[4][3], const PetscReal u[12], PetscReal f[12], PetscReal H[144])
{
  PetscReal D[3][3], C[3][3], G[4][3], F[3][3], c[4][3], volume, J = 0, squares = 0, pressure;

  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) D[i][j] = x[j + 1][i] - x[0][i];
  Cofactor(D, C);
  volume = (D[0][0] * C[0][0] + D[0][1] * C[0][1] + D[0][2] * C[0][2]) / 6;
  for (int i = 0; i < 3; i++) {
    G[0][i] = 0;
    for (int a = 1; a < 4; a++) {
      G[a][i] = C[i][a - 1] / (6 * volume);
      G[0][i] -= G[a][i];
    }
  }
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      F[i][j] = i == j;
      for (int a = 0; a < 4; a++) F[i][j] += u[3 * a + i] * G[a][j];
      squares += F[i][j] * F[i][j];
    }
  }
  Cofactor(F, C);
  for (int j = 0; j < 3; j++) J += F[0][j] * C[0][j];
  pressure = block->lambda * (J - 1) - block->mu;
  for (int a = 0; a < 4; a++) {
    for (int i = 0; i < 3; i++) {
      c[a][i] = 0;
      for (int j = 0; j < 3; j++) c[a][i] += C[i][j] * G[a][j];
      if (f) {
        f[3 * a + i] = pressure * c[a][i];
        for (int j = 0; j < 3; j++) f[3 * a + i] += block->mu * F[i][j] * G[a][j];
        f[3 * a + i] *= volume;
      }
    }
  }
  for (int a = 0; H && a < 4; a++) {
    for (int b = 0; b < 4; b++) {
      PetscReal gg = 0, w[3] = {0, 0, 0};
      for (int j = 0; j < 3; j++) {
        const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
        gg += G[a][j] * G[b][j];
        for (int i = 0; i < 3; i++) w[i] += F[i][j] * (G[a][j1] * G[b][j2] - G[a][j2] * G[b][j1]);
      }
      const PetscReal cross[3][3] = {{0, -w[2], w[1]}, {w[2], 0, -w[0]}, {-w[1], w[0], 0}};
      for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) H[12 * (3 * a + i) + 3 * b + k] = volume * ((i == k) * block->mu * gg + block->lambda * c[a][i] * c[b][k] - pressure * cross[i][k]);
    }
  }
  return volume * (block->mu / 2 * (squares - 3) + pressure * pressure / (2 * block->lambda));
}

/* Loops over this rank's elements: the energy, and the forces or the Hessian where wanted. */
static PetscErrorCode Assemble(Block *block, Vec u, PetscReal *energy, Vec forces, Mat H)
{
  const PetscScalar *v;
  const PetscInt     n = block->cells, base = Vertex(block, 0, 0, block->first);

  PetscFunctionBeginUser;
  PetscCall(VecScatterBegin(block->to_local, u, block->local, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(block->to_local, u, block->local, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(block->local, &v));
  for (PetscInt cube = block->first * n * n; cube < block->last * n * n; cube++) {
    const PetscInt at[3] = {cube % n, cube / n % n, cube / n / n};
    for (int t = 0; t < 6; t++) {
      PetscInt  vertex[4], dof[12];
      PetscReal x[4][3], d[12], f[12], He[144];
      for (int a = 0; a < 4; a++) {
        const PetscInt corner = tetrahedra[t][a];
        const PetscInt p[3]   = {at[0] + (corner & 1), at[1] + (corner >> 1 & 1), at[2] + (corner >> 2 & 1)};
        vertex[a]             = Vertex(block, p[0], p[1], p[2]);
        for (int i = 0; i < 3; i++) {
          x[a][i]        = (PetscReal)p[i] / n;
          dof[3 * a + i] = 3 * vertex[a] + i;
          d[3 * a + i]   = v[dof[3 * a + i] - 3 * base];
        }
      }
      const PetscReal e = Element(block, x, d, forces ? f : NULL, H ? He : NULL);
      if (energy) *energy += e;
      if (forces) PetscCall(VecSetValues(forces, 12, dof, f, ADD_VALUES));
      if (H && block->blocked) PetscCall(MatSetValuesBlocked(H, 4, vertex, 4, vertex, He, ADD_VALUES));
      else if (H) PetscCall(MatSetValues(H, 12, dof, 12, dof, He, ADD_VALUES));
    }
  }
  PetscCall(VecRestoreArrayRead(block->local, &v));
  PetscFunctionReturn(0);
}

/* The held unknowns this rank owns, those of bottom and top, and where they go. */
static PetscErrorCode Held(Block *block, Vec u, PetscInt *count, PetscInt **rows, PetscScalar **values)
{
  const PetscInt layer = 3 * Vertex(block, 0, 0, 1), top = block->cells * layer;
  PetscInt       begin, end;

  PetscFunctionBeginUser;
  PetscCall(VecGetOwnershipRange(u, &begin, &end));
  PetscCall(PetscMalloc2(end - begin, rows, end - begin, values));
  *count = 0;
  for (PetscInt i = begin; i < end; i++) {
    if (i >= layer && i < top) continue;
    (*rows)[*count]     = i;
    (*values)[(*count)++] = i >= top && i % 3 == 2 ? block->stretch - 1 : 0;
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Residual(SNES snes, Vec u, Vec f, void *ctx)
{
  PetscInt           count, *rows;
  PetscScalar       *values;
  const PetscScalar *v;
  PetscInt           begin;

  PetscFunctionBeginUser;
  PetscCall(VecSet(f, 0));
  PetscCall(Assemble((Block *)ctx, u, NULL, f, NULL));
  PetscCall(VecAssemblyBegin(f));
  PetscCall(VecAssemblyEnd(f));
  PetscCall(Held((Block *)ctx, u, &count, &rows, &values));
  PetscCall(VecGetOwnershipRange(u, &begin, NULL));
  PetscCall(VecGetArrayRead(u, &v));
  for (PetscInt i = 0; i < count; i++) values[i] = v[rows[i] - begin] - values[i];
  PetscCall(VecRestoreArrayRead(u, &v));
  PetscCall(VecSetValues(f, count, rows, values, INSERT_VALUES));
  PetscCall(VecAssemblyBegin(f));
  PetscCall(VecAssemblyEnd(f));
  PetscCall(PetscFree2(rows, values));
  PetscFunctionReturn(0);
}

static PetscErrorCode Jacobian(SNES snes, Vec u, Mat J, Mat P, void *ctx)
{
  PetscInt     count, *rows;
  PetscScalar *values;

  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(P));
  PetscCall(Assemble((Block *)ctx, u, NULL, NULL, P));
  PetscCall(MatAssemblyBegin(P, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(P, MAT_FINAL_ASSEMBLY));
  PetscCall(Held((Block *)ctx, u, &count, &rows, &values));
  PetscCall(MatZeroRowsColumns(P, count, rows, 1, NULL, NULL));
  PetscCall(PetscFree2(rows, values));
  PetscFunctionReturn(0);
}

static PetscErrorCode Energy(SNES snes, Vec u, PetscReal *energy, void *ctx)
{
  PetscFunctionBeginUser;
  *energy = 0;
  PetscCall(Assemble((Block *)ctx, u, energy, NULL, NULL));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, energy, 1, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  Block               block = {4, 0, 0, 0, 0, 4, PETSC_FALSE, NULL, NULL};
  PetscReal           poisson = 0.3, energy = 0;
  PetscBool           objective = PETSC_FALSE;
  PetscInt            layers = PETSC_DECIDE, dofs, iterations;
  Vec                 u;
  Mat                 J;
  IS                  needed;
  SNES                snes;
  SNESConvergedReason reason;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-cells", &block.cells, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-stretch", &block.stretch, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-poisson", &poisson, NULL));
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-blocked", &block.blocked, NULL));
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-objective", &objective, NULL));
  block.mu     = 1 / (2 * (1 + poisson));
  block.lambda = poisson / ((1 + poisson) * (1 - 2 * poisson)) + block.mu;

  /* Layers of cells are divided over the ranks; a rank needs the vertices of its layers. */
  PetscCall(PetscSplitOwnership(PETSC_COMM_WORLD, &layers, &block.cells));
  PetscCallMPI(MPI_Scan(&layers, &block.last, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  block.first = block.last - layers;
  dofs        = 3 * Vertex(&block, 0, 0, block.cells + 1);
  PetscCall(VecCreate(PETSC_COMM_WORLD, &u));
  PetscCall(VecSetBlockSize(u, 3));
  PetscCall(VecSetSizes(u, PETSC_DECIDE, dofs));
  PetscCall(VecSetFromOptions(u));
  dofs = 3 * Vertex(&block, 0, 0, layers + 1);
  PetscCall(ISCreateStride(PETSC_COMM_SELF, dofs, 3 * Vertex(&block, 0, 0, block.first), 1, &needed));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, dofs, &block.local));
  PetscCall(VecScatterCreate(u, needed, block.local, NULL, &block.to_local));

  PetscCall(VecGetLocalSize(u, &dofs));
  PetscCall(MatCreate(PETSC_COMM_WORLD, &J));
  PetscCall(MatSetSizes(J, dofs, dofs, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetBlockSize(J, 3));
  PetscCall(MatSetFromOptions(J));
  PetscCall(MatSeqAIJSetPreallocation(J, 81, NULL));
  PetscCall(MatMPIAIJSetPreallocation(J, 81, NULL, 81, NULL));
  PetscCall(MatSeqBAIJSetPreallocation(J, 3, 27, NULL));
  PetscCall(MatMPIBAIJSetPreallocation(J, 3, 27, NULL, 27, NULL));
  PetscCall(MatSeqSBAIJSetPreallocation(J, 3, 27, NULL));
  PetscCall(MatMPISBAIJSetPreallocation(J, 3, 27, NULL, 27, NULL));
  PetscCall(MatSetOption(J, MAT_SYMMETRIC, PETSC_TRUE));

  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(SNESSetFunction(snes, NULL, Residual, &block));
  PetscCall(SNESSetJacobian(snes, J, J, Jacobian, &block));
  if (objective) PetscCall(SNESSetObjective(snes, Energy, &block));
  PetscCall(SNESSetFromOptions(snes));
  PetscCall(SNESSolve(snes, NULL, u));

  PetscCall(Energy(snes, u, &energy, &block));
  PetscCall(SNESGetIterationNumber(snes, &iterations));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s iterations %" PetscInt_FMT " energy %.12e\n", SNESConvergedReasons[reason], iterations, (double)energy));
  PetscCall(SNESDestroy(&snes));
  PetscCall(MatDestroy(&J));
  PetscCall(VecScatterDestroy(&block.to_local));
  PetscCall(ISDestroy(&needed));
  PetscCall(VecDestroy(&block.local));
  PetscCall(VecDestroy(&u));
  PetscCall(PetscFinalize());
  return 0;
}
