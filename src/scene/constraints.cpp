#include "scene/constraints.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "input/expression.hpp"
#include "scene/vertex_axes.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

std::string disagreement(const Mesh &mesh, PetscInt v, const std::string &one,
                         const std::string &other, int component) {
  std::ostringstream text;
  const double *p = &mesh.coordinates[static_cast<std::size_t>(3 * v)];
  text << "constraints '" << one << "' and '" << other << "' move the vertex at rest position ("
       << p[0] << ", " << p[1] << ", " << p[2] << ") differently in "
       << "xyz"[component];
  return text.str();
}

}  // namespace

PetscErrorCode Constraints::choose(const Mesh &mesh, const SceneOptions &options) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  mesh_ = &mesh;
  options_ = options.constraints;
  is_in_time_ = options.time.is_on;
  for (const ConstraintOptions &constraint : options_) {
    const Choice choice{constraint.where, constraint.group, "-constraint_" + constraint.name,
                        options.where_tolerance * box_of(mesh).diagonal()};
    ConstraintReport report{constraint.name, 0, 0, {}};
    ChosenVertices chosen;
    PetscInt64 nearly = 0;
    bool moves = false;
    PetscCall(depends_on_time(mesh, choice, &moves));
    PetscCheck(!moves, comm, PETSC_ERR_USER_INPUT,
               "%s_where: '%s' would hold other vertices at one time than at another; let only "
               "their displacements depend on t",
               choice.option.c_str(), choice.where.c_str());
    PetscCall(choose_vertices(mesh, choice, 0, &chosen));
    PetscCall(count_vertices(mesh, chosen.taken, &report.vertices));
    PetscCall(count_vertices(mesh, chosen.nearly, &nearly));
    PetscCheck(report.vertices > 0, comm, PETSC_ERR_USER_INPUT,
               "constraint '%s' catches no vertex: %s, and the mesh spans "
               "[%g, %g] x [%g, %g] x [%g, %g]",
               constraint.name.c_str(), choice.text().c_str(), mesh.box_min[0], mesh.box_max[0],
               mesh.box_min[1], mesh.box_max[1], mesh.box_min[2], mesh.box_max[2]);
    PetscCall(area_between(mesh, chosen, &report.area));
    if (nearly > 0) warnings_.push_back(warn_of_rest(choice, nearly, "vertices"));
    reports_.push_back(report);
    std::vector<PetscInt> vertices;
    for (std::size_t v = 0; v < chosen.taken.size(); ++v) {
      if (chosen.taken[v]) vertices.push_back(static_cast<PetscInt>(v));
    }
    vertices_.push_back(std::move(vertices));
    const std::string complaint = complaint_of([&] {
      const std::string zero = mesh.dimension() == 2 ? "0, 0" : "0, 0, 0";
      const bool slides = !constraint.slide.empty();
      const std::string formula = slides                    ? constraint.slide
                                  : constraint.move.empty() ? zero
                                                            : constraint.move;
      moves_.push_back({std::make_unique<Expression>(
                            formula, choice.option + (slides ? "_slide" : "_move"), box_of(mesh)),
                        slides,
                        false,
                        {}});
      if (slides && moves_.back().formula->uses_time()) {
        throw InputError(choice.option + "_slide must not depend on t");
      }
    });
    PetscCall(agree_on_complaint(comm, complaint));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The displacement of a vertex; may have components that are free. Throws InputError.
std::vector<double> Constraints::target(std::size_t which, PetscInt vertex, double time) const {
  const Move &move = moves_[which];
  const double *place = &mesh_->coordinates[static_cast<std::size_t>(3 * vertex)];
  const auto dimension = static_cast<std::size_t>(mesh_->dimension());
  if (move.is_rigid && time < 1) {
    const std::array<double, 3> moved = move.motion.move(place, time);
    std::vector<double> displacement;
    for (std::size_t i = 0; i < dimension; ++i) displacement.push_back(moved[i] - place[i]);
    return displacement;
  }
  std::vector<double> displacement = move.formula->evaluate(place, time, dimension);
  if (is_in_time_ || move.formula->uses_time() || time == 1) return displacement;
  for (double &value : displacement) {
    if (!Expression::is_free(value)) value *= time;
  }
  return displacement;
}

/// Throws InputError.
void Constraints::hold_one(std::size_t which, double time, HeldDofs *held) {
  const double tolerance = 1e-12 * box_of(*mesh_).diagonal();
  for (const PetscInt v : vertices_[which]) {
    const std::vector<double> displacement = target(which, v, time);
    for (int i = 0; i < mesh_->dimension(); ++i) {
      const auto dof = static_cast<std::size_t>(3 * v + i);
      const double value = displacement[static_cast<std::size_t>(i)];
      if (Expression::is_free(value)) continue;
      if (held->held[dof] && std::abs(held->value[dof] - value) > tolerance) {
        const auto &other = options_[static_cast<std::size_t>(holder_[dof])];
        throw InputError(disagreement(*mesh_, v, other.name, options_[which].name, i));
      }
      if (held->held[dof]) continue;
      held->held[dof] = 1;
      held->value[dof] = value;
      holder_[dof] = static_cast<int>(which);
    }
  }
}

/// The normal of the plane in which a vertex slides, of length one. Throws InputError.
std::array<double, 3> Constraints::normal(std::size_t which, PetscInt vertex) const {
  const auto dimension = static_cast<std::size_t>(mesh_->dimension());
  const std::vector<double> given = moves_[which].formula->evaluate(
      &mesh_->coordinates[static_cast<std::size_t>(3 * vertex)], 1, dimension);
  std::array<double, 3> normal{};
  std::copy(given.begin(), given.end(), normal.begin());
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  if (std::any_of(given.begin(), given.end(), Expression::is_free) || length == 0) {
    throw InputError("-constraint_" + options_[which].name +
                     "_slide must be the normal of a plane, which has a length");
  }
  for (double &component : normal) {
    component /= length;
    // What is parallel to an axis but for rounding holds a component, which is simpler.
    constexpr double rounding = 1e-14;
    if (std::abs(component) < rounding) component = 0;
  }
  return normal;
}

/// Lets vertices slide in planes. Throws InputError.
void Constraints::turn_one(std::size_t which, HeldDofs *held) {
  std::vector<int> place(static_cast<std::size_t>(mesh_->local_vertices()), -1);
  for (std::size_t k = 0; k < held->turned.size(); ++k) {
    place[static_cast<std::size_t>(held->turned[k].vertex)] = static_cast<int>(k);
  }
  for (const PetscInt v : vertices_[which]) {
    const std::array<double, 3> direction = normal(which, v);
    int &at = place[static_cast<std::size_t>(v)];
    if (at < 0) {
      at = static_cast<int>(held->turned.size());
      held->turned.push_back(begin_turned(*held, v, holder_));
    }
    TurnedVertex *turned = &held->turned[static_cast<std::size_t>(at)];
    const Direction kind = add_direction(direction, 0, static_cast<int>(which), turned);
    if (kind == Direction::another || kind == Direction::known) continue;
    const double *p = &mesh_->coordinates[static_cast<std::size_t>(3 * v)];
    std::ostringstream text;
    text << "constraint '" << options_[which].name << "' lets the vertex at rest position (" << p[0]
         << ", " << p[1] << ", " << p[2] << ") slide in a plane that "
         << (kind == Direction::contradicts
                 ? "another constraint moves it out of"
                 : "is nearly, not quite, that of another constraint, and so holds it along both; "
                   "give both the same normal");
    throw InputError(text.str());
  }
}

PetscErrorCode Constraints::warn_of_jumps() {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  PetscFunctionBeginUser;
  for (std::size_t which = 0; which < options_.size(); ++which) {
    double largest = 0;
    const std::string complaint = complaint_of([&] {
      for (const PetscInt v : vertices_[which]) {
        for (const double value : target(which, v, 0)) {
          if (!Expression::is_free(value)) largest = std::max(largest, std::abs(value));
        }
      }
    });
    PetscCall(agree_on_complaint(comm, complaint));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm));
    if (largest == 0) continue;
    std::ostringstream text;
    text << "constraint '" << options_[which].name
         << "' has moved its vertices at t = 0 already, by "
         << "up to " << largest << ": they jump there; let -constraint_" << options_[which].name
         << "_move begin at 0, in t";
    warnings_.push_back(text.str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Constraints::hold(double time, HeldDofs *held) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  PetscFunctionBeginUser;
  if (time < 1 && !is_in_time_) PetscCall(find_rigid_moves());
  *held = nothing_held(*mesh_);
  holder_.assign(mesh_->coordinates.size(), -1);
  for (std::size_t which = 0; which < options_.size(); ++which) {
    if (moves_[which].slides) continue;
    const std::string complaint = complaint_of([&] { hold_one(which, time, held); });
    PetscCall(agree_on_complaint(comm, complaint));
  }
  for (std::size_t which = 0; which < options_.size(); ++which) {
    if (!moves_[which].slides) continue;
    const std::string complaint = complaint_of([&] { turn_one(which, held); });
    PetscCall(agree_on_complaint(comm, complaint));
  }
  settle_turned(mesh_->dimension(), held, &holder_);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
