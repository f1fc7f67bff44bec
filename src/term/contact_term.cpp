#include "term/contact_term.hpp"

#include <algorithm>
#include <cmath>

#include "support/log_events.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

using contact::ContactPair;
using contact::FrictionPair;
using contact::Vector3;

namespace {

/// Searches for pairs, as an event of -log_view.
template <class Search>
void log_pairs(const Search &search) {
  static_cast<void>(PetscLogEventBegin(event_pairs, nullptr, nullptr, nullptr, nullptr));
  search();
  static_cast<void>(PetscLogEventEnd(event_pairs, nullptr, nullptr, nullptr, nullptr));
}

}  // namespace

ContactTerm::ContactTerm(std::unique_ptr<ContactSurface> surface, ContactParameters parameters,
                         std::vector<HalfSpaceObstacle> planes, std::vector<ObstacleMotion> motions)
    : surface_(std::move(surface)),
      parameters_(std::move(parameters)),
      law_{.distance = parameters_.distance},
      planes_(std::move(planes)),
      motions_(std::move(motions)),
      plane_friction_(planes_.size()) {
  has_pairs_ = parameters_.self_contact || surface_->first_obstacle() > 1 || !motions_.empty();
  origin_.assign(3 * this->surface().vertices.size(), 0);
}

contact::PairSearch ContactTerm::search(double reach) const {
  return {.reach = reach, .self_contact = parameters_.self_contact, .rank = surface_->rank()};
}

contact::HalfSpace ContactTerm::plane_at(std::size_t which, double time) const {
  contact::HalfSpace plane = planes_[which].at_rest;
  plane.offset += contact::dot(plane.normal, planes_[which].displacement(time));
  return plane;
}

/// Adds the obstacles' displacements to their vertices.
void ContactTerm::move_obstacles(double time, Positions *x, bool keep) const {
  const double sign = keep ? 1 : -1;
  for (std::size_t k = 0; k < motions_.size(); ++k) {
    const std::vector<Vector3> moved = motions_[k](time);
    auto at = static_cast<std::size_t>(3 * surface_->obstacle_begin()[k]);
    for (const Vector3 &displacement : moved) {
      for (int i = 0; i < 3; ++i) (*x)[at++] += sign * displacement[i];
    }
  }
}

PetscErrorCode ContactTerm::positions_at(const double *u, double time, Positions *x) const {
  PetscFunctionBeginUser;
  PetscCall(surface_->gather(u, x));
  std::size_t k = 0;
  for (const contact::SurfaceVertex &vertex : surface().vertices) {
    for (int i = 0; i < 3; ++i) (*x)[k++] += vertex.rest[i];
  }
  move_obstacles(time, x);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::positions(const double *u, Positions *x) const {
  PetscFunctionBeginUser;
  PetscCall(positions_at(u, time_, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// This rank's pairs that may be nearer than dhat.
const std::vector<ContactPair> &ContactTerm::candidates_at(const Positions &x) const {
  if (has_pairs_ && !candidates_.covers(x)) {
    log_pairs([&] { candidates_.find(surface(), x, search(law_.distance)); });
  }
  return candidates_.pairs();
}

PetscErrorCode ContactTerm::add_energy(const double *u, EnergySums *sums) const {
  Positions x, v;
  PetscFunctionBeginUser;
  PetscCall(positions(u, &x));
  double energy = contact::contact_energy(surface(), law_, candidates_at(x), x);
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    energy += contact::half_space_energy(surface(), law_, plane_at(k, time_),
                                         surface_->own_vertices(), x);
  }
  sums->energy += energy;
  sums->scale += energy;
  if (!rubs()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(slip(u, &v));
  const double e = parameters_.slip_velocity * slip_time_;
  sums->energy += contact::friction_energy(friction_, v, e);
  for (const auto &pairs : plane_friction_) {
    sums->energy += contact::friction_energy(pairs, v, e);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Derivatives of the energy by the positions of the surface's vertices, of this rank's pairs.
PetscErrorCode ContactTerm::add_forces(const double *u, const Positions &x,
                                       Positions *forces) const {
  PetscFunctionBeginUser;
  contact::add_contact_gradient(surface(), law_, candidates_at(x), x, *forces);
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    contact::add_half_space_gradient(surface(), law_, plane_at(k, time_), surface_->own_vertices(),
                                     x, *forces);
  }
  PetscCall(add_friction_forces(u, forces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Hessians of this rank's pairs, one after the other.
PetscErrorCode ContactTerm::visit_hessians(const double *u, const Positions &x,
                                           const HessianVisitor &visit) const {
  Positions v;
  PetscFunctionBeginUser;
  contact::contact_hessians(surface(), law_, candidates_at(x), x, [&](const auto &pair) {
    visit(pair.vertices, pair.H.data(), pair.N.data());
  });
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const contact::HalfSpace plane = plane_at(k, time_);
    const Vector3 &n = plane.normal;
    contact::half_space_hessians(surface(), law_, plane, surface_->own_vertices(), x,
                                 [&](int vertex, double curvature) {
                                   double H[9];
                                   for (int i = 0; i < 9; ++i)
                                     H[i] = curvature * n[i / 3] * n[i % 3];
                                   visit(std::span(&vertex, 1), H, nullptr);
                                 });
  }
  if (!rubs()) PetscFunctionReturn(PETSC_SUCCESS);
  const double e = parameters_.slip_velocity * slip_time_;
  const auto take = [&](const auto &pair) { visit(pair.vertices, pair.H.data(), nullptr); };
  PetscCall(slip(u, &v));
  contact::friction_hessians(friction_, v, e, take);
  for (const auto &pairs : plane_friction_) contact::friction_hessians(pairs, v, e, take);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::add_gradient(const double *u, double *gradient) const {
  Positions x, forces(3 * surface().vertices.size(), 0);
  PetscFunctionBeginUser;
  PetscCall(positions(u, &x));
  PetscCall(add_forces(u, x, &forces));
  PetscCall(surface_->add_at_owners(forces, gradient));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::add_hessian(const double *u, StencilSink &sink) const {
  Positions x;
  PetscErrorCode error = PETSC_SUCCESS;
  PetscFunctionBeginUser;
  PetscCall(positions(u, &x));
  PetscCall(
      visit_hessians(u, x, [&](std::span<const int> vertices, const double *H, const double *N) {
        std::array<PetscInt, 12> dofs;
        dofs.fill(-1);
        for (std::size_t a = 0; a < vertices.size(); ++a) {
          if (vertices[a] >= 0) {
            std::copy_n(surface_->dofs(vertices[a]).begin(), 3, dofs.begin() + 3 * a);
          }
        }
        const int n = static_cast<int>(3 * vertices.size());
        const bool is_split =
            N && std::any_of(N, N + n * n, [](double entry) { return entry != 0; });
        if (!error)
          error = sink.add_split({.n = n, .dofs = dofs.data(), .global = true}, H, N, is_split);
      }));
  PetscCall(error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Pairs of vertices that have unknowns, sorted.
std::vector<ContactTerm::VertexPair> ContactTerm::vertex_pairs(
    std::span<const ContactPair> pairs) const {
  std::vector<VertexPair> result;
  const auto append = [&](const std::array<int, 4> &vertices) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = a + 1; b < 4; ++b) {
        if (vertices[a] < 0 || vertices[b] < 0) continue;
        if (surface_->global_vertex(vertices[a]) < 0) continue;
        if (surface_->global_vertex(vertices[b]) < 0) continue;
        result.push_back(std::minmax(vertices[a], vertices[b]));
      }
    }
  };
  for (const ContactPair &pair : pairs) append(contact::vertices_of(surface(), pair));
  for (const FrictionPair &pair : friction_) append(pair.vertices);
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

/// Places for more than is needed now, a skin, so that they serve for a while.
PetscErrorCode ContactTerm::choose_pairs(const double *u, bool *changed) {
  constexpr double skin = 2;
  Positions x;
  std::vector<ContactPair> near;
  PetscFunctionBeginUser;
  PetscCall(positions(u, &x));
  const auto needed =
      vertex_pairs(contact::pairs_within(surface(), candidates_at(x), x, law_.distance));
  PetscMPIInt missing =
      !std::includes(pattern_.begin(), pattern_.end(), needed.begin(), needed.end());
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &missing, 1, MPI_INT, MPI_MAX, surface_->comm()));
  *changed = missing != 0;
  if (!*changed) PetscFunctionReturn(PETSC_SUCCESS);
  log_pairs([&] { near = contact::find_candidates(surface(), x, search(skin * law_.distance)); });
  pattern_ = vertex_pairs(near);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ContactTerm::append_pairs(VertexPairs *pairs) const {
  for (const auto &[a, b] : pattern_) {
    pairs->first.push_back(surface_->global_vertex(a));
    pairs->second.push_back(surface_->global_vertex(b));
  }
}

PetscErrorCode ContactTerm::limit_step(const double *u, const double *d, double first,
                                       double *largest) const {
  Positions x, step;
  PetscFunctionBeginUser;
  if (observer_) PetscCall(observer_(u));
  PetscCall(positions(u, &x));
  PetscCall(surface_->gather(d, &step));
  for (double &s : step) s *= first;
  double share = 1;
  if (has_pairs_) {
    log_pairs([&] { candidates_.find(surface(), x, step, search(law_.distance)); });
    share = contact::allowed_step(surface(), candidates_.pairs(), x, step, parameters_.limits,
                                  candidates_.share())
                .step;
    share = std::min(share, candidates_.share());
  }
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const contact::HalfSpace plane = plane_at(k, time_);
    share = std::min(share, contact::allowed_step(plane, plane, surface_->own_vertices(), x, step,
                                                  parameters_.limits)
                                .step);
  }
  *largest = std::min(*largest, share * first);
  PetscFunctionReturn(PETSC_SUCCESS);
}

double ContactTerm::bytes() const {
  return surface_->bytes() + candidates_.bytes() +
         static_cast<double>(pattern_.capacity() * sizeof(VertexPair) +
                             friction_.capacity() * sizeof(FrictionPair));
}

}  // namespace trefoil
