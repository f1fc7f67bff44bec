#include "hook/insertion_counts.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {

std::array<PetscInt64 *, 13> InsertionCounts::all() {
  return {&elements, &indefinite, &rectangular,       &partial, &nonsymmetric,
          &saddle,   &not_finite, &too_large,         &singles, &one_sided,
          &changed,  &unseen,     &negative_diagonals};
}

InsertionCounts &InsertionCounts::operator+=(const InsertionCounts &more) {
  InsertionCounts other = more;
  const auto mine = all(), theirs = other.all();
  for (std::size_t i = 0; i < mine.size(); ++i) *mine[i] += *theirs[i];
  return *this;
}

PetscErrorCode InsertionCounts::sum_over_ranks(MPI_Comm comm) {
  std::array<PetscInt64, 13> sums{};
  PetscFunctionBegin;
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = *all()[i];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<PetscMPIInt>(sums.size()),
                             MPIU_INT64, MPI_SUM, comm));
  for (std::size_t i = 0; i < sums.size(); ++i) *all()[i] = sums[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
