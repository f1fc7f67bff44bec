#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "contact/contact.hpp"
#include "term/contact_surface.hpp"
#include "term/term.hpp"

namespace trefoil {

/// A half-space without unknowns, that may move without turning.
struct HalfSpaceObstacle {
  std::string name;
  contact::HalfSpace at_rest;
  std::function<contact::Vector3(double time)> displacement;
  double friction = 0;  ///< mu of every body against it
};

/// How an obstacle of a surface moves: displacements of its points, in their order.
using ObstacleMotion = std::function<std::vector<contact::Vector3>(double time)>;

/// The numbers of contact.
struct ContactParameters {
  double distance = 0;  ///< dhat: what is farther apart feels no force
  bool self_contact = true;
  contact::StepLimits limits;  ///< how much of a gap a step may use up
  double slip_velocity = 0;    ///< below which friction sticks, length per time
  FilterWeight weight = FilterWeight::clamp;
  contact::FrictionOfBodies friction;  ///< mu between bodies; null: none anywhere
};

/// The share of friction that may lag before a run says so, or solves again.
constexpr double tolerated_friction_lag = 0.05;

/// What an obstacle exerts on the bodies, friction included.
struct ObstacleForce {
  std::string name;
  contact::Vector3 force;
};

/// What is in contact at a state.
struct ContactReport {
  double energy = 0;                                     ///< of the barriers
  double gap = std::numeric_limits<double>::infinity();  ///< the least one; infinite: >= dhat
  PetscInt64 pairs = 0;                                  ///< nearer than dhat
  double stiffening = 1;                                 ///< times the stiffness that was asked for
  int friction_solves = 0;     ///< of the last step: how often friction got new forces
  double friction_force = 0;   ///< sum of the lengths of the vertices' forces at its end
  double friction_change = 0;  ///< of them, summed alike, if friction had that end's normal forces
  std::vector<ObstacleForce> obstacle_forces{};
};

/// Whose way is looked at: of everything, or only of what is prescribed, obstacles included.
enum class Movers { all, prescribed };

/// How far bodies and obstacles can go from one state to another.
struct AllowedMotion {
  double share = 1;  ///< of the way
  /// What ends it, and where: "edge (3, 4) and edge (8, 9) near (0, 1, 0)". Empty where the share
  /// is only what was searched of a way too long for more.
  std::string what{};
};

/// Contact of bodies with themselves, with each other and with obstacles: barriers of the distances
/// of nearby pairs of primitives, and the lagged friction between them. The surface is the same on
/// every rank, each pair belongs to one of them. All functions that return an error code are
/// collective.
class ContactTerm final : public Term {
 public:
  ContactTerm(std::unique_ptr<ContactSurface> surface, ContactParameters parameters,
              std::vector<HalfSpaceObstacle> planes, std::vector<ObstacleMotion> motions);

  /// The scale is that of the barriers.
  PetscErrorCode add_energy(const double *u, EnergySums *sums) const override;
  /// Of the quadratic model at u: beyond a wall distances are positive again, energies there say
  /// nothing.
  PetscErrorCode add_energy_changes(const double *u, std::size_t size, int directions,
                                    const double *const *d, int points, const double *coefficients,
                                    double *changes) const override;
  PetscErrorCode add_gradient(const double *u, double *gradient) const override;
  [[nodiscard]] HessianKind hessian_kind() const override { return HessianKind::stencils; }
  PetscErrorCode add_hessian(const double *u, StencilSink &sink) const override;
  [[nodiscard]] FilterWeight filter_weight() const override { return parameters_.weight; }

  [[nodiscard]] bool couples_pairs() const override { return has_pairs_; }
  PetscErrorCode choose_pairs(const double *u, bool *changed) override;
  void append_pairs(VertexPairs *pairs) const override;

  PetscErrorCode set_time(double time) override;
  PetscErrorCode begin_step(const StepState &state) override;
  PetscErrorCode accept_step(const double *u) override;
  [[nodiscard]] bool limits_step() const override { return true; }
  PetscErrorCode limit_step(const double *u, const double *d, double first,
                            double *largest) const override;
  [[nodiscard]] double bytes() const override;

  /// The way from a state to another, straight, obstacles included, is free so far.
  PetscErrorCode find_allowed_motion(const double *from, double time_from, const double *to,
                                     double time_to, AllowedMotion *motion,
                                     Movers movers = Movers::all) const;
  /// The first of the surface's intersections at u, of which there are `count`; exact.
  PetscErrorCode find_intersections(const double *u, PetscInt64 *count, std::string *first) const;
  /// The least gap at u: how far, of what is nearer than `reach`, the nearest is apart, and what it
  /// is.
  PetscErrorCode find_gap(const double *u, double reach, double *gap, std::string *pair) const;
  PetscErrorCode report(const double *u, ContactReport *report) const;
  /// Makes u the state from which friction has its forces and directions.
  PetscErrorCode lag_friction(const double *u);
  /// The share of friction that would be other with the normal forces at u. Collective.
  PetscErrorCode find_friction_lag(const double *u, double *lag);
  /// Makes u, at a time, the state that was accepted last, and the stiffness what it was before.
  PetscErrorCode go_on(const double *u, double time, double stiffening);
  /// Of the stiffness, times what was asked for, in the step that ended last.
  [[nodiscard]] double stiffening_of_step() const { return stiffening_of_step_; }
  /// Leaves friction out of energies and of their derivatives.
  void ignore_friction(bool ignored) { ignores_friction_ = ignored; }
  [[nodiscard]] bool has_friction() const;
  /// Whether an obstacle is elsewhere at one time than at another.
  [[nodiscard]] bool moves(double one_time, double another) const;

  /// Shows every state from which a step begins; may be null.
  using Observer = std::function<PetscErrorCode(const double *u)>;
  void observe_iterates(Observer observer) { observer_ = std::move(observer); }

  [[nodiscard]] const ContactSurface &contact_surface() const { return *surface_; }
  [[nodiscard]] const ContactParameters &parameters() const { return parameters_; }
  void set_distance(double distance) { parameters_.distance = law_.distance = distance; }

 private:
  using Positions = std::vector<double>;  ///< 3 numbers a vertex of the surface
  using VertexPair = std::pair<int, int>;

  [[nodiscard]] const contact::Surface &surface() const { return surface_->surface(); }
  [[nodiscard]] contact::PairSearch search(double reach) const;
  [[nodiscard]] contact::HalfSpace plane_at(std::size_t which, double time) const;
  void move_obstacles(double time, Positions *x, bool keep = true) const;
  PetscErrorCode positions(const double *u, Positions *x) const;
  PetscErrorCode positions_at(const double *u, double time, Positions *x) const;
  const std::vector<contact::ContactPair> &candidates_at(const Positions &x) const;
  PetscErrorCode add_forces(const double *u, const Positions &x, Positions *forces) const;
  PetscErrorCode add_friction_forces(const double *u, Positions *forces) const;
  PetscErrorCode find_obstacle_forces(const double *u, std::vector<ObstacleForce> *forces) const;
  PetscErrorCode renew_friction(const double *u);
  PetscErrorCode compare_friction_forces(const Positions &before, const Positions &now);
  /// Takes a 3 x 3 block row by row for each pair of the vertices, some of which may be -1: the
  /// Hessian and its negative part, which is null where there is none.
  using HessianVisitor =
      std::function<void(std::span<const int> vertices, const double *H, const double *N)>;
  PetscErrorCode visit_hessians(const double *u, const Positions &x,
                                const HessianVisitor &visit) const;
  PetscErrorCode slip(const double *u, Positions *v) const;
  [[nodiscard]] contact::Vector3 drift_of(std::size_t plane) const;
  [[nodiscard]] bool rubs() const;
  [[nodiscard]] std::string name_of(const contact::ContactPair &pair) const;
  [[nodiscard]] std::string name_of(int body, std::span<const int> vertices) const;
  [[nodiscard]] std::vector<VertexPair> vertex_pairs(
      std::span<const contact::ContactPair> pairs) const;
  PetscErrorCode share_first(double *value, int place, std::string *what) const;

  std::unique_ptr<ContactSurface> surface_;
  ContactParameters parameters_;
  contact::ContactLaw law_;
  std::vector<HalfSpaceObstacle> planes_;
  std::vector<ObstacleMotion> motions_;
  Observer observer_;
  bool has_pairs_ = true;
  double time_ = 0;
  mutable contact::CandidateList candidates_;
  std::vector<VertexPair> pattern_;  ///< sorted; what H has places for

  // Friction: of the state that was accepted last, and the step since.
  std::vector<contact::FrictionPair> friction_;                     ///< of pairs
  std::vector<std::vector<contact::FrictionPair>> plane_friction_;  ///< of each half-space
  int lags_ = 0, lags_of_step_ = 0;  ///< of friction: in the step under way, and in the last
  double friction_force_ = 0, friction_change_ = 0;  ///< of the last step; see ContactReport
  std::vector<ObstacleForce> obstacle_forces_;       ///< at its end
  Positions origin_;                                 ///< displacements at its begin
  double accepted_time_ = 0;
  double stiffening_of_step_ = 1;  ///< by which friction has its forces
  bool ignores_friction_ = false;
  bool has_scheme_ = false;  ///< of time, which says what the slip's time is
  double slip_time_ = 0;     ///< of the step: a slip over it is a velocity
};

}  // namespace trefoil
