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

/* How a step is searched for: along the direction, or from the energy's minimum in the plane of the
   direction and the previous step. */
typedef enum { TREFOIL_SEARCH_ARMIJO, TREFOIL_SEARCH_SUBSPACE } TrefoilSearch;
PETSC_EXTERN const char *const TrefoilSearches[];

/* The matrix P of the direction -P^-1 g: the filtered Hessian; a mass matrix that the host gives;
   or none, which is gradient descent. Directions of the last two are as long as the last step along
   one of them was, and a bit more. */
typedef enum { TREFOIL_PROXY_HESSIAN, TREFOIL_PROXY_MASS, TREFOIL_PROXY_IDENTITY } TrefoilProxy;
PETSC_EXTERN const char *const TrefoilProxies[];

/* What is filtered: an element's whole Hessian, or dP/dF at its quadrature points. */
typedef enum { TREFOIL_SPACE_ELEMENT, TREFOIL_SPACE_DEFORMATION } TrefoilSpace;
PETSC_EXTERN const char *const TrefoilSpaces[];

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

/* What a split callback can do beside splitting whole element Hessians. */
typedef enum {
  TREFOIL_SPLIT_FLOOR = 1,      /* obeys TrefoilSNESGetEigenvalueFloor() */
  TREFOIL_SPLIT_DEFORMATION = 2 /* filters where -snes_trefoil_space deformation says */
} TrefoilSplitCapability;

/*
   TrefoilSNESSetSplitCapabilities - says what the split callback can do

   Logically collective; after TrefoilSNESSetSplitJacobian(), which forgets it. `capabilities` is a
   sum of TrefoilSplitCapability. Options that ask for more than the callback can do are an error.
*/
PetscErrorCode TrefoilSNESSetSplitCapabilities(SNES snes, int capabilities);

/* Hp = H p of the unfiltered Hessian that the split callback has made last. Collective. */
typedef PetscErrorCode (*TrefoilHessianProductFunction)(SNES snes, Vec p, Vec Hp, void *ctx);

/*
   TrefoilSNESSetHessianProduct - lets the split callback form H + 2 w N at once, without a Mat N

   Logically collective; after TrefoilSNESSetSplitJacobian(), which forgets it. Where
   TrefoilSNESGetWeight() is not 0 and the callback gets NULL for N, it makes H + 2 w N in H; the
   search multiplies by H itself through `function`. With an eigenvalue floor, and in PETSc's test
   of the Jacobian, the callback gets a place for N as before.
*/
PetscErrorCode TrefoilSNESSetHessianProduct(SNES snes, TrefoilHessianProductFunction function,
                                            void *ctx);

/*
   TrefoilSNESGetEigenvalueFloor - the floor under filtered eigenvalues, for split callbacks

   Not collective; valid in the callback. Output: share, of an element's largest |eigenvalue|, that
   its filtered eigenvalues are not to fall below, 0 for none; weight, w of the Jacobian being made.
*/
PetscErrorCode TrefoilSNESGetEigenvalueFloor(SNES snes, PetscReal *share, PetscReal *weight);

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
   A callback for the largest step along d from x that the host allows, where an energy is defined
   on a part of space only: with barriers against contact the step before the first collision.
   Collective; the same number on all ranks. Input: snes, x, d, and `first`, the step length that is
   wanted. Output: *largest >= 0; where it is not below `first` nothing is limited, and where it is
   0 the solve ends with SNES_DIVERGED_LINE_SEARCH.

   Backtracking and the descent from a saddle begin at min(first, *largest). A step that has been
   cut short is marked in the record ("truncated"), teaches the rule nothing, and is followed by no
   Shamanskii step. With this callback a post-check of the line search must not change the step, and
   SNES types and line searches that know no largest step are an error.
*/
typedef PetscErrorCode (*TrefoilMaxStepFunction)(SNES snes, Vec x, Vec d, PetscReal first,
                                                 PetscReal *largest, void *ctx);
PetscErrorCode TrefoilSNESSetMaxStep(SNES snes, TrefoilMaxStepFunction function, void *ctx);

/*
   A callback for the size of a direction d, as -snes_trefoil_direction_tolerance means it: in units
   of the host's, over points with several unknowns the longest of their vectors, say. Collective;
   the same number on all ranks, not negative. Without it the largest |entry| counts.
*/
typedef PetscErrorCode (*TrefoilDirectionSizeFunction)(SNES snes, Vec d, PetscReal *size,
                                                       void *ctx);
PetscErrorCode TrefoilSNESSetDirectionSize(SNES snes, TrefoilDirectionSizeFunction function,
                                           void *ctx);

/*
   A callback that fills P, of the Jacobian's pattern, with the matrix of -snes_trefoil_proxy mass:
   symmetric, positive definite, the same for all of a solve. Collective.
*/
typedef PetscErrorCode (*TrefoilProxyFunction)(SNES snes, Mat P, void *ctx);
PetscErrorCode TrefoilSNESSetMassProxy(SNES snes, TrefoilProxyFunction function, void *ctx);

/*
   Defaults for the options of the same names (see -help); an option that is given wins. All are
   logically collective and come before SNESSetFromOptions(). Values that the option would refuse
   are an error.
*/
PetscErrorCode TrefoilSNESSetFilter(SNES snes, const char name[]);
PetscErrorCode TrefoilSNESSetRhoTolerance(SNES snes, PetscReal tolerance);
/* The weight w of filter `constant`. */
PetscErrorCode TrefoilSNESSetConstantWeight(SNES snes, PetscReal weight);
PetscErrorCode TrefoilSNESSetSearch(SNES snes, TrefoilSearch search);
PetscErrorCode TrefoilSNESSetTrustStart(SNES snes, PetscBool trust);
PetscErrorCode TrefoilSNESSetProxy(SNES snes, TrefoilProxy proxy);
/* Most Shamanskii steps an iteration; -1: 8 where the linear solver is direct, else none. */
PetscErrorCode TrefoilSNESSetCorrections(SNES snes, PetscInt most);
/* Most steps of conjugate gradients that turn a filtered direction into Newton's; -1: 8 with filter
   `newton_first` where the linear solver is direct, else none. */
PetscErrorCode TrefoilSNESSetNewtonSteps(SNES snes, PetscInt most);
/* For solves that follow each other, as in time: the rule goes on from the last one's last step. */
PetscErrorCode TrefoilSNESSetContinue(SNES snes, PetscBool goes_on);
/* Tolerances on the Newton decrement, in energy units, and on the decrement over the energy scale;
   0 turns a test off, PETSC_DEFAULT leaves it as it is. */
PetscErrorCode TrefoilSNESSetTolerances(SNES snes, PetscReal decrement, PetscReal energy);
/* On the size of the direction, see TrefoilSNESSetDirectionSize(); 0 turns the test off. */
PetscErrorCode TrefoilSNESSetDirectionTolerance(SNES snes, PetscReal tolerance);
/* Whether the direction that meets a stop test is followed, before the solve ends, instead of being
   thrown away: an energy and a residual more, and what is left is the square of what was tested. */
PetscErrorCode TrefoilSNESSetTakeLast(SNES snes, PetscBool take);
PetscErrorCode TrefoilSNESSetVerifyMinimum(SNES snes, PetscBool verify);
/* The most that the verification with an iterative solver may take, as a share of the solve; 0: no
   bound. */
PetscErrorCode TrefoilSNESSetVerifyShare(SNES snes, PetscReal share);
PetscErrorCode TrefoilSNESSetMonitor(SNES snes, PetscBool on);
/* The file of the JSON record; empty: none. */
PetscErrorCode TrefoilSNESSetRecordFile(SNES snes, const char path[]);

/*
   TrefoilSNESSetFromOptions - reads -snes_trefoil_* and -snes_linesearch_{shrink,armijo}

   Collective. SNESSetFromOptions() does it where the line search is ours; a host calls this, after
   SNESSetFromOptions(), so that monitor and record work with other types and line searches too.
*/
PetscErrorCode TrefoilSNESSetFromOptions(SNES snes);

/*
   TrefoilSNESJacobianMayBeIndefinite - whether the linear solver has to survive indefinite matrices

   Not collective; after SNESSetFromOptions(). PETSC_FALSE where the filter makes every Jacobian
   positive definite by construction; PETSC_TRUE where the rule may choose a weight below 1/2, or
   another line search leaves the Hessian as it is.
*/
PetscErrorCode TrefoilSNESJacobianMayBeIndefinite(SNES snes, PetscBool *may);

/*
   TrefoilSNESRetriesFactors - whether a factorisation that fails leads to another weight

   Not collective; after SNESSetFromOptions(). PETSC_TRUE where the rule chooses weights below 1/2
   and knows what to do where the matrix is indefinite: then a package for definite matrices, such
   as CHOLMOD, whose failure is the answer, may factor what TrefoilSNESJacobianMayBeIndefinite()
   warns of.
*/
PetscErrorCode TrefoilSNESRetriesFactors(SNES snes, PetscBool *retries);

/* Seconds that were spent on a starting guess; the record's history begins with them. Logically
   collective. */
PetscErrorCode TrefoilSNESSetHeadStart(SNES snes, PetscReal seconds);

/*
   TrefoilSNESEndSolve - ends a solve that an error has broken off

   Collective, after SNESSolve() has returned an error that the caller takes for an answer, such as
   a factorisation's of a matrix that is not positive definite. Sets the SNES's reason, and
   completes the record with `reason` in words.
*/
PetscErrorCode TrefoilSNESEndSolve(SNES snes, SNESConvergedReason converged_reason,
                                   const char reason[]);

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

/* What a solve carries from one iteration to the next beside x. */
typedef struct {
  PetscBool has_last;     /* whether there is a step that rules may learn from */
  TrefoilIteration last;  /* the last such step */
  PetscBool trusts_model; /* the quadratic model has been seen to predict well */
  PetscReal proxy_scale;  /* length of a proxy's directions, by the last step along one */
  Vec previous_step;      /* of search `subspace`; NULL where there is none */
  /* decrement with which a rule's last Jacobian was refused as indefinite; infinity: none was */
  PetscReal refused_decrement;
} TrefoilSearchState;

/*
   TrefoilSNESGetSearchState - what is to be kept, beside x, so that the solve can go on later

   Not collective; from a monitor of the SNES, or after a solve. The Vec is borrowed until the next
   step.
*/
PetscErrorCode TrefoilSNESGetSearchState(SNES snes, TrefoilSearchState *state);

/*
   TrefoilSNESSetSearchState - lets the next solve go on, from its x, where another has stopped

   Collective. The Vec is copied; a rule learns from `last` as if it had seen it.
*/
PetscErrorCode TrefoilSNESSetSearchState(SNES snes, const TrefoilSearchState *state);

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

/* The last Newton decrement over the one that ends the solve, NaN where there is none. Not
   collective. */
PetscErrorCode TrefoilSNESGetDecrementRatio(SNES snes, PetscReal *ratio);

/* The last solve's record, a JSON object, as -snes_trefoil_record writes it; complete on every
   rank. Valid until the next solve or the SNES's destruction. Not collective. */
PetscErrorCode TrefoilSNESGetRecord(SNES snes, const char **json);

/* The plugin's options as PETSc's manual pages list them, one a line: "-name <default> - what it
   is". Needs no PetscInitialize(). Valid as long as the library is loaded. Not collective. */
PetscErrorCode TrefoilGetOptionsManual(const char **lines);

#if defined(__cplusplus)
}
#endif
#endif
