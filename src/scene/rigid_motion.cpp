#include "scene/rigid_motion.hpp"

// PETSc's names for LAPACK need the types of the header above.
#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using Vector = std::array<double, 3>;

Vector cross(const Vector &a, const Vector &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Vector &a, const Vector &b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// v turned about an axis of length one (Rodrigues).
Vector turned(const Vector &v, const Vector &axis, double angle) {
  const Vector side = cross(axis, v);
  const double c = std::cos(angle), s = std::sin(angle), along = dot(axis, v) * (1 - c);
  return {c * v[0] + s * side[0] + along * axis[0], c * v[1] + s * side[1] + along * axis[1],
          c * v[2] + s * side[2] + along * axis[2]};
}

/// The unit quaternion that maximises q'Nq, of several the one nearest to no turn.
/// @param C sum over the places of (from)_i (to)_j about their means
PetscErrorCode best_quaternion(const double C[3][3], double q[4]) {
  constexpr PetscBLASInt size = 4, work_size = 64;
  const double diagonal = C[0][0] + C[1][1] + C[2][2];
  double N[16], eigenvalues[4], work[work_size];
  PetscBLASInt info = 0;
  PetscFunctionBeginUser;
  N[0] = diagonal;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    N[4 * (i + 1)] = N[i + 1] = C[j][k] - C[k][j];
    for (int l = 0; l < 3; ++l) {
      N[4 * (i + 1) + l + 1] = i == l ? 2 * C[i][i] - diagonal : C[i][l] + C[l][i];
    }
  }
  LAPACKsyev_("V", "U", &size, N, &size, eigenvalues, work, &work_size, &info);
  PetscCheck(info == 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK dsyev failed with %d",
             static_cast<int>(info));
  const double scale = std::max(std::abs(eigenvalues[0]), std::abs(eigenvalues[3]));
  std::fill_n(q, 4, 0.);
  for (int m = 0; m < 4; ++m) {  // (1, 0, 0, 0) projected to the space of the largest eigenvalue
    if (eigenvalues[m] < eigenvalues[3] - 1e-10 * scale) continue;
    for (int i = 0; i < 4; ++i) q[i] += N[4 * m] * N[4 * m + i];
  }
  double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (length < 1e-8) {  // half a turn in any case
    std::copy_n(N + 12, 4, q);
    length = 1;
  }
  for (int i = 0; i < 4; ++i) q[i] /= q[0] < 0 ? -length : length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The screw that turns by a quaternion and takes one mean to the other.
RigidMotion screw(const double q[4], const Vector &mean_from, const Vector &mean_to) {
  constexpr double no_turn = 1e-9;
  RigidMotion motion;
  const double sine = std::hypot(q[1], q[2], q[3]);
  motion.angle = 2 * std::atan2(sine, q[0]);
  if (motion.angle < no_turn) {
    motion.angle = 0;
    for (std::size_t i = 0; i < 3; ++i) motion.slide[i] = mean_to[i] - mean_from[i];
    return motion;
  }
  motion.axis = {q[1] / sine, q[2] / sine, q[3] / sine};
  // The mean goes by `way`: along the axis it slides, across it turns about the point sought.
  const Vector way{mean_to[0] - mean_from[0], mean_to[1] - mean_from[1], mean_to[2] - mean_from[2]};
  const double along = dot(way, motion.axis), cotangent = q[0] / sine;
  Vector across;
  for (std::size_t i = 0; i < 3; ++i) {
    motion.slide[i] = along * motion.axis[i];
    across[i] = way[i] - motion.slide[i];
  }
  const Vector side = cross(motion.axis, across);
  for (std::size_t i = 0; i < 3; ++i) {
    motion.point[i] = mean_from[i] + (across[i] + cotangent * side[i]) / 2;
  }
  return motion;
}

}  // namespace

std::array<double, 3> RigidMotion::move(const double *place, double t) const {
  if (angle == 0) {
    return {place[0] + t * slide[0], place[1] + t * slide[1], place[2] + t * slide[2]};
  }
  const Vector arm =
      turned({place[0] - point[0], place[1] - point[1], place[2] - point[2]}, axis, t * angle);
  return {point[0] + arm[0] + t * slide[0], point[1] + arm[1] + t * slide[1],
          point[2] + arm[2] + t * slide[2]};
}

PetscErrorCode fit_rigid_motion(MPI_Comm comm, const std::vector<double> &from,
                                const std::vector<double> &to, RigidMotion *motion,
                                double *deviation) {
  double sums[7] = {}, C[3][3] = {}, q[4];
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < from.size(); k += 3) {
    for (std::size_t i = 0; i < 3; ++i) sums[i] += from[k + i], sums[3 + i] += to[k + i];
    ++sums[6];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 7, MPI_DOUBLE, MPI_SUM, comm));
  const double count = std::max(sums[6], 1.);
  const Vector mean_from{sums[0] / count, sums[1] / count, sums[2] / count},
      mean_to{sums[3] / count, sums[4] / count, sums[5] / count};
  for (std::size_t k = 0; k < from.size(); k += 3) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        C[i][j] += (from[k + i] - mean_from[i]) * (to[k + j] - mean_to[j]);
      }
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, C, 9, MPI_DOUBLE, MPI_SUM, comm));
  PetscCall(best_quaternion(C, q));
  *motion = screw(q, mean_from, mean_to);
  *deviation = 0;
  for (std::size_t k = 0; k < from.size(); k += 3) {
    const Vector moved = motion->move(&from[k], 1);
    *deviation = std::max(*deviation,
                          std::hypot(moved[0] - to[k], moved[1] - to[k + 1], moved[2] - to[k + 2]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, deviation, 1, MPI_DOUBLE, MPI_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
