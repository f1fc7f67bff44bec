#include "search/negative_curvature.hpp"

#include <petscksp.h>

#include <cmath>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr int most_solves = 500;
/// Curvatures below this share of the filtered Hessian's are rounding.
constexpr double curvature_noise = 1e-10;

/// Random numbers times the roots of H's diagonal: every eigenvector of the pair H, diag(H) has the
/// same share, in any unit and on graded meshes.
PetscErrorCode set_random_forces(Mat H, Vec forces, Vec diagonal) {
  PetscRandom random = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscRandomCreate(PetscObjectComm(reinterpret_cast<PetscObject>(H)), &random));
  PetscCall(PetscRandomSetInterval(random, -1, 1));
  PetscCall(VecSetRandom(forces, random));
  PetscCall(PetscRandomDestroy(&random));
  PetscCall(MatGetDiagonal(H, diagonal));
  PetscCall(VecAbs(diagonal));
  PetscCall(VecSqrtAbs(diagonal));
  PetscCall(VecPointwiseMult(forces, forces, diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Hp of the unfiltered Hessian.
PetscErrorCode multiply_unfiltered(const SolveContext &context, Mat filtered, Vec p, Vec work,
                                   Vec Hp) {
  PetscFunctionBeginUser;
  PetscCall(MatMult(filtered, p, Hp));
  PetscCall(MatMult(context.negative, p, work));
  PetscCall(VecAXPY(Hp, -2 * context.current.weight, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode dot(Vec a, Vec b, double *product) {
  PetscScalar value = 0;
  PetscFunctionBeginUser;
  PetscCall(VecDot(a, b, &value));
  *product = PetscRealPart(value);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode probe_curvature(SolveContext &context, Mat filtered, WorkVectors &work,
                               StationaryPoint *kind, NegativeCurvature *found) {
  KSP ksp = nullptr;
  PC solver = nullptr;
  Vec r = nullptr, z = nullptr, p = nullptr, Hp = nullptr, product = nullptr;
  PetscInt size = 0;
  double rz = 0;
  PetscFunctionBeginUser;
  *kind = StationaryPoint::unknown;
  PetscCall(SNESGetKSP(context.snes, &ksp));
  PetscCall(KSPGetPC(ksp, &solver));
  PetscCall(work.get(0, &r));
  PetscCall(work.get(1, &z));
  PetscCall(work.get(2, &p));
  PetscCall(work.get(3, &Hp));
  PetscCall(work.get(4, &product));
  PetscCall(VecGetSize(r, &size));
  PetscCall(set_random_forces(filtered, r, product));
  PetscCall(PCApply(solver, r, z));
  PetscCall(dot(r, z, &rz));
  const double enough = 1e-8 / static_cast<double>(size) * rz;
  double squared_norm = rz;  // of p in the filtered Hessian's norm; the terms are orthogonal in it
  PetscCall(VecCopy(z, p));
  for (int k = 0; k < most_solves && rz > 0; ++k) {
    double curvature = 0;
    ++context.summary.verification_solves;
    PetscCall(multiply_unfiltered(context, filtered, p, product, Hp));
    PetscCall(dot(p, Hp, &curvature));
    if (curvature < -curvature_noise * squared_norm) {
      *kind = StationaryPoint::saddle;
      found->direction = p;
      found->squared_norm = squared_norm;
      break;
    }
    if (!(curvature > curvature_noise * squared_norm)) break;  // singular, as far as one can tell
    PetscCall(VecAXPY(r, -rz / curvature, Hp));
    PetscCall(PCApply(solver, r, z));
    const double last = rz;
    PetscCall(dot(r, z, &rz));
    if (std::abs(rz) <= enough) {
      *kind = StationaryPoint::minimum;
      break;
    }
    squared_norm = rz + (rz / last) * (rz / last) * squared_norm;
    PetscCall(VecAYPX(p, rz / last, z));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
