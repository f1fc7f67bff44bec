#pragma once

#include <vector>

#include "term/packed_elements.hpp"
#include "term/term.hpp"

namespace trefoil {

/// Damping in proportion to stiffness: the energy beta |u - velocity_origin|_K^2 / (2 c) of a time
/// step, c being StepState's velocity_time and K the elements' clamped Hessians H + N at the last
/// state that stands. K is frozen for the step and positive semi-definite: it takes energy only.
class DampingTerm final : public Term {
 public:
  /// @param cells the elements of the elastic term; must outlive this
  /// @param size of local arrays, 3 a local vertex
  /// @param damping beta, in units of time
  DampingTerm(const PackedElements &cells, std::size_t size, double damping)
      : cells_(cells), damping_(damping), origin_(size) {}

  PetscErrorCode add_energy(const double *u, EnergySums *sums) const override;
  PetscErrorCode add_energy_changes(const double *u, std::size_t size, int directions,
                                    const double *const *d, int points, const double *coefficients,
                                    double *changes) const override;
  PetscErrorCode add_gradient(const double *u, double *gradient) const override;
  [[nodiscard]] HessianKind hessian_kind() const override { return HessianKind::constant; }
  /// K.
  PetscErrorCode add_hessian(const double *u, StencilSink &sink) const override;
  [[nodiscard]] double hessian_scale() const override { return hessian_scale_; }
  [[nodiscard]] int hessian_version() const override { return version_; }

  /// Of a step without length, in which a scene finds its first accelerations, the forces count but
  /// no stiffness.
  PetscErrorCode begin_step(const StepState &state) override;
  /// Makes K anew.
  PetscErrorCode accept_step(const double *u) override;
  [[nodiscard]] double bytes() const override;

 private:
  [[nodiscard]] std::vector<double> product(double factor, const std::vector<double> &w) const;
  [[nodiscard]] std::vector<double> moved(const double *u) const;

  const PackedElements &cells_;
  double damping_;
  std::vector<double> stiffness_;  ///< reduced K of all packs, see PackedElements
  int version_ = 0;                ///< of K

  // Of the step under way.
  double scale_ = 0, hessian_scale_ = 0;  ///< beta / c
  std::vector<double> origin_;
};

}  // namespace trefoil
