#pragma once

#include <petscmat.h>

#include <functional>
#include <optional>

#include "hook/element_hook.hpp"

namespace trefoil {

/// The filtered Jacobian H + 2 w N, formed in the SNES's own matrix, beside N or, where somebody
/// multiplies by H, without it.
class FilteredJacobian {
 public:
  FilteredJacobian() = default;
  FilteredJacobian(const FilteredJacobian &) = delete;
  FilteredJacobian &operator=(const FilteredJacobian &) = delete;
  ~FilteredJacobian();

  /// Forgets what passed unfiltered in the solve before.
  void begin_solve();

  /// N; null until the first element is indefinite.
  [[nodiscard]] Mat negative() const { return negative_; }
  /// Where callbacks put it.
  Mat *place_of_negative() { return &negative_; }
  PetscErrorCode forget_negative();

  /// `matrix` is H, assembled: adds 2 w N to it, where N is part of it. N has its nonzero pattern.
  /// Collective.
  /// @param counts what was inserted into H, over all ranks
  PetscErrorCode form(Mat matrix, double weight, bool filtered, const InsertionCounts &counts);

  /// Hp = H p. Collective.
  using Product = std::function<PetscErrorCode(Vec p, Vec Hp)>;
  /// `matrix` is H + 2 w N already; no N is kept. Collective.
  PetscErrorCode take_formed(Mat matrix, double weight, const InsertionCounts &counts,
                             Product unfiltered);

  [[nodiscard]] Mat matrix() const { return matrix_; }
  [[nodiscard]] double weight() const { return weight_; }
  /// Elements in the last Jacobian that was watched, over all ranks.
  [[nodiscard]] PetscInt64 elements() const { return elements_; }
  /// What passed as it was, over the whole solve.
  [[nodiscard]] const InsertionCounts &unfiltered() const { return unfiltered_; }

  /// Whether the matrix is H itself: the weight is 0, no element was indefinite, or
  /// remove_filter().
  [[nodiscard]] bool is_unfiltered() const { return !negative_present_; }
  /// Whether negative curvature of the elements seen is taken out.
  [[nodiscard]] bool is_clamped() const { return weight_ >= 0.5; }
  /// Whether the matrix is a sum of positive semidefinite elements.
  [[nodiscard]] bool is_definite_by_construction() const {
    return is_clamped() && unfiltered_.unfiltered() == 0;
  }

  /// Hp of the unfiltered Hessian, also where the matrix is filtered. Collective.
  PetscErrorCode multiply_unfiltered(Vec p, Vec Hp) const;
  /// d'Hd of the unfiltered Hessian. Collective.
  PetscErrorCode unfiltered_curvature(Vec d, Vec Hd, double *curvature) const;

  /// Whether the matrix can become H where it is not.
  [[nodiscard]] bool can_remove_filter() const { return !unfiltered_product_; }
  /// The matrix becomes H, and H + 2 w N again. Collective.
  PetscErrorCode remove_filter();
  PetscErrorCode restore_filter();

  /// The weight of a Jacobian that is made once more because it was indefinite, instead of the
  /// rule's.
  std::optional<double> imposed_weight;

 private:
  Mat matrix_ = nullptr;        ///< borrowed from the SNES
  Mat negative_ = nullptr;      ///< N
  Product unfiltered_product_;  ///< where N is part of the matrix and not kept
  double weight_ = 0;
  bool negative_present_ = false;  ///< N is part of the matrix
  PetscInt64 elements_ = 0;
  InsertionCounts unfiltered_;
};

}  // namespace trefoil
