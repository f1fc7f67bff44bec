#include "search/lanczos.hpp"

#include <algorithm>
#include <cmath>

#include "hook/matrix_operations.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

namespace trefoil {
namespace {

/// A unit vector of random numbers, without those of held rows.
PetscErrorCode set_random(const std::vector<char> &held, Vec v) {
  PetscRandom random = nullptr;
  PetscScalar *entries = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscRandomCreate(PetscObjectComm(reinterpret_cast<PetscObject>(v)), &random));
  PetscCall(PetscRandomSetInterval(random, -1, 1));
  PetscCall(VecSetRandom(v, random));
  PetscCall(PetscRandomDestroy(&random));
  PetscCall(VecGetArray(v, &entries));
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i]) entries[i] = 0;
  }
  PetscCall(VecRestoreArray(v, &entries));
  PetscCall(VecNormalize(v, nullptr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Of a matrix-free one: ones.
PetscErrorCode set_root_of_diagonal(KSP ksp, Vec scale) {
  Mat matrix = nullptr;
  PetscFunctionBeginUser;
  PetscCall(KSPGetOperators(ksp, nullptr, &matrix));
  PetscCall(VecSet(scale, 1));
  if (is_matrix_free(matrix)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatGetDiagonal(matrix, scale));
  PetscCall(VecSqrtAbs(scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// w = S K^-1 S v, and whether the linear solver found one.
PetscErrorCode apply(KSP ksp, Vec scale, Vec v, Vec scaled, Vec w, bool *solved) {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscFunctionBeginUser;
  PetscCall(VecPointwiseMult(scaled, scale, v));
  PetscCall(VecSet(w, 0));  // where a solver begins that starts from a guess
  PetscCall(KSPSolve(ksp, scaled, w));
  PetscCall(VecPointwiseMult(w, w, scale));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  *solved = reason > 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// How many steps are worth their solves, and the share of the largest Ritz value that is noise.
PetscErrorCode effort(KSP ksp, int *steps, double *noise) {
  constexpr double rounding = 1e-10;
  PetscBool direct = PETSC_FALSE;
  PetscReal tolerance = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &direct));
  PetscCall(KSPGetTolerances(ksp, &tolerance, nullptr, nullptr, nullptr));
  *steps = direct ? 6 : 2;  // six see what four overlook, on chains of 24 bars
  *noise = direct ? rounding : std::max<double>(rounding, tolerance);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode meets_negative_curvature(KSP ksp, const std::vector<char> &held, Vec like,
                                        WorkVectors &work, int *solves, bool *meets) {
  Vec scale = nullptr, scaled = nullptr, last = nullptr, v = nullptr, w = nullptr;
  double noise = 0, largest = 0, pivot = 0, beta = 0;
  int steps = 0;
  PetscFunctionBeginUser;
  *meets = false;
  PetscCall(work.get(Work::lanczos_scale, like, &scale));
  PetscCall(work.get(Work::product, like, &scaled));
  PetscCall(work.get(Work::lanczos_last, like, &last));
  PetscCall(work.get(Work::lanczos_vector, like, &v));
  PetscCall(work.get(Work::lanczos_next, like, &w));
  PetscCall(effort(ksp, &steps, &noise));
  PetscCall(set_root_of_diagonal(ksp, scale));
  PetscCall(set_random(held, v));
  PetscCall(VecSet(last, 0));
  // The signs of the pivots of the tridiagonal matrix are those of its eigenvalues.
  for (int k = 0; k < steps; ++k) {
    double alpha = 0;
    PetscReal norm = 0;
    bool solved = false;
    PetscCall(apply(ksp, scale, v, scaled, w, &solved));
    ++*solves;
    PetscCall(dot(v, w, &alpha));
    largest = std::max(largest, std::abs(alpha));
    pivot = alpha - (k > 0 ? beta * beta / pivot : 0);
    *meets = !solved || pivot < -noise * largest;  // conjugate gradients end where they meet it
    if (*meets || pivot < noise * largest) break;
    PetscCall(VecAXPBYPCZ(w, -alpha, -beta, 1, v, last));
    PetscCall(VecNorm(w, NORM_2, &norm));
    if (!(norm > noise * largest)) break;  // an invariant space: all is known
    PetscCall(VecCopy(v, last));
    PetscCall(VecAXPBY(v, 1 / norm, 0, w));
    beta = norm;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
