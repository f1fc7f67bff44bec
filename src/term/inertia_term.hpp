#pragma once

#include <memory>
#include <vector>

#include "term/mass_matrix.hpp"
#include "term/term.hpp"

namespace trefoil {

/// The inertia of a time step and, with it, damping in proportion to mass: the energy
///   |u - predicted|_M^2 / (2 s^2) + alpha |u - velocity_origin|_M^2 / (2 c),
/// s and c being StepState's inertia_time and velocity_time, up to a constant of the step. Its
/// Hessian is (1/s^2 + alpha/c) M, and the filter of the cells' elements sees it.
class InertiaTerm final : public Term {
 public:
  /// @param cells the elements that are filtered, in the order of the mesh's cells; must outlive
  /// this
  /// @param damping alpha, 1/time: the part of a velocity that is lost in a unit of time
  InertiaTerm(std::shared_ptr<const MassMatrix> mass, const ElementPacks &cells, double damping);

  /// The scale is the kinetic energy at the end of the step.
  PetscErrorCode add_energy(const double *u, EnergySums *sums) const override;
  PetscErrorCode add_energy_changes(const double *u, std::size_t size, int directions,
                                    const double *const *d, int points, const double *coefficients,
                                    double *changes) const override;
  PetscErrorCode add_gradient(const double *u, double *gradient) const override;
  [[nodiscard]] HessianKind hessian_kind() const override { return HessianKind::constant; }
  /// M.
  PetscErrorCode add_hessian(const double *u, StencilSink &sink) const override;
  [[nodiscard]] double hessian_scale() const override { return stiffness_; }

  [[nodiscard]] bool shifts_filter() const override { return true; }
  void shift_filter(const ElementPacks &cells, PetscInt first, PetscInt count,
                    double *K) const override;

  PetscErrorCode begin_step(const StepState &state) override;
  [[nodiscard]] double bytes() const override;

 private:
  void find_shifts();
  [[nodiscard]] std::vector<double> product(double factor, const std::vector<double> &w) const;

  std::shared_ptr<const MassMatrix> mass_;
  const ElementPacks &cells_;
  double damping_;
  /// What the filter sees of each pack's masses, times stiffness_: entries x 8 of the lower
  /// triangle of the reduced matrix of one component. Of linear elements, where that is a multiple
  /// of the identity, the number alone.
  std::vector<double> shifts_;

  // Of the step under way.
  double stiffness_ = 0;            ///< 1/s^2 + alpha/c
  std::vector<double> target_;      ///< where the energy is least
  double velocity_time_ = 1;        ///< c
  std::vector<double> drift_mass_;  ///< M (target - velocity_origin)
  double drift_square_ = 0;         ///< |target - velocity_origin|_M^2
};

}  // namespace trefoil
