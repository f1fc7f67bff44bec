#pragma once

// A small problem for the tests of the plugin, written as a host would: the callbacks know PETSc
// and include/trefoil.h only.
//
// A chain of bars on a line, held at its left end. Bar e stands between vertices e - 1 and e (-1 is
// the held end at 0) and has two rest lengths, +l and -l, with a hill between them:
//     W(x) = E/4 (d^2 - 1)^2,   d = (x_e - x_{e-1}) / l,   W'' = E (3 d^2 - 1) < 0 for |d| < 0.577.
// An anchor pulls every vertex to its place: a/2 E ((x_e - (e + 1) l p) / l)^2, never concave.

#include <petscsnes.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

namespace trefoil::test {

/// What the Jacobian callback was asked and what it answered, one entry a call. Whole on every
/// rank.
struct JacobianCall {
  std::vector<double> x, hessian, negative;  ///< dense, row by row; negative empty where not asked
  bool asked = false;                        ///< negative != NULL: N was wanted
  bool existed = false;                      ///< *negative was there at entry
  bool answered = false;                     ///< *negative was there at exit
  int indefinite = 0;                        ///< bars with negative curvature
};

struct Chain {
  PetscInt vertices = 24;
  double anchor = 0.05;    ///< a
  double place = 1.2;      ///< p: where the anchors pull to, 1 is at rest
  double energy_unit = 1;  ///< E
  double length_unit = 1;  ///< l
  double constant = 0;     ///< added to the energy, in units of E

  // What the callbacks saw.
  std::vector<JacobianCall> calls;
  int energies = 0, residuals = 0;
  /// Replaces the n-th energy (from 1) where set.
  std::function<double(int n, double energy)> disturb_energy;
  /// Spoils the residual where it says so.
  std::function<bool(int n)> spoil_residual;
  /// Lets the n-th residual (from 1) end in an error where it says so.
  std::function<bool(int n)> fail_residual;

  [[nodiscard]] double anchor_place(PetscInt i) const {
    return place * static_cast<double>(i + 1) * length_unit;
  }
  /// d of bar e at the whole state x.
  [[nodiscard]] double stretch(const std::vector<double> &x, PetscInt e) const {
    const auto at = static_cast<std::size_t>(e);
    return (x[at] - (e > 0 ? x[at - 1] : 0)) / length_unit;
  }

  [[nodiscard]] double energy(const std::vector<double> &x) const {
    double sum = constant;
    for (PetscInt e = 0; e < vertices; ++e) {
      const double d = stretch(x, e);
      const double off = (x[static_cast<std::size_t>(e)] - anchor_place(e)) / length_unit;
      sum += 0.25 * (d * d - 1) * (d * d - 1) + 0.5 * anchor * off * off;
    }
    return energy_unit * sum;
  }

  [[nodiscard]] std::vector<double> gradient(const std::vector<double> &x) const {
    std::vector<double> g(x.size(), 0);
    for (PetscInt e = 0; e < vertices; ++e) {
      const auto at = static_cast<std::size_t>(e);
      const double d = stretch(x, e), force = energy_unit / length_unit * d * (d * d - 1);
      g[at] += force;
      if (e > 0) g[at - 1] -= force;
      g[at] += energy_unit * anchor * (x[at] - anchor_place(e)) / (length_unit * length_unit);
    }
    return g;
  }

  [[nodiscard]] double curvature(const std::vector<double> &x, PetscInt e) const {
    const double d = stretch(x, e);
    return energy_unit / (length_unit * length_unit) * (3 * d * d - 1);
  }
  [[nodiscard]] int indefinite(const std::vector<double> &x) const {
    int count = 0;
    for (PetscInt e = 0; e < vertices; ++e) count += curvature(x, e) < 0;
    return count;
  }

  /// Hands every 1x1 and 2x2 element matrix to `add(rows, indices, values)`: the bars' Hessian or
  /// negative part by `bar(curvature)`, and the anchors'.
  template <class Bar, class Add>
  PetscErrorCode each_element(const std::vector<double> &x, PetscInt begin, PetscInt end,
                              const Bar &bar, double anchors, const Add &add) const {
    PetscFunctionBeginUser;
    for (PetscInt e = begin; e < end; ++e) {
      const double c = bar(curvature(x, e));
      const PetscInt index[2] = {e - 1, e};  // -1: held, which PETSc leaves out
      const double block[4] = {c, -c, -c, c};
      const double diagonal = anchors * anchor * energy_unit / (length_unit * length_unit);
      PetscCall(add(2, index, block));
      PetscCall(add(1, &index[1], &diagonal));
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  static double all_of(double curvature) { return curvature; }
  static double negative_part(double curvature) { return std::max(0.0, -curvature); }

  /// The whole matrix, dense, summed by nobody's code but this.
  [[nodiscard]] std::vector<double> dense(const std::vector<double> &x, bool negative) const {
    const auto n = static_cast<std::size_t>(vertices);
    std::vector<double> matrix(n * n, 0);
    const auto add = [&](int rows, const PetscInt *index, const double *values) {
      for (int i = 0; i < rows; ++i)
        for (int j = 0; j < rows; ++j)
          if (index[i] >= 0 && index[j] >= 0)
            matrix[static_cast<std::size_t>(index[i]) * n + static_cast<std::size_t>(index[j])] +=
                values[rows * i + j];
      return PetscErrorCode{PETSC_SUCCESS};
    };
    static_cast<void>(
        each_element(x, 0, vertices, negative ? negative_part : all_of, negative ? 0 : 1, add));
    return matrix;
  }
};

/// The whole vector on every rank: the chain is small.
inline PetscErrorCode whole(Vec x, std::vector<double> *values) {
  VecScatter scatter = nullptr;
  Vec all = nullptr;
  const PetscScalar *array = nullptr;
  PetscInt size = 0;
  PetscFunctionBeginUser;
  PetscCall(VecScatterCreateToAll(x, &scatter, &all));
  PetscCall(VecScatterBegin(scatter, x, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(scatter, x, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetSize(x, &size));
  PetscCall(VecGetArrayRead(all, &array));
  values->assign(array, array + size);
  PetscCall(VecRestoreArrayRead(all, &array));
  PetscCall(VecDestroy(&all));
  PetscCall(VecScatterDestroy(&scatter));
  PetscFunctionReturn(PETSC_SUCCESS);
}

inline PetscErrorCode fill(Vec x, const std::vector<double> &values) {
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(VecGetOwnershipRange(x, &begin, &end));
  for (PetscInt i = begin; i < end; ++i)
    PetscCall(VecSetValue(x, i, values[static_cast<std::size_t>(i)], INSERT_VALUES));
  PetscCall(VecAssemblyBegin(x));
  PetscCall(VecAssemblyEnd(x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The whole matrix on every rank, dense, row by row.
inline PetscErrorCode whole(Mat matrix, std::vector<double> *values) {
  PetscInt begin = 0, end = 0, n = 0;
  PetscFunctionBeginUser;
  PetscCall(MatGetSize(matrix, &n, nullptr));
  PetscCall(MatGetOwnershipRange(matrix, &begin, &end));
  values->assign(static_cast<std::size_t>(n * n), 0);
  for (PetscInt row = begin; row < end; ++row)
    for (PetscInt column = 0; column < n; ++column)
      PetscCall(MatGetValues(matrix, 1, &row, 1, &column,
                             &(*values)[static_cast<std::size_t>(row * n + column)]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, values->data(), static_cast<int>(values->size()),
                             MPI_DOUBLE, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(matrix))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

inline PetscErrorCode chain_energy(SNES, Vec x, PetscReal *energy, void *ctx) {
  auto &chain = *static_cast<Chain *>(ctx);
  std::vector<double> values;
  PetscFunctionBeginUser;
  PetscCall(whole(x, &values));
  *energy = chain.energy(values);
  ++chain.energies;
  if (chain.disturb_energy) *energy = chain.disturb_energy(chain.energies, *energy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

inline PetscErrorCode chain_gradient(SNES, Vec x, Vec g, void *ctx) {
  auto &chain = *static_cast<Chain *>(ctx);
  std::vector<double> values;
  PetscFunctionBeginUser;
  PetscCall(whole(x, &values));
  PetscCall(fill(g, chain.gradient(values)));
  ++chain.residuals;
  if (chain.fail_residual && chain.fail_residual(chain.residuals))
    SETERRQ(PetscObjectComm(reinterpret_cast<PetscObject>(x)), PETSC_ERR_USER, "as the test asks");
  if (chain.spoil_residual && chain.spoil_residual(chain.residuals))
    PetscCall(VecSet(g, std::numeric_limits<double>::quiet_NaN()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The size of the energy without its constant: what it costs to leave the rest state.
inline PetscErrorCode chain_scale(SNES, Vec x, PetscReal *scale, void *ctx) {
  const auto &chain = *static_cast<Chain *>(ctx);
  std::vector<double> values;
  PetscFunctionBeginUser;
  PetscCall(whole(x, &values));
  *scale = chain.energy(values) - chain.energy_unit * chain.constant;
  PetscFunctionReturn(PETSC_SUCCESS);
}

inline PetscErrorCode chain_assemble(const Chain &chain, const std::vector<double> &x, Mat matrix,
                                     bool negative) {
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(matrix));
  PetscCall(MatGetOwnershipRange(matrix, &begin, &end));
  PetscCall(chain.each_element(
      x, begin, end, negative ? Chain::negative_part : Chain::all_of, negative ? 0 : 1,
      [&](int rows, const PetscInt *index, const double *values) {
        return MatSetValues(matrix, rows, index, rows, index, values, ADD_VALUES);
      }));
  PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// As include/trefoil.h asks for: N made when the first bar is concave, and left alone, with what
/// it held before, where none is.
inline PetscErrorCode chain_hessian(SNES, Vec x, Mat H, Mat *negative,
                                    TrefoilSplitStatistics *statistics, void *ctx) {
  auto &chain = *static_cast<Chain *>(ctx);
  JacobianCall call;
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(whole(x, &call.x));
  PetscCall(chain_assemble(chain, call.x, H, false));
  PetscCall(MatGetOwnershipRange(H, &begin, &end));
  call.indefinite = chain.indefinite(call.x);
  call.hessian = chain.dense(call.x, false);
  call.asked = negative != nullptr;
  call.existed = negative && *negative;
  statistics->elements = 2 * (end - begin);
  if (negative) {
    call.negative = chain.dense(call.x, true);
    for (PetscInt e = begin; e < end; ++e) statistics->indefinite += chain.curvature(call.x, e) < 0;
    if (call.indefinite > 0) {
      if (!*negative) PetscCall(MatDuplicate(H, MAT_DO_NOT_COPY_VALUES, negative));
      PetscCall(chain_assemble(chain, call.x, *negative, true));
    }
    call.answered = *negative != nullptr;
  }
  chain.calls.push_back(std::move(call));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A matrix with room for the chain.
inline PetscErrorCode chain_matrix(const Chain &chain, Mat *matrix) {
  PetscFunctionBeginUser;
  PetscCall(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, chain.vertices,
                         chain.vertices, 3, nullptr, 2, nullptr, matrix));
  PetscCall(MatSetOption(*matrix, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil::test
