#pragma once

#include <petscsys.h>

#include <map>
#include <vector>

namespace trefoil {

/// Blocks of a saddle point whose multipliers have a block of their own, -C of perturbed u-p
/// elements say: some of their unknowns have a negative diagonal in every element, others a
/// positive one. No energy's elements are so alike, but where all of them do the same thing; only
/// in 1D have all unknowns of a concave element a negative diagonal, and these are not meant.
class SignPattern {
 public:
  /// Takes the signs of a block's diagonal in.
  void add(PetscInt n, const PetscScalar *block);
  /// The blocks, over all ranks, of sizes that are those of a saddle point. Collective.
  PetscErrorCode count_saddle_blocks(MPI_Comm comm, PetscInt64 *count) const;

 private:
  struct Signs {
    PetscInt64 blocks = 0;
    std::vector<PetscInt64> negative, positive;  ///< how often, for each unknown of the element
  };
  std::map<PetscInt, Signs> signs_;  ///< by size of block
};

}  // namespace trefoil
