#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "support/petsc_compatibility.hpp"
#include "term/term.hpp"

namespace trefoil {

/// The potential of forces on the vertices that do not depend on where the body goes: gravity, and
/// tractions per rest area. Energy -f.u, gradient -f, no Hessian.
class DeadLoadTerm final : public Term {
 public:
  /// @param forces 3 a local vertex; zero where another rank owns the vertex
  explicit DeadLoadTerm(std::vector<double> forces) : forces_(std::move(forces)) {}

  void set_forces(std::vector<double> forces) { forces_ = std::move(forces); }

  /// The scale is the sum of |f.u| over the vertices.
  void add_energy(const double *u, EnergySums *sums) const override {
    for (std::size_t k = 0; k + 2 < forces_.size(); k += 3) {
      const double work = forces_[k] * u[k] + forces_[k + 1] * u[k + 1] + forces_[k + 2] * u[k + 2];
      sums->energy -= work;
      sums->scale += std::abs(work);
    }
  }

  void add_gradient(const double *u, double *gradient) const override {
    static_cast<void>(u);
    for (std::size_t k = 0; k < forces_.size(); ++k) gradient[k] -= forces_[k];
  }

  PetscErrorCode add_hessian(const double *u, ElementHessianSink &sink) const override {
    static_cast<void>(u), static_cast<void>(sink);
    return PETSC_SUCCESS;
  }
  [[nodiscard]] bool has_hessian() const override { return false; }

  [[nodiscard]] double bytes() const override {
    return static_cast<double>(forces_.capacity() * sizeof(double));
  }

 private:
  std::vector<double> forces_;
};

}  // namespace trefoil
