#pragma once

#include <memory>
#include <string>
#include <vector>

#include "assembly/discretization.hpp"
#include "input/selection.hpp"
#include "output/run_report.hpp"
#include "scene/rigid_motion.hpp"
#include "scene/scene_options.hpp"
#include "scene/support.hpp"

namespace trefoil {

/// What the constraints of a scene take, chosen once, and where it goes as time passes.
class Constraints {
 public:
  /// Chooses the vertices at their rest positions. Collective; `mesh` must outlive this. Errors,
  /// one sentence on all ranks: a malformed formula, a choice that catches no vertex or depends on
  /// t.
  PetscErrorCode choose(const Mesh &mesh, const SceneOptions &options);

  /// What is held at a time, and where. A move that does not depend on t is what it says at t = 1;
  /// on the way there one that is rigid turns as a screw, and any other grows in proportion to t.
  /// In a scene in time it is what it says at all times. Collective. Errors: a malformed formula,
  /// constraints that disagree on a vertex.
  PetscErrorCode hold(double time, HeldDofs *held);

  /// Adds a warning for each constraint that does not begin where the body rests, for scenes in
  /// time. Collective.
  PetscErrorCode warn_of_jumps();
  /// Whether any move depends on t.
  [[nodiscard]] bool move_in_time() const;
  /// Whether a move that depends on t goes quite another way than the program would lead it to
  /// where it ends: not about in proportion to t nor, where that is rigid, as a screw. Collective.
  PetscErrorCode have_own_way(bool *own);

  /// Counts and areas; the reactions are not known here.
  [[nodiscard]] const std::vector<ConstraintReport> &reports() const { return reports_; }
  /// Sentences about choices that the tolerance would change.
  [[nodiscard]] const std::vector<std::string> &warnings() const { return warnings_; }
  /// Which constraint holds each local dof, in hold(); -1: none.
  [[nodiscard]] const std::vector<int> &holder() const { return holder_; }

 private:
  /// What is known of a constraint's move.
  struct Move {
    std::unique_ptr<Expression> formula;  ///< of the displacement, or the normal of planes
    bool slides = false;
    bool is_rigid = false;
    RigidMotion motion;
  };

  [[nodiscard]] std::vector<double> target(std::size_t which, PetscInt vertex, double time) const;
  PetscErrorCode find_rigid_moves();
  PetscErrorCode fit_end(std::size_t which, RigidMotion *motion, bool *is_rigid);
  PetscErrorCode leaves_led_ways(std::size_t which, bool *leaves);
  void hold_one(std::size_t which, double time, HeldDofs *held);
  void turn_one(std::size_t which, HeldDofs *held);
  [[nodiscard]] std::array<double, 3> normal(std::size_t which, PetscInt vertex) const;

  const Mesh *mesh_ = nullptr;
  std::vector<ConstraintOptions> options_;
  std::vector<std::vector<PetscInt>> vertices_;  ///< local ones of each, ghosts included
  std::vector<Move> moves_;
  bool is_in_time_ = false, knows_rigid_moves_ = false;
  std::vector<ConstraintReport> reports_;
  std::vector<std::string> warnings_;
  std::vector<int> holder_;
};

/// Refuses constraints that leave a rigid-body mode of the body, or of one of its connected parts,
/// free: the Hessian would be singular. Collective.
/// @param supports what else holds it, this rank's
/// @param meets whether the scene has contact, which holds nothing before it touches
PetscErrorCode check_rigid_body_modes(const Mesh &mesh, const HeldDofs &held,
                                      const std::vector<Support> &supports, bool meets);

}  // namespace trefoil
