/*
   Trefoil: trust-region eigenvalue filtering for PETSc's nonlinear solvers.

   An energy that is a sum over finite elements has a Hessian H and, summed element by element, a
   negative part N = sum_e sum_{lambda < 0} |lambda| v v'. Trefoil hands SNES the filtered Jacobian
   H + 2 w N and chooses the weight w in every iteration (w = 0 Newton, 1/2 eigenvalue clamping,
   1 absolute eigenvalues) from how well the last quadratic model predicted the energy.

   Everything is also an option: -snes_type trefoil, -snes_trefoil_filter adaptive, ... (see -help).
*/
#ifndef TREFOIL_H
#define TREFOIL_H

#include <petscsnes.h>

#if defined(__cplusplus)
extern "C" {
#endif

/* The SNES type and the line-search type; both have the same name. */
#define SNESTREFOIL           "trefoil"
#define SNESLINESEARCHTREFOIL "trefoil"

/* Registers the SNES type, the line-search type and the log events; harmless when called again.
   Call it after PetscInitialize(), or load the library with -dll_append and call nothing. */
PetscErrorCode TrefoilInitializePackage(void);

/* What PETSc calls when the library is loaded with -dll_append. */
PetscErrorCode PetscDLLibraryRegister_trefoil(void);

/* What a split Jacobian callback reports of one evaluation. Counts and seconds of this rank. */
typedef struct {
  PetscInt64     elements;       /* elements evaluated */
  PetscInt64     indefinite;     /* of these, with at least one negative eigenvalue */
  PetscLogDouble filter_seconds; /* spent in eigenvalue filtering */
} TrefoilSplitStatistics;

/*
   A callback that assembles the Hessian and its element-wise negative part at once.

   Collective. Input: snes, the state x, ctx. Output: H, assembled, unfiltered. negative is NULL
   where the rule does not filter; otherwise *negative is N, to be zeroed, filled and assembled. On
   the first call *negative is NULL: the callback creates it with H's nonzero pattern as soon as any
   rank has an indefinite element, and leaves it NULL otherwise (N is never allocated in vain).
   The SNES owns N afterwards. Where no rank has an indefinite element N need not be touched.
*/
typedef PetscErrorCode (*TrefoilSplitJacobianFunction)(SNES snes, Vec x, Mat H, Mat *negative,
                                                       TrefoilSplitStatistics *statistics, void *ctx);

/* Sets the split Jacobian callback and the matrix H + 2 w N is formed in; replaces SNESSetJacobian().
   With a SNES or line search of another type H stays unfiltered. */
PetscErrorCode TrefoilSNESSetSplitJacobian(SNES snes, Mat H, TrefoilSplitJacobianFunction function,
                                           void *ctx);

/*
   A callback for the size of the energy at x, free of any constant in it: for elasticity the sum
   over the elements of |psi - psi(I)| V, plus the work of the loads. Collective.
   The default stop test is predicted decrease / energy scale <= -snes_trefoil_energy_tolerance;
   without this callback that test is off unless its option is given, and then measures against the
   energy gained since the start.
*/
typedef PetscErrorCode (*TrefoilEnergyScaleFunction)(SNES snes, Vec x, PetscReal *scale, void *ctx);
PetscErrorCode TrefoilSNESSetEnergyScale(SNES snes, TrefoilEnergyScaleFunction function, void *ctx);

/* The weight w of the present Jacobian H + 2 w N. Not collective. */
PetscErrorCode TrefoilSNESGetWeight(SNES snes, PetscReal *weight);

/* The trust-region ratio of the last step taken, NaN where there is none. Not collective. */
PetscErrorCode TrefoilSNESGetTrustRegionRatio(SNES snes, PetscReal *rho);

/* The last solve's record, a JSON object, as -snes_trefoil_record writes it; complete on every
   rank. Valid until the next solve or the SNES's destruction. Not collective. */
PetscErrorCode TrefoilSNESGetRecord(SNES snes, const char **json);

#if defined(__cplusplus)
}
#endif
#endif
