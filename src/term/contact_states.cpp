// What the contact term says of states, and of the way between two of them.

#include <algorithm>
#include <sstream>

#include "support/petsc_compatibility.hpp"
#include "term/contact_term.hpp"

namespace trefoil {

using contact::ContactPair;

namespace {

std::string near(const contact::Vector3 &place) {
  std::ostringstream text;
  text << " near (" << place.x << ", " << place.y << ", " << place.z << ")";
  return text.str();
}

}  // namespace

std::string ContactTerm::name_of(int body, std::span<const int> vertices) const {
  std::ostringstream text;
  const char *const kinds[] = {"", "vertex", "edge", "triangle"};
  text << kinds[vertices.size()] << " (";
  const BodyNumbers *of = nullptr;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const auto number = surface().vertices[static_cast<std::size_t>(vertices[k])].number;
    const BodyNumbers *const file = surface_->file_of(body, number);
    text << (k ? ", " : "") << number + 1 - (file ? file->first_vertex : 0);
    of = of ? of : file;
  }
  text << ")";
  if (of) text << " of " << of->name;
  if (body >= surface_->first_obstacle()) {
    text << " of obstacle '" << surface_->name_of_obstacle(body) << "'";
  }
  return text.str();
}

std::string ContactTerm::name_of(const ContactPair &pair) const {
  const auto vertices = contact::vertices_of(surface(), pair);
  const auto first = static_cast<std::size_t>(contact::points_of_first(pair.kind));
  const auto all = static_cast<std::size_t>(contact::points_of_pair(pair.kind));
  const std::span<const int> whole(vertices.data(), all);
  return name_of(contact::first_of(surface(), pair).body, whole.first(first)) + " and " +
         name_of(contact::second_of(surface(), pair).body, whole.subspan(first));
}

/// Makes the least of all ranks' values everybody's, and what is said of it, which may be nothing.
/// Of equal values that counts which comes first in `place`, the same on any number of ranks.
PetscErrorCode ContactTerm::share_first(double *value, int place, std::string *what) const {
  struct {
    int place, rank;
  } least{std::numeric_limits<int>::max(), surface_->rank()};
  const double mine = *value;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(&mine, value, 1, MPI_DOUBLE, MPI_MIN, surface_->comm()));
  if (mine != *value) what->clear();
  if (!what->empty()) least.place = place;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_2INT, MPI_MINLOC, surface_->comm()));
  int length = static_cast<int>(what->size());
  PetscCallMPI(MPI_Bcast(&length, 1, MPI_INT, least.rank, surface_->comm()));
  what->resize(static_cast<std::size_t>(length));
  PetscCallMPI(MPI_Bcast(what->data(), length, MPI_CHAR, least.rank, surface_->comm()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::find_allowed_motion(const double *from, double time_from,
                                                const double *to, double time_to,
                                                AllowedMotion *motion, Movers movers) const {
  const auto moves = [movers](contact::Role role) {
    return movers == Movers::all || role != contact::Role::free;
  };
  Positions x, step;
  int first = 0;  // vertex of what ends it
  PetscFunctionBeginUser;
  PetscCall(positions_at(from, time_from, &x));
  PetscCall(positions_at(to, time_to, &step));
  for (std::size_t k = 0; k < x.size(); ++k) step[k] -= x[k];
  *motion = {};
  if (has_pairs_) {
    contact::PairSearch wanted = search(law_.distance);
    wanted.prescribed = true;
    auto swept = contact::find_candidates(surface(), x, step, wanted);
    std::erase_if(swept.pairs, [&](const ContactPair &pair) {
      return !moves(contact::first_of(surface(), pair).role) ||
             !moves(contact::second_of(surface(), pair).role);
    });
    const auto allowed =
        contact::allowed_step(surface(), swept.pairs, x, step, parameters_.limits, swept.share);
    motion->share = std::min(swept.share, allowed.step);
    if (allowed.pair >= 0) {
      const ContactPair &pair = swept.pairs[static_cast<std::size_t>(allowed.pair)];
      motion->what = name_of(pair);
      first = contact::vertices_of(surface(), pair)[0];
    }
  }
  std::vector<int> vertices;
  std::copy_if(surface_->own_vertices().begin(), surface_->own_vertices().end(),
               std::back_inserter(vertices), [&](int vertex) {
                 return moves(surface().vertices[static_cast<std::size_t>(vertex)].role);
               });
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const auto allowed = contact::allowed_step(plane_at(k, time_from), plane_at(k, time_to),
                                               vertices, x, step, parameters_.limits);
    if (allowed.step >= motion->share) continue;
    motion->share = allowed.step;
    const int vertex = vertices[static_cast<std::size_t>(allowed.pair)];
    motion->what =
        name_of(0, std::span<const int>(&vertex, 1)) + " and obstacle '" + planes_[k].name + "'";
    first = vertex;
  }
  if (!motion->what.empty()) motion->what += near(contact::point_of(x, first));
  PetscCall(share_first(&motion->share, first, &motion->what));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::find_intersections(const double *u, PetscInt64 *count,
                                               std::string *first) const {
  Positions x;
  double order = 2;  // intersections first, then vertices
  int which = 0;
  PetscFunctionBeginUser;
  PetscCall(positions(u, &x));
  contact::PairSearch wanted = search(0);
  wanted.prescribed = true;
  const auto found = contact::find_intersections(surface(), x, wanted);
  first->clear();
  *count = static_cast<PetscInt64>(found.size());
  if (!found.empty()) {
    const auto &[edge, facet, meeting, place] = found.front();
    const auto &ends = surface().edges[static_cast<std::size_t>(edge)];
    const auto &corners = surface().facets[static_cast<std::size_t>(facet)];
    const auto e = static_cast<std::size_t>(edge), f = static_cast<std::size_t>(facet);
    std::ostringstream text;
    text << name_of(surface().edge_data[e].body, ends) << " and "
         << name_of(surface().facet_data[f].body,
                    std::span<const int>(corners.data(), surface().dim == 2 ? 2 : 3))
         << (meeting == contact::Meeting::touching ? " touch" : "") << near(place);
    *first = text.str();
    order = 0;
    which = edge;
  }
  // Vertices beyond a half-space.
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const contact::HalfSpace plane = plane_at(k, time_);
    for (const int vertex : surface_->own_vertices()) {
      if (plane.gap(contact::point_of(x, vertex)) > 0) continue;
      ++*count;
      if (!first->empty()) continue;
      *first = name_of(0, std::span<const int>(&vertex, 1)) + " lies in obstacle '" +
               planes_[k].name + "'" + near(contact::point_of(x, vertex));
      order = 1;
      which = vertex;
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 1, MPIU_INT64, MPI_SUM, surface_->comm()));
  PetscCall(share_first(&order, which, first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::find_gap(const double *u, double reach, double *gap,
                                     std::string *pair) const {
  Positions x;
  int first = 0;  // vertex of the nearest
  PetscFunctionBeginUser;
  PetscCall(positions(u, &x));
  *gap = std::numeric_limits<double>::infinity();
  pair->clear();
  if (has_pairs_) {
    const auto pairs = contact::find_candidates(surface(), x, search(reach));
    const contact::LeastGap least = contact::least_gap(surface(), pairs, x);
    *gap = least.gap;
    if (least.pair >= 0) {
      const ContactPair &nearest = pairs[static_cast<std::size_t>(least.pair)];
      *pair = name_of(nearest);
      first = contact::vertices_of(surface(), nearest)[0];
    }
  }
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const contact::LeastGap least =
        contact::least_gap(plane_at(k, time_), surface_->own_vertices(), x);
    if (!(least.gap < *gap)) continue;
    *gap = least.gap;
    const int vertex = surface_->own_vertices()[static_cast<std::size_t>(least.pair)];
    *pair =
        name_of(0, std::span<const int>(&vertex, 1)) + " and obstacle '" + planes_[k].name + "'";
    first = vertex;
  }
  PetscCall(share_first(gap, first, pair));
  if (*gap > reach) *gap = std::numeric_limits<double>::infinity();
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool ContactTerm::moves(double one_time, double another) const {
  Positions one(3 * surface().vertices.size(), 0), other = one;
  move_obstacles(one_time, &one);
  move_obstacles(another, &other);
  return one != other || std::any_of(planes_.begin(), planes_.end(), [&](const auto &plane) {
           return contact::norm(plane.displacement(one_time) - plane.displacement(another)) > 0;
         });
}

PetscErrorCode ContactTerm::report(const double *u, ContactReport *report) const {
  Positions x;
  PetscFunctionBeginUser;
  *report = {.stiffening = law_.stiffening,
             .friction_solves = lags_of_step_,
             .friction_force = friction_force_,
             .friction_change = friction_change_,
             .obstacle_forces = obstacle_forces_};
  if (time_ > accepted_time_) PetscCall(find_obstacle_forces(u, &report->obstacle_forces));
  PetscCall(positions(u, &x));
  const auto &candidates = candidates_at(x);
  const auto pairs = contact::pairs_within(surface(), candidates, x, law_.distance);
  double gap = contact::least_gap(surface(), pairs, x).gap;
  double sums[2] = {contact::contact_energy(surface(), law_, pairs, x),
                    static_cast<double>(pairs.size())};
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const contact::HalfSpace plane = plane_at(k, time_);
    const auto &own = surface_->own_vertices();
    gap = std::min(gap, contact::least_gap(plane, own, x).gap);
    sums[0] += contact::half_space_energy(surface(), law_, plane, own, x);
    sums[1] += static_cast<double>(std::count_if(own.begin(), own.end(), [&](int vertex) {
      return plane.gap(contact::point_of(x, vertex)) < law_.distance;
    }));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, surface_->comm()));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &gap, 1, MPI_DOUBLE, MPI_MIN, surface_->comm()));
  report->energy = sums[0];
  report->pairs = static_cast<PetscInt64>(sums[1]);
  if (gap < law_.distance) report->gap = gap;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
