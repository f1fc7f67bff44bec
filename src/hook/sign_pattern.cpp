#include "hook/sign_pattern.hpp"

#include <algorithm>

#include "filter/filter.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Fewer blocks may be alike by chance.
constexpr PetscInt64 least_blocks = 16;

bool is_of_saddle(PetscInt64 blocks, const std::vector<PetscInt64> &negative,
                  const std::vector<PetscInt64> &positive) {
  bool multiplier = false, ordinary = false;
  for (std::size_t i = 0; i < negative.size(); ++i) {
    multiplier = multiplier || (positive[i] == 0 && 2 * negative[i] > blocks);
    ordinary = ordinary || (negative[i] == 0 && 2 * positive[i] > blocks);
  }
  return blocks >= least_blocks && multiplier && ordinary;
}

}  // namespace

void SignPattern::add(PetscInt n, const PetscScalar *block) {
  Signs &signs = signs_[n];
  signs.negative.resize(static_cast<std::size_t>(n));
  signs.positive.resize(static_cast<std::size_t>(n));
  ++signs.blocks;
  for (PetscInt i = 0; i < n; ++i) {
    const double diagonal = PetscRealPart(block[n * i + i]);
    signs.negative[static_cast<std::size_t>(i)] += diagonal < 0;
    signs.positive[static_cast<std::size_t>(i)] += diagonal > 0;
  }
}

PetscErrorCode SignPattern::count_saddle_blocks(MPI_Comm comm, PetscInt64 *count) const {
  std::vector<PetscInt64> blocks(largest_element_matrix + 1, 0);
  PetscFunctionBegin;
  *count = 0;
  for (const auto &[n, signs] : signs_) blocks[static_cast<std::size_t>(n)] = signs.blocks;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, blocks.data(), static_cast<PetscMPIInt>(blocks.size()),
                             MPIU_INT64, MPI_SUM, comm));
  for (std::size_t n = 1; n < blocks.size(); ++n) {
    if (blocks[n] == 0) continue;
    std::vector<PetscInt64> negative(n, 0), positive(n, 0);
    if (const auto mine = signs_.find(static_cast<PetscInt>(n)); mine != signs_.end()) {
      negative = mine->second.negative;
      positive = mine->second.positive;
    }
    const auto length = static_cast<PetscMPIInt>(n);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, negative.data(), length, MPIU_INT64, MPI_SUM, comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, positive.data(), length, MPIU_INT64, MPI_SUM, comm));
    if (is_of_saddle(blocks[n], negative, positive)) *count += blocks[n];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
