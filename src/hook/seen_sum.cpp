#include "hook/seen_sum.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"
#include "support/split_mix.hpp"

namespace trefoil {
namespace {

/// Differences below this share of the terms are rounding.
constexpr double rounding = 1e-10;

}  // namespace

double SeenSum::probe(PetscInt i) const {
  if (i < 0 || (!is_excluded_.empty() && is_excluded_[static_cast<std::size_t>(i)])) return 0;
  return random_number(i);
}

void SeenSum::restart() {
  sum_ = size_ = 0;
  excluded_.clear();
}

void SeenSum::add(PetscInt m, const PetscInt *rows, PetscInt n, const PetscInt *columns,
                  const PetscScalar *values) {
  constexpr PetscInt most = 192;
  double z[most];
  for (PetscInt first = 0; first < n; first += most) {  // blocks wider than that are rare
    const PetscInt width = std::min(most, n - first);
    for (PetscInt j = 0; j < width; ++j) z[j] = probe(columns[first + j]);
    for (PetscInt i = 0; i < m; ++i) {
      const PetscScalar *row = values + n * i + first;
      double product = 0;
      for (PetscInt j = 0; j < width; ++j) product += PetscRealPart(row[j]) * z[j];
      product *= probe(rows[i]);
      sum_ += product;
      size_ += std::abs(product);
    }
  }
}

void SeenSum::scale(double factor) {
  sum_ *= factor;
  size_ *= std::abs(factor);
}

PetscErrorCode SeenSum::add_to_diagonal(Mat matrix, Vec diagonal, double constant) {
  PetscInt begin = 0, end = 0;
  const PetscScalar *values = nullptr;
  PetscFunctionBegin;
  PetscCall(MatGetOwnershipRange(matrix, &begin, &end));
  if (diagonal) PetscCall(VecGetArrayRead(diagonal, &values));
  for (PetscInt i = begin; i < end; ++i) {
    const double z = probe(i);
    const double term = z * z * (values ? PetscRealPart(values[i - begin]) : constant);
    sum_ += term;
    size_ += std::abs(term);
  }
  if (diagonal) PetscCall(VecRestoreArrayRead(diagonal, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SeenSum::product(Mat matrix, double *zHz) const {
  Vec z = nullptr, Hz = nullptr;
  PetscInt begin = 0, end = 0;
  PetscScalar *values = nullptr;
  PetscFunctionBegin;
  PetscCall(MatCreateVecs(matrix, &z, &Hz));
  PetscCall(VecGetOwnershipRange(z, &begin, &end));
  PetscCall(VecGetArray(z, &values));
  for (PetscInt i = begin; i < end; ++i) values[i - begin] = probe(i);
  PetscCall(VecRestoreArray(z, &values));
  PetscCall(MatMult(matrix, z, Hz));
  PetscCall(dot(z, Hz, zHz));
  PetscCall(VecDestroy(&z));
  PetscCall(VecDestroy(&Hz));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SeenSum::take(Mat matrix) {
  PetscMPIInt rank = 0;
  double zHz = 0;
  PetscFunctionBegin;
  PetscCall(product(matrix, &zHz));
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), &rank));
  sum_ = rank == 0 ? zHz : 0;
  size_ = std::abs(sum_);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SeenSum::knows_excluded(MPI_Comm comm, bool *known) {
  PetscInt64 code = 0;
  PetscFunctionBegin;
  std::sort(excluded_.begin(), excluded_.end());
  excluded_.erase(std::unique(excluded_.begin(), excluded_.end()), excluded_.end());
  for (const PetscInt row : excluded_) {
    code += static_cast<PetscInt64>(mixed(static_cast<std::uint64_t>(row)) >> 16);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &code, 1, MPIU_INT64, MPI_SUM, comm));
  *known = code == code_of_excluded_;
  code_of_excluded_ = code;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SeenSum::differs(Mat matrix, bool *differs) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(matrix));
  const PetscInt64 code_before = code_of_excluded_;
  double seen[2] = {sum_, size_}, zHz = 0;
  bool known = false;
  PetscFunctionBegin;
  *differs = false;
  PetscCall(knows_excluded(comm, &known));
  code_of_excluded_ = code_before;  // finish() takes them
  if (!known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, seen, 2, MPI_DOUBLE, MPI_SUM, comm));
  PetscCall(product(matrix, &zHz));
  *differs = std::isfinite(zHz) && std::abs(zHz - seen[0]) > rounding * seen[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SeenSum::finish(Mat matrix) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(matrix));
  bool known = false;
  PetscMPIInt ranks = 0;
  PetscInt size = 0;
  PetscFunctionBegin;
  PetscCall(knows_excluded(comm, &known));
  if (known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatGetSize(matrix, &size, nullptr));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  std::vector<PetscMPIInt> counts(static_cast<std::size_t>(ranks)), begins(counts.size());
  const auto count = static_cast<PetscMPIInt>(excluded_.size());
  PetscCallMPI(MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm));
  PetscMPIInt total = 0;
  for (std::size_t r = 0; r < counts.size(); ++r) {
    begins[r] = total;
    total += counts[r];
  }
  std::vector<PetscInt> all(static_cast<std::size_t>(total));
  PetscCallMPI(MPI_Allgatherv(excluded_.data(), count, MPIU_INT, all.data(), counts.data(),
                              begins.data(), MPIU_INT, comm));
  is_excluded_.assign(static_cast<std::size_t>(size), false);
  for (const PetscInt row : all) is_excluded_[static_cast<std::size_t>(row)] = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode are_equal(Mat one, Mat other, bool *equal) {
  Vec z = nullptr, product = nullptr, difference = nullptr;
  PetscReal size = 0, distance = 0;
  PetscFunctionBegin;
  PetscCall(MatCreateVecs(one, &z, &product));
  PetscCall(VecDuplicate(product, &difference));
  PetscCall(VecSetRandom(z, nullptr));
  PetscCall(MatMult(one, z, product));
  PetscCall(MatMult(other, z, difference));
  PetscCall(VecNorm(product, NORM_2, &size));
  PetscCall(VecAXPY(difference, -1, product));
  PetscCall(VecNorm(difference, NORM_2, &distance));
  *equal = distance <= rounding * size;
  PetscCall(VecDestroy(&z));
  PetscCall(VecDestroy(&product));
  PetscCall(VecDestroy(&difference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
