/*
   Hosts of every kind, in one process that starts and ends PETSc several times. CTest runs it with
   -malloc_dump -options_left: nothing of ours may be left.

     mpirun -n 2 ./life_cycle -library ../../libtrefoil.so -malloc_dump -options_left

   The problem of them all: a chain of bars with two rest lengths each, held at its left end, from
   a start on the hill between the two, where no bar is convex. Each way has to find the same energy.
*/
#include <petscsnes.h>
#include <stdlib.h>
#include <string.h>
#include <trefoil.h>

typedef struct _Host Host;
struct _Host {
  SNES       snes;
  PetscInt   vertices;
  Vec        x, all; /* all: the whole state, on every rank */
  VecScatter to_all;
  Mat        H;
  PetscReal  energy;
  PetscInt   jacobians;
  PetscBool  aliasing; /* copies what it is called with into x, as dolfinx does */
  Host      *inner;    /* solved inside of the residual and of the objective */
};

static PetscErrorCode Solve(Host *host);

/* Fetches the state; the bars' stretch at i is then s[i] - s[i - 1]. */
static PetscErrorCode Begin(Host *host, Vec x, const PetscScalar **s)
{
  PetscFunctionBeginUser;
  if (host->aliasing && x != host->x) PetscCall(VecCopy(x, host->x));
  PetscCall(VecScatterBegin(host->to_all, x, host->all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(host->to_all, x, host->all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetArrayRead(host->all, s));
  PetscFunctionReturn(0);
}

static PetscReal Stretch(const PetscScalar *s, PetscInt i)
{
  return i > 0 ? s[i] - s[i - 1] : s[0];
}

static PetscReal Anchor(const PetscScalar *s, PetscInt i)
{
  return s[i] - 1.2 * (i + 1);
}

static PetscErrorCode Energy(SNES snes, Vec x, PetscReal *energy, void *ctx)
{
  Host              *host = (Host *)ctx;
  const PetscScalar *s;

  PetscFunctionBeginUser;
  if (host->inner) PetscCall(Solve(host->inner));
  PetscCall(Begin(host, x, &s));
  *energy = 0;
  for (PetscInt i = 0; i < host->vertices; i++) *energy += PetscSqr(PetscSqr(Stretch(s, i)) - 1) / 4 + 0.025 * PetscSqr(Anchor(s, i));
  PetscCall(VecRestoreArrayRead(host->all, &s));
  PetscFunctionReturn(0);
}

static PetscErrorCode Residual(SNES snes, Vec x, Vec f, void *ctx)
{
  Host              *host = (Host *)ctx;
  const PetscScalar *s;
  PetscInt           begin, end;

  PetscFunctionBeginUser;
  if (host->inner) PetscCall(Solve(host->inner));
  PetscCall(Begin(host, x, &s));
  PetscCall(VecSet(f, 0));
  PetscCall(VecGetOwnershipRange(f, &begin, &end));
  for (PetscInt i = begin; i < end; i++) {
    const PetscReal   d = Stretch(s, i), force = d * (d * d - 1);
    const PetscInt    index[]  = {i - 1, i};
    const PetscScalar values[] = {-force, force + 0.05 * Anchor(s, i)};
    PetscCall(VecSetOption(f, VEC_IGNORE_NEGATIVE_INDICES, PETSC_TRUE));
    PetscCall(VecSetValues(f, 2, index, values, ADD_VALUES));
  }
  PetscCall(VecRestoreArrayRead(host->all, &s));
  PetscCall(VecAssemblyBegin(f));
  PetscCall(VecAssemblyEnd(f));
  PetscFunctionReturn(0);
}

static PetscErrorCode Jacobian(SNES snes, Vec x, Mat J, Mat H, void *ctx)
{
  Host              *host = (Host *)ctx;
  const PetscScalar *s;
  PetscInt           begin, end;

  PetscFunctionBeginUser;
  host->jacobians++;
  PetscCall(Begin(host, x, &s));
  PetscCall(MatZeroEntries(H));
  PetscCall(MatGetOwnershipRange(H, &begin, &end));
  for (PetscInt i = begin; i < end; i++) {
    const PetscReal   c = 3 * PetscSqr(Stretch(s, i)) - 1;
    const PetscInt    index[] = {i - 1, i};
    const PetscScalar bar[]   = {c, -c, -c, c}, anchor = 0.05;
    PetscCall(MatSetValues(H, 2, index, 2, index, bar, ADD_VALUES));
    PetscCall(MatSetValues(H, 1, &i, 1, &i, &anchor, ADD_VALUES));
  }
  PetscCall(VecRestoreArrayRead(host->all, &s));
  PetscCall(MatAssemblyBegin(H, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(H, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

/* Everything of a mesh; `twice` asks for the matrix's options again. */
static PetscErrorCode MakeMesh(Host *host, PetscInt vertices, const char *prefix, PetscBool twice)
{
  PetscFunctionBeginUser;
  host->vertices = vertices;
  PetscCall(MatCreate(PETSC_COMM_WORLD, &host->H));
  PetscCall(MatSetSizes(host->H, PETSC_DECIDE, PETSC_DECIDE, vertices, vertices));
  PetscCall(MatSetOptionsPrefix(host->H, prefix));
  PetscCall(MatSetFromOptions(host->H));
  if (twice) PetscCall(MatSetFromOptions(host->H));
  PetscCall(MatSeqAIJSetPreallocation(host->H, 3, NULL));
  PetscCall(MatMPIAIJSetPreallocation(host->H, 3, NULL, 2, NULL));
  PetscCall(MatCreateVecs(host->H, &host->x, NULL));
  PetscCall(VecScatterCreateToAll(host->x, &host->to_all, &host->all));
  PetscFunctionReturn(0);
}

static PetscErrorCode DestroyMesh(Host *host)
{
  PetscFunctionBeginUser;
  PetscCall(VecScatterDestroy(&host->to_all));
  PetscCall(VecDestroy(&host->all));
  PetscCall(VecDestroy(&host->x));
  PetscCall(MatDestroy(&host->H));
  PetscFunctionReturn(0);
}

static PetscErrorCode SetCallbacks(Host *host, PetscBool jacobian)
{
  PetscFunctionBeginUser;
  PetscCall(SNESSetObjective(host->snes, Energy, host));
  PetscCall(SNESSetFunction(host->snes, NULL, Residual, host));
  if (jacobian) PetscCall(SNESSetJacobian(host->snes, host->H, host->H, Jacobian, host));
  PetscFunctionReturn(0);
}

static PetscErrorCode MakeHost(Host *host, PetscInt vertices, const char *prefix)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(host, sizeof(*host)));
  PetscCall(MakeMesh(host, vertices, prefix, PETSC_FALSE));
  PetscCall(SNESCreate(PETSC_COMM_WORLD, &host->snes));
  PetscCall(SNESSetOptionsPrefix(host->snes, prefix));
  PetscCall(SNESSetType(host->snes, "trefoil"));
  PetscFunctionReturn(0);
}

static PetscErrorCode DestroyHost(Host *host)
{
  PetscFunctionBeginUser;
  PetscCall(SNESDestroy(&host->snes));
  PetscCall(DestroyMesh(host));
  PetscFunctionReturn(0);
}

static PetscErrorCode Solve(Host *host)
{
  SNESConvergedReason reason;
  PetscReal           reached;
  PetscInt            begin, end;
  const char         *prefix, *record;

  PetscFunctionBeginUser;
  PetscCall(SNESGetOptionsPrefix(host->snes, &prefix));
  PetscCall(VecGetOwnershipRange(host->x, &begin, &end));
  for (PetscInt i = begin; i < end; i++) {
    PetscReal place = 0;
    for (PetscInt j = 0; j <= i; j++) place += 0.3 + 0.1 * PetscSinReal(j); /* on the hill */
    PetscCall(VecSetValue(host->x, i, place, INSERT_VALUES));
  }
  PetscCall(VecAssemblyBegin(host->x));
  PetscCall(VecAssemblyEnd(host->x));
  host->jacobians = 0;
  PetscCall(SNESSolve(host->snes, NULL, host->x));
  PetscCall(SNESGetConvergedReason(host->snes, &reason));
  PetscCheck(reason > 0, PETSC_COMM_WORLD, PETSC_ERR_PLIB, "host '%s' did not converge: %s", prefix, SNESConvergedReasons[reason]);
  PetscCall(TrefoilSNESGetRecord(host->snes, &record)); /* on the hill each begins filtered; some end with w = 0 */
  PetscCheck(strstr(record, "\"weight\": 1.0") || strstr(record, "\"weight\": 0.5"), PETSC_COMM_WORLD, PETSC_ERR_PLIB, "host '%s' was not filtered", prefix);
  PetscCall(Energy(NULL, host->x, &reached, host));
  PetscCheck(!host->energy || PetscAbsReal(reached - host->energy) < 1e-8, PETSC_COMM_WORLD, PETSC_ERR_PLIB, "host '%s' went elsewhere", prefix);
  host->energy = reached;
  PetscFunctionReturn(0);
}

/* Solves, twice, and compares with the energy that another host has found; 0 is no energy. */
static PetscErrorCode Compare(Host *host, PetscReal energy)
{
  PetscFunctionBeginUser;
  host->energy = energy;
  for (int twice = 0; twice < 2; twice++) PetscCall(Solve(host));
  PetscFunctionReturn(0);
}

/* Filters of different kinds at once, by prefix; what the adaptive one finds is what others have to. */
static PetscErrorCode ManyAtOnce(PetscReal *energy)
{
  Host            hosts[3];
  const char     *prefixes[] = {"clamp_", "absolute_", "adaptive_"};
  const PetscReal weights[] = {0.5, 1};

  PetscFunctionBeginUser;
  for (int i = 0; i < 3; i++) {
    PetscCall(MakeHost(&hosts[i], 12, prefixes[i]));
    PetscCall(SetCallbacks(&hosts[i], PETSC_TRUE));
    PetscCall(SNESSetFromOptions(hosts[i].snes));
  }
  for (int twice = 0; twice < 2; twice++) {
    for (int i = 0; i < 3; i++) {
      PetscReal weight;
      PetscCall(Solve(&hosts[i]));
      PetscCall(TrefoilSNESGetWeight(hosts[i].snes, &weight));
      PetscCheck(i == 2 || weight == weights[i], PETSC_COMM_WORLD, PETSC_ERR_PLIB, "'%s' has another's filter", prefixes[i]);
    }
  }
  *energy = hosts[2].energy;
  for (int i = 0; i < 3; i++) PetscCall(DestroyHost(&hosts[i]));
  PetscFunctionReturn(0);
}

static PetscErrorCode Nested(PetscReal energy)
{
  Host outer, inner;

  PetscFunctionBeginUser;
  PetscCall(MakeHost(&outer, 12, "outer_"));
  PetscCall(MakeHost(&inner, 7, "inner_"));
  outer.inner = &inner;
  PetscCall(SetCallbacks(&outer, PETSC_TRUE));
  PetscCall(SetCallbacks(&inner, PETSC_TRUE));
  PetscCall(SNESSetFromOptions(outer.snes));
  PetscCall(SNESSetFromOptions(inner.snes));
  PetscCall(Compare(&outer, energy));
  PetscCall(DestroyHost(&outer));
  PetscCall(DestroyHost(&inner));
  PetscFunctionReturn(0);
}

/* Another mesh for the same SNES, then the first one again. */
static PetscErrorCode AnotherMesh(PetscReal energy)
{
  Host host;

  PetscFunctionBeginUser;
  PetscCall(MakeHost(&host, 12, "mesh_"));
  PetscCall(SetCallbacks(&host, PETSC_TRUE));
  PetscCall(SNESSetFromOptions(host.snes));
  PetscCall(Compare(&host, energy));
  for (int i = 0; i < 2; i++) {
    PetscCall(SNESReset(host.snes));
    PetscCall(DestroyMesh(&host));
    PetscCall(MakeMesh(&host, i ? 12 : 19, "mesh_", PETSC_TRUE));
    PetscCall(SetCallbacks(&host, PETSC_TRUE));
    PetscCall(Compare(&host, i ? energy : 0));
  }
  PetscCall(DestroyHost(&host));
  PetscFunctionReturn(0);
}

/* Options asked for twice, the Jacobian set last, the monitors cancelled, Mat and SNES destroyed in either order. */
static PetscErrorCode Orders(const char *prefix, PetscBool cancels, PetscReal energy)
{
  PetscFunctionBeginUser;
  for (int late = 0; late < 2; late++) {
    for (int cancel = 0; cancel <= (int)cancels; cancel++) {
      Host host;
      PetscCall(MakeHost(&host, 12, prefix));
      host.aliasing = late ? PETSC_TRUE : PETSC_FALSE;
      PetscCall(SetCallbacks(&host, late ? PETSC_FALSE : PETSC_TRUE));
      PetscCall(SNESSetFromOptions(host.snes));
      PetscCall(SNESSetFromOptions(host.snes));
      if (late) PetscCall(SetCallbacks(&host, PETSC_TRUE));
      if (cancel) PetscCall(SNESMonitorCancel(host.snes));
      PetscCall(Compare(&host, energy));
      PetscCheck(host.jacobians > 1, PETSC_COMM_WORLD, PETSC_ERR_PLIB, "the host's Jacobian was not called");
      if (cancel) PetscCall(DestroyMesh(&host));
      PetscCall(DestroyHost(&host));
    }
  }
  PetscFunctionReturn(0);
}

/* Loads the library in one of the ways that there are, and more than once. */
static PetscErrorCode Load(int cycle)
{
  char      library[PETSC_MAX_PATH_LEN];
  PetscBool found;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-library", library, sizeof(library), &found));
  PetscCheck(found, PETSC_COMM_WORLD, PETSC_ERR_USER, "-library is missing");
  for (int twice = 0; twice < 2; twice++) {
    if (cycle % 3 == 0 || cycle > 3) PetscCall(TrefoilInitializePackage());
    if (cycle % 3 == 1 || cycle > 3) PetscCall(PetscDLLibraryAppend(PETSC_COMM_WORLD, &PetscDLLibrariesLoaded, library));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Cycle(int cycle)
{
  PetscReal energy = 0;

  PetscFunctionBeginUser;
  PetscCall(Load(cycle));
  PetscCall(PetscOptionsInsertString(NULL, "-clamp_snes_trefoil_filter clamp -absolute_snes_trefoil_filter absolute"));
  PetscCall(PetscOptionsInsertString(NULL, "-mesh_mat_type baij -mesh_mat_type aij"));
  PetscCall(PetscOptionsInsertString(NULL, "-newtonls_snes_type newtonls -newtonls_snes_linesearch_type trefoil -newtonls_snes_stol 0"));
  PetscCall(ManyAtOnce(&energy));
  PetscCall(Nested(energy));
  PetscCall(AnotherMesh(energy));
  PetscCall(Orders("orders_", PETSC_TRUE, energy));
  PetscCall(Orders("newtonls_", PETSC_FALSE, energy));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "life cycle %d: all is well\n", cycle));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  MPI_Init(&argc, &argv);
  for (int cycle = 0; cycle < 6; cycle++) {
    /* In every third cycle PETSc loads the library by itself: -dll_append, twice. */
    if (cycle % 3 == 2) {
      char options[PETSC_MAX_PATH_LEN];
      for (int i = 1; i + 1 < argc; i++) {
        if (!strcmp(argv[i], "-library")) snprintf(options, sizeof(options), "-dll_append %s,%s", argv[i + 1], argv[i + 1]);
      }
      setenv("PETSC_OPTIONS", options, 1);
    } else unsetenv("PETSC_OPTIONS");
    PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
    PetscCall(Cycle(cycle));
    PetscCall(PetscFinalize());
  }
  MPI_Finalize();
  puts("all life cycles have ended");
  return 0;
}
