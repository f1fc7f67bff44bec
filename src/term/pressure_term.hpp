#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "mesh/boundary.hpp"
#include "term/term.hpp"

namespace trefoil {

/// A pressure p on the current area of facets, which follows the body: its force on each piece of
/// surface is -p n da. Its potential is p times the volume that the facets sweep where every point
/// goes straight from rest, X, to where it is, x = X + u:
///
///   V = int u . (A x B) over the facet, averaged over the way: with tangents a, b of the facet at
///   rest and p, q of u,  u . (a x b + (a x q + p x b) / 2 + (p x q) / 3).
///
/// What adjacent facets sweep fits together, so that the force is exact [Schweizerhof and Ramm,
/// Displacement dependent pressure loads, Comput. Struct. 18 (1984)] on a surface without a rim,
/// and where the rim is held or moves in planes that it is in at rest. A rim that is free to go
/// elsewhere feels the work that it would do along straight lines: a pressure of one value on a
/// surface with such a rim has no potential.
class PressureTerm final : public Term {
 public:
  /// The pressure at a time, positive into the body. Collective.
  using PressureAt = std::function<PetscErrorCode(double time, double *pressure)>;

  /// `mesh` must outlive this. No pressure before the first set_time().
  PressureTerm(const Mesh &mesh, std::vector<Facet> facets, PressureAt pressure_at)
      : mesh_(mesh), facets_(std::move(facets)), pressure_at_(std::move(pressure_at)) {}

  PetscErrorCode set_time(double time) override { return pressure_at_(time, &pressure_); }

  PetscErrorCode add_energy(const double *u, EnergySums *sums) const override;
  PetscErrorCode add_gradient(const double *u, double *gradient) const override;
  [[nodiscard]] HessianKind hessian_kind() const override { return HessianKind::stencils; }
  PetscErrorCode add_hessian(const double *u, StencilSink &sink) const override;

  /// Adds the force on the facets' nodes, int -N p n da: the gradient's opposite but at a rim.
  void add_surface_force(const double *u, double *force) const;

  [[nodiscard]] double bytes() const override {
    return static_cast<double>(facets_.capacity() * sizeof(Facet));
  }

 private:
  const Mesh &mesh_;
  std::vector<Facet> facets_;
  PressureAt pressure_at_;
  double pressure_ = 0;
};

}  // namespace trefoil
