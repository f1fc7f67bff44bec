/*
   Hyperelasticity by DMPlex and PetscFE: two point functions and a boundary, no loop over elements.
   It knows nothing of Trefoil.

     mpirun -n 2 ./plex_fe
     mpirun -n 2 ./plex_fe -dll_append ../../build/libtrefoil.so -snes_type trefoil

   Options: -stretch <3> height over rest height, -poisson <0.49>; DMPlex's own
*/
static char help[] = "A block of rubber, stretched; DMPlex and PetscFE.\n\n";

#include <petscdmplex.h>
#include <petscds.h>
#include <petscsnes.h>

/* psi = mu/2 (F:F - 3) + lambda/2 (J - 1 - mu/lambda)^2, constants = {mu, lambda} */
static void Kinematics(const PetscScalar u_x[], PetscReal F[9], PetscReal C[9], PetscReal *J)
{
  for (int i = 0; i < 9; i++) F[i] = PetscRealPart(u_x[i]) + (i % 4 == 0);
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      C[3 * i + j] = F[3 * i1 + j1] * F[3 * i2 + j2] - F[3 * i1 + j2] * F[3 * i2 + j1];
    }
  }
  *J = F[0] * C[0] + F[1] * C[1] + F[2] * C[2];
}

static void Energy(PetscInt dim, PetscInt Nf, PetscInt NfAux, const PetscInt uOff[], const PetscInt uOff_x[], const PetscScalar u[], const PetscScalar u_t[], const PetscScalar u_x[], const PetscInt aOff[], const PetscInt aOff_x[], const PetscScalar a[], const PetscScalar a_t[], const PetscScalar a_x[], PetscReal t, const PetscReal x[], PetscInt numConstants, const PetscScalar constants[], PetscScalar psi[])
{
  const PetscReal mu = PetscRealPart(constants[0]), lambda = PetscRealPart(constants[1]);
  PetscReal       F[9], C[9], J, squares = 0;

  Kinematics(u_x, F, C, &J);
  for (int i = 0; i < 9; i++) squares += F[i] * F[i];
  psi[0] = mu / 2 * (squares - 3) + lambda / 2 * (J - 1 - mu / lambda) * (J - 1 - mu / lambda);
}

static void Stress(PetscInt dim, PetscInt Nf, PetscInt NfAux, const PetscInt uOff[], const PetscInt uOff_x[], const PetscScalar u[], const PetscScalar u_t[], const PetscScalar u_x[], const PetscInt aOff[], const PetscInt aOff_x[], const PetscScalar a[], const PetscScalar a_t[], const PetscScalar a_x[], PetscReal t, const PetscReal x[], PetscInt numConstants, const PetscScalar constants[], PetscScalar f1[])
{
  const PetscReal mu = PetscRealPart(constants[0]), lambda = PetscRealPart(constants[1]);
  PetscReal       F[9], C[9], J;

  Kinematics(u_x, F, C, &J);
  for (int i = 0; i < 9; i++) f1[i] = mu * F[i] + (lambda * (J - 1) - mu) * C[i];
}

static void Tangent(PetscInt dim, PetscInt Nf, PetscInt NfAux, const PetscInt uOff[], const PetscInt uOff_x[], const PetscScalar u[], const PetscScalar u_t[], const PetscScalar u_x[], const PetscInt aOff[], const PetscInt aOff_x[], const PetscScalar a[], const PetscScalar a_t[], const PetscScalar a_x[], PetscReal t, PetscReal u_tShift, const PetscReal x[], PetscInt numConstants, const PetscScalar constants[], PetscScalar g3[])
{
  const PetscReal mu = PetscRealPart(constants[0]), lambda = PetscRealPart(constants[1]);
  PetscReal       F[9], C[9], J;

  Kinematics(u_x, F, C, &J);
  for (int i = 0; i < 3; i++) { /* g3[((i * 3 + k) * 3 + j) * 3 + l] = dP_ij / dF_kl */
    for (int k = 0; k < 3; k++) {
      for (int j = 0; j < 3; j++) {
        for (int l = 0; l < 3; l++) {
          PetscReal second = 0;
          if (i != k && j != l) {
            const int m = 3 - i - k, n = 3 - j - l;
            second      = ((k - i + 3) % 3 == (l - j + 3) % 3 ? 1 : -1) * F[3 * m + n];
          }
          g3[((i * 3 + k) * 3 + j) * 3 + l] = (i == k && j == l) * mu + lambda * C[3 * i + j] * C[3 * k + l] + (lambda * (J - 1) - mu) * second;
        }
      }
    }
  }
}

static PetscErrorCode Hold(PetscInt dim, PetscReal t, const PetscReal x[], PetscInt Nc, PetscScalar *u, void *ctx)
{
  for (PetscInt i = 0; i < Nc; i++) u[i] = 0;
  return 0;
}

/* Up by the stretch. */
static PetscErrorCode Pull(PetscInt dim, PetscReal t, const PetscReal x[], PetscInt Nc, PetscScalar *u, void *ctx)
{
  u[0] = u[1] = 0;
  u[2]        = *(PetscReal *)ctx - 1;
  return 0;
}

int main(int argc, char **argv)
{
  DM                  dm;
  DMLabel             label;
  PetscFE             fe;
  PetscDS             ds;
  SNES                snes;
  Vec                 u;
  PetscReal           stretch = 3, poisson = 0.49;
  PetscScalar         energy;
  const PetscInt      faces[] = {3, 3, 3}, bottom = 1, top = 2;
  PetscInt            iterations;
  SNESConvergedReason reason;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-stretch", &stretch, NULL));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-poisson", &poisson, NULL));
#if PETSC_VERSION_LT(3, 22, 0)
  PetscCall(DMPlexCreateBoxMesh(PETSC_COMM_WORLD, 3, PETSC_FALSE, faces, NULL, NULL, NULL, PETSC_TRUE, &dm));
#else
  PetscCall(DMPlexCreateBoxMesh(PETSC_COMM_WORLD, 3, PETSC_FALSE, faces, NULL, NULL, NULL, PETSC_TRUE, 0, PETSC_FALSE, &dm));
#endif
  PetscCall(DMSetFromOptions(dm));

  PetscCall(PetscFECreateLagrange(PETSC_COMM_WORLD, 3, 3, PETSC_FALSE, 1, PETSC_DETERMINE, &fe));
  PetscCall(PetscObjectSetName((PetscObject)fe, "displacement"));
  PetscCall(DMSetField(dm, 0, NULL, (PetscObject)fe));
  PetscCall(DMCreateDS(dm));
  PetscCall(DMGetDS(dm, &ds));
  PetscCall(PetscDSSetObjective(ds, 0, Energy));
  PetscCall(PetscDSSetResidual(ds, 0, NULL, Stress));
  PetscCall(PetscDSSetJacobian(ds, 0, 0, NULL, NULL, NULL, Tangent));
  const PetscReal   mu = 1 / (2 * (1 + poisson));
  const PetscScalar constants[] = {mu, poisson / ((1 + poisson) * (1 - 2 * poisson)) + mu};
  PetscCall(PetscDSSetConstants(ds, 2, (PetscScalar *)constants));
  PetscCall(DMGetLabel(dm, "Face Sets", &label));
  PetscCall(DMAddBoundary(dm, DM_BC_ESSENTIAL, "bottom", label, 1, &bottom, 0, 0, NULL, (void (*)(void))Hold, NULL, NULL, NULL));
  PetscCall(DMAddBoundary(dm, DM_BC_ESSENTIAL, "top", label, 1, &top, 0, 0, NULL, (void (*)(void))Pull, NULL, &stretch, NULL));
#if PETSC_VERSION_LT(3, 21, 0)
  PetscCall(DMPlexSetSNESLocalFEM(dm, NULL, NULL, NULL));
#else
  PetscCall(DMPlexSetSNESLocalFEM(dm, PETSC_FALSE, NULL));
#endif

  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(SNESSetDM(snes, dm));
  PetscCall(SNESSetFromOptions(snes));
  PetscCall(DMCreateGlobalVector(dm, &u));
  PetscCall(SNESSolve(snes, NULL, u));
  PetscCall(DMPlexComputeIntegralFEM(dm, u, &energy, NULL));
  PetscCall(SNESGetIterationNumber(snes, &iterations));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s iterations %" PetscInt_FMT " energy %.12e\n", SNESConvergedReasons[reason], iterations, (double)PetscRealPart(energy)));

  PetscCall(VecDestroy(&u));
  PetscCall(SNESDestroy(&snes));
  PetscCall(PetscFEDestroy(&fe));
  PetscCall(DMDestroy(&dm));
  PetscCall(PetscFinalize());
  return 0;
}
