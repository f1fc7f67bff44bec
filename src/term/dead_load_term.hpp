#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "term/term.hpp"

namespace trefoil {

/// The potential of forces on the vertices that do not depend on where the body goes: gravity, and
/// tractions per rest area. Energy -f.u, gradient -f, no Hessian.
class DeadLoadTerm final : public Term {
 public:
  /// Forces at time t: 3 a local vertex; zero where another rank owns the vertex. Collective.
  using ForcesAt = std::function<PetscErrorCode(double time, std::vector<double> *forces)>;

  /// Forces that are always the same.
  explicit DeadLoadTerm(std::vector<double> forces) : forces_(std::move(forces)) {}
  /// Forces of the time; none before the first set_time().
  explicit DeadLoadTerm(ForcesAt forces_at) : forces_at_(std::move(forces_at)) {}

  PetscErrorCode set_time(double time) override;

  /// The scale is the sum of |f.u| over the vertices.
  PetscErrorCode add_energy(const double *u, EnergySums *sums) const override;
  PetscErrorCode add_gradient(const double *u, double *gradient) const override;
  [[nodiscard]] HessianKind hessian_kind() const override { return HessianKind::none; }

  [[nodiscard]] double bytes() const override {
    return static_cast<double>(forces_.capacity() * sizeof(double));
  }

 private:
  ForcesAt forces_at_;
  std::vector<double> forces_;
};

}  // namespace trefoil
