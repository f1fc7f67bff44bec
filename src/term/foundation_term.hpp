#pragma once

#include <array>
#include <functional>
#include <utility>
#include <vector>

#include "mesh/boundary.hpp"
#include "term/term.hpp"

namespace trefoil {

/// Springs on facets at rest (Winkler's foundation): energy k/2 |u|^2 per rest area, or k/2 (u .
/// n)^2 with the normal n at rest, under which the body slides freely.
class FoundationTerm final : public Term {
 public:
  enum class Along { all_directions, normal };
  /// Stiffness at a rest position and time: force per area and displacement, not negative. What is
  /// wrong with it throws InputError.
  using StiffnessAt = std::function<double(const std::array<double, 3> &position, double time)>;

  /// `mesh` must outlive this. No springs before the first set_time().
  FoundationTerm(const Mesh &mesh, std::vector<Facet> facets, Along along, StiffnessAt stiffness_at)
      : mesh_(mesh),
        facets_(std::move(facets)),
        along_(along),
        stiffness_at_(std::move(stiffness_at)) {}

  PetscErrorCode set_time(double time) override;

  PetscErrorCode add_energy(const double *u, EnergySums *sums) const override;
  PetscErrorCode add_gradient(const double *u, double *gradient) const override;
  [[nodiscard]] HessianKind hessian_kind() const override { return HessianKind::stencils; }
  /// Positive semi-definite.
  PetscErrorCode add_hessian(const double *u, StencilSink &sink) const override;

  [[nodiscard]] double bytes() const override {
    return static_cast<double>(matrices_.capacity() * sizeof(double));
  }

 private:
  [[nodiscard]] std::vector<PetscInt> dofs_of(const Facet &facet) const;
  void add_facet(const Facet &facet, double time);
  template <class Visit>
  void visit(const double *u, const Visit &visit_facet) const;

  const Mesh &mesh_;
  std::vector<Facet> facets_;
  Along along_;
  StiffnessAt stiffness_at_;
  std::vector<double> matrices_;  ///< of each facet, one after the other
};

}  // namespace trefoil
