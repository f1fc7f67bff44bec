#include "term/foundation_term.hpp"

#include "support/collective_error.hpp"
#include "term/facet_points.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {

std::vector<PetscInt> FoundationTerm::dofs_of(const Facet &facet) const {
  std::vector<PetscInt> dofs;
  for (const PetscInt vertex : facet) {
    for (PetscInt i = 0; i < mesh_.dimension(); ++i) dofs.push_back(3 * vertex + i);
  }
  return dofs;
}

/// Appends int k N_a N_b I, or int k N_a N_b n n', of a facet.
void FoundationTerm::add_facet(const Facet &facet, double time) {
  const auto dim = static_cast<std::size_t>(mesh_.dimension());
  const std::size_t nodes = static_cast<std::size_t>(facet.count()), n = dim * nodes;
  const std::size_t begin = matrices_.size();
  matrices_.resize(begin + n * n, 0);
  for (const FacetPoint &point : points_of_facet(mesh_, facet)) {
    const double stiffness = stiffness_at_(point.position, time) * point.area;
    for (std::size_t a = 0; a < nodes; ++a) {
      for (std::size_t b = 0; b < nodes; ++b) {
        const double both = stiffness * point.values[a] * point.values[b];
        for (std::size_t i = 0; i < dim; ++i) {
          for (std::size_t j = 0; j < dim; ++j) {
            const double share =
                along_ == Along::normal ? point.normal[i] * point.normal[j] : (i == j ? 1 : 0);
            matrices_[begin + n * (dim * a + i) + dim * b + j] += both * share;
          }
        }
      }
    }
  }
}

PetscErrorCode FoundationTerm::set_time(double time) {
  PetscFunctionBeginUser;
  matrices_.clear();
  const std::string complaint = complaint_of([&] {
    for (const Facet &facet : facets_) add_facet(facet, time);
  });
  PetscCall(
      agree_on_complaint(PetscObjectComm(reinterpret_cast<PetscObject>(mesh_.dm)), complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Calls visit_facet(dofs, matrix, K u) for each facet.
template <class Visit>
void FoundationTerm::visit(const double *u, const Visit &visit_facet) const {
  const double *matrix = matrices_.data();
  for (std::size_t f = 0; f < facets_.size() && !matrices_.empty(); ++f) {
    const std::vector<PetscInt> dofs = dofs_of(facets_[f]);
    std::vector<double> force(dofs.size(), 0);
    for (std::size_t r = 0; r < dofs.size(); ++r) {
      for (std::size_t c = 0; c < dofs.size(); ++c) {
        force[r] += matrix[dofs.size() * r + c] * (u ? u[dofs[c]] : 0);
      }
    }
    visit_facet(dofs, matrix, force);
    matrix += dofs.size() * dofs.size();
  }
}

PetscErrorCode FoundationTerm::add_energy(const double *u, EnergySums *sums) const {
  PetscFunctionBeginUser;
  visit(u, [&](const auto &dofs, const double *, const auto &force) {
    double energy = 0;
    for (std::size_t k = 0; k < dofs.size(); ++k) energy += 0.5 * u[dofs[k]] * force[k];
    sums->energy += energy;
    sums->scale += energy;
  });
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FoundationTerm::add_gradient(const double *u, double *gradient) const {
  PetscFunctionBeginUser;
  visit(u, [&](const auto &dofs, const double *, const auto &force) {
    for (std::size_t k = 0; k < dofs.size(); ++k) gradient[dofs[k]] += force[k];
  });
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FoundationTerm::add_hessian(const double *u, StencilSink &sink) const {
  PetscErrorCode error = PETSC_SUCCESS;
  PetscFunctionBeginUser;
  visit(u, [&](const auto &dofs, const double *matrix, const auto &) {
    const Stencil stencil{.n = static_cast<int>(dofs.size()), .dofs = dofs.data()};
    if (!error) error = sink.add_split(stencil, matrix, nullptr, 0);
  });
  PetscCall(error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
