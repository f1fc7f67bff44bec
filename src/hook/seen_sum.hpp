#pragma once

#include <petscmat.h>

#include <vector>

namespace trefoil {

/// Whether a Mat is the sum of the blocks that were seen when they were added: z'(sum of blocks)z
/// is summed as they come and compared with z'Hz of the assembled Mat, at the price of one product.
/// z is random, the same on all ranks without communication, and zero for unknowns whose rows the
/// host sets otherwise: zeroes, or inserts a diagonal into. These are known from the last callback
/// only; a first Jacobian with such rows is not compared.
class SeenSum {
 public:
  /// Begins with nothing seen.
  void restart();
  /// A block of m x n numbers was added. Negative indices are left out.
  void add(PetscInt m, const PetscInt *rows, PetscInt n, const PetscInt *columns,
           const PetscScalar *values);
  /// The host sets this row in its own way.
  void exclude(PetscInt row) {
    if (row >= 0) excluded_.push_back(row);
  }
  /// The whole matrix was multiplied by a number.
  void scale(double factor);
  /// `diagonal` (null: a constant) was added to the matrix's diagonal. Not collective.
  PetscErrorCode add_to_diagonal(Mat matrix, Vec diagonal, double constant);
  /// Takes the matrix as it is now for what was seen. Collective.
  PetscErrorCode take(Mat matrix);

  /// Whether `matrix` differs from what was seen, by more than rounding; false where that cannot be
  /// told yet. Collective.
  PetscErrorCode differs(Mat matrix, bool *differs);
  /// After a callback: takes its excluded rows for those of the next. Collective.
  PetscErrorCode finish(Mat matrix);

 private:
  [[nodiscard]] double probe(PetscInt i) const;
  PetscErrorCode product(Mat matrix, double *zHz) const;
  PetscErrorCode knows_excluded(MPI_Comm comm, bool *known);

  double sum_ = 0;                  ///< of this rank's blocks
  double size_ = 0;                 ///< the same of absolute values
  std::vector<PetscInt> excluded_;  ///< by this rank, in this callback
  std::vector<bool> is_excluded_;   ///< by any rank, in the last; empty: none
  PetscInt64 code_of_excluded_ = 0;
};

/// Whether two matrices are the same operator, by the product with one random vector. Collective.
PetscErrorCode are_equal(Mat one, Mat other, bool *equal);

}  // namespace trefoil
