#include "search/negative_curvature.hpp"

#include <petscksp.h>

#include <cmath>

#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

namespace trefoil {
namespace {

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

}  // namespace

PetscErrorCode probe_curvature(const FilteredJacobian &jacobian, PC solver, int most, Vec like,
                               WorkVectors &work, int *solves, StationaryPoint *kind,
                               NegativeCurvature *found) {
  Vec r = nullptr, z = nullptr, p = nullptr, Hp = nullptr;
  PetscInt size = 0;
  double rz = 0;
  PetscFunctionBeginUser;
  *kind = StationaryPoint::unknown;
  PetscCall(work.get(Work::cg_residual, like, &r));
  PetscCall(work.get(Work::cg_preconditioned, like, &z));
  PetscCall(work.get(Work::cg_direction, like, &p));
  PetscCall(work.get(Work::product, like, &Hp));
  PetscCall(VecGetSize(r, &size));
  PetscCall(set_random_forces(jacobian.matrix(), r, z));
  PetscCall(PCApply(solver, r, z));
  PetscCall(dot(r, z, &rz));
  const double enough = 1e-8 / static_cast<double>(size) * rz;
  double squared_norm = rz;  // of p in the filtered Hessian's norm; the terms are orthogonal in it
  PetscCall(VecCopy(z, p));
  for (int k = 0; k < most && rz > 0; ++k) {
    double curvature = 0;
    ++*solves;
    PetscCall(jacobian.multiply_unfiltered(p, Hp));
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
