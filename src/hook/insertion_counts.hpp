#pragma once

#include <petscsys.h>

#include <array>

namespace trefoil {

/// What went into a hooked Mat during one Jacobian callback. Counts of this rank, then of all.
struct InsertionCounts {
  PetscInt64 elements = 0;      ///< element blocks: added, square, the same indices on both sides
  PetscInt64 indefinite = 0;    ///< of these, with a negative eigenvalue
  PetscInt64 rectangular = 0;   ///< added blocks with different numbers of rows and columns
  PetscInt64 partial = 0;       ///< of the rectangular ones, with rows that are among the columns
  PetscInt64 nonsymmetric = 0;  ///< element blocks that are not symmetric
  PetscInt64 saddle = 0;        ///< element blocks of a saddle point
  PetscInt64 not_finite = 0;    ///< element blocks with NaN or Inf
  PetscInt64 too_large = 0;     ///< element blocks larger than the filter takes
  PetscInt64 negative_diagonals = 0;  ///< additions below zero to the diagonal, filtered as well
  PetscInt64 singles = 0;             ///< single numbers added off the diagonal: parts of elements
  PetscInt64 one_sided = 0;           ///< scalings of rows or columns alone, which leave no Hessian
  PetscInt64 changed = 0;             ///< matrices that are not the sum of what was added to them
  PetscInt64 unseen = 0;              ///< matrices without entries

  [[nodiscard]] PetscInt64 unfiltered() const {
    return rectangular + nonsymmetric + saddle + not_finite + too_large + singles + one_sided +
           changed + unseen;
  }
  InsertionCounts &operator+=(const InsertionCounts &more);
  /// The sums over all ranks. Collective.
  PetscErrorCode sum_over_ranks(MPI_Comm comm);

 private:
  [[nodiscard]] std::array<PetscInt64 *, 13> all();
};

}  // namespace trefoil
