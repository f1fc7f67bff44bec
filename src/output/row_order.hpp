#pragma once

#include <petscsf.h>

#include <vector>

namespace trefoil {

/// Brings rows that ranks hold in any order into the order of their numbers, of which every rank
/// then has an even share. Rows are those of one rank or another; each has a number that no other
/// has.
class RowOrder {
 public:
  RowOrder() = default;
  RowOrder(const RowOrder &) = delete;
  RowOrder &operator=(const RowOrder &) = delete;
  ~RowOrder();

  /// Collective; once. PETSC_ERR_ARG_SIZ where a number is negative or given twice.
  /// @param numbers of this rank's rows
  PetscErrorCode set_up(MPI_Comm comm, const std::vector<PetscInt> &numbers);

  [[nodiscard]] PetscInt total() const { return total_; }  ///< rows of all ranks
  [[nodiscard]] PetscInt first() const { return first_; }  ///< place of this rank's first row

  /// This rank's share of the rows in their order. Collective.
  /// @param values rows as set_up() had them x width
  PetscErrorCode arrange(const std::vector<double> &values, int width,
                         std::vector<double> *rows) const;
  PetscErrorCode arrange(const std::vector<PetscInt> &values, int width,
                         std::vector<PetscInt> *rows) const;

  /// The other way round: rows of any numbers, of any rank's, from this rank's share. Collective.
  /// @param rows share x width   @param values numbers x width
  PetscErrorCode fetch(const std::vector<PetscInt> &numbers, const std::vector<double> &rows,
                       int width, std::vector<double> *values) const;
  [[nodiscard]] PetscInt share() const { return share_; }  ///< rows of this rank's share

  /// Replaces numbers of rows, of any rank's, by their places in the order. Collective.
  PetscErrorCode find_places(std::vector<PetscInt> *numbers) const;

 private:
  PetscErrorCode close_gaps(const std::vector<PetscInt> &numbers, std::vector<PetscInt> *places);
  template <class T>
  PetscErrorCode arrange(MPI_Datatype type, const std::vector<T> &values, int width,
                         std::vector<T> *rows) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  PetscSF to_rows_ = nullptr;  ///< leaves: rows as they are; roots: rows in their order
  PetscInt total_ = 0, first_ = 0, share_ = 0;
  PetscLayout by_number_ = nullptr;  ///< of all numbers, gaps included; null: there are no gaps
  std::vector<PetscInt> place_of_number_;  ///< of this rank's share of the numbers
};

}  // namespace trefoil
