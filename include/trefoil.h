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
#define SNESTREFOIL "trefoil"
#define SNESLINESEARCHTREFOIL "trefoil"

/* Registers the SNES type, the line-search type and the log events; harmless when called again.
   Call it after PetscInitialize(), or load the library with -dll_append and call nothing. */
PetscErrorCode TrefoilInitializePackage(void);

/* What PETSc calls when the library is loaded with -dll_append. */
PetscErrorCode PetscDLLibraryRegister_trefoil(void);

/* What a split Jacobian callback reports of one evaluation. Counts and seconds of this rank. */
typedef struct {
  PetscInt64 elements;           /* elements evaluated */
  PetscInt64 indefinite;         /* of these, with at least one negative eigenvalue */
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
                                                       TrefoilSplitStatistics *statistics,
                                                       void *ctx);

/* Sets the split Jacobian callback and the matrix H + 2 w N is formed in; replaces
   SNESSetJacobian(). With a SNES or line search of another type H stays unfiltered. */
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

/*
   TrefoilSNESSetEnergyOffset - a constant of the energy that the objective leaves out

   Logically collective. What the monitor and the record show is the objective plus `offset`, in
   energy units; 0 unless set. An objective that is zero at rest keeps the digits that a constant,
   psi(I) V of all elements say, would drown; rules, searches and stop tests never see the constant.
*/
PetscErrorCode TrefoilSNESSetEnergyOffset(SNES snes, PetscReal offset);

/*
   A callback for energies at many points of a line or plane through x, in one pass over the
   elements: changes[p] = f(x + sum_k c[p][k] d[k]) - f(x), with `directions` (one or two) vectors d
   and `points` rows of coefficients, one after the other. Infinite where the energy is. Collective;
   the same numbers on all ranks. Search `subspace` uses it; without it that search evaluates the
   objective at a few points.
*/
typedef PetscErrorCode (*TrefoilEnergyChangesFunction)(SNES snes, Vec x, PetscInt directions,
                                                       const Vec d[], PetscInt points,
                                                       const PetscReal coefficients[],
                                                       PetscReal changes[], void *ctx);
PetscErrorCode TrefoilSNESSetEnergyChanges(SNES snes, TrefoilEnergyChangesFunction function,
                                           void *ctx);

/*
   TrefoilSplitElementMatrix - the negative part of one symmetric element matrix

   Not collective.
   Input:  n - rows, 1 to 192;  H - n x n numbers
   Output: N - n x n numbers, sum over lambda < 0 of |lambda| v v';  negative - how many eigenvalues
   are negative (may be NULL). NaN or Inf in H is an error.
*/
PetscErrorCode TrefoilSplitElementMatrix(PetscInt n, const PetscScalar H[], PetscScalar N[],
                                         PetscInt *negative);

/*
   TrefoilMatAttach - watches a Mat from now on, outside of Jacobian callbacks as well

   Logically collective. An SNES with our line search watches its own Jacobian during its callback
   and needs no call; this is for codes that assemble the Jacobian elsewhere, say together with the
   residual. Element blocks are those added by one MatSetValues*() call, square, with the same
   indices on both sides.
*/
PetscErrorCode TrefoilMatAttach(Mat matrix);
/* TrefoilMatDetach - gives a watched Mat its own operations back. Logically collective. */
PetscErrorCode TrefoilMatDetach(Mat matrix);

/*
   TrefoilMatSetElementValues - adds a whole element matrix, for codes that insert row by row

   Not collective. Like MatSetValues(matrix, n, index, n, index, H, ADD_VALUES); replaces the loop
   over the rows in a Jacobian callback. Negative indices are left out. Without Trefoil watching the
   Mat it is that call and nothing else.
*/
PetscErrorCode TrefoilMatSetElementValues(Mat matrix, PetscInt n, const PetscInt index[],
                                          const PetscScalar H[]);

/* One finished iteration, as a rule of one's own sees it. NaN stands for "does not apply". */
typedef struct {
  PetscInt k;           /* from 0 */
  PetscReal energy;     /* before the step */
  PetscReal weight;     /* w of H + 2 w N */
  PetscReal rho;        /* trust-region ratio of the step */
  PetscReal step;       /* step length */
  PetscInt trials;      /* energies evaluated in the search */
  PetscReal decrement;  /* |g'd| / 2 */
  PetscReal indefinite; /* share of elements with a negative eigenvalue */
} TrefoilIteration;

/* Chooses the weight w >= 0 of the next iteration; `last` is NULL in a solve's first one. Called
   with the same numbers on all ranks, and must return the same weight on all. */
typedef PetscErrorCode (*TrefoilRuleFunction)(SNES snes, const TrefoilIteration *last,
                                              PetscReal *weight, void *ctx);

/*
   TrefoilRuleRegister - adds a rule, to be chosen by -snes_trefoil_filter name

   Logically collective; before SNESSetFromOptions(). A name that exists is an error.
*/
PetscErrorCode TrefoilRuleRegister(const char name[], TrefoilRuleFunction function, void *ctx);

/* The weight w of the present Jacobian H + 2 w N; after a solve, of the last direction's. Where
   -snes_trefoil_verify_minimum has factored H itself, that is what the Mat and the KSP hold at the
   end. Not collective. */
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
