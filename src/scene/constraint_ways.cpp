#include <algorithm>
#include <cmath>

#include "input/expression.hpp"
#include "scene/constraints.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr double rounding = 1e-9;  // of the box's diagonal

}  // namespace

/// Whether a move ends as a rigid one of all components, and as which.
PetscErrorCode Constraints::fit_end(std::size_t which, RigidMotion *motion, bool *is_rigid) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  std::vector<double> from, to;
  PetscMPIInt is_whole = 1;
  double deviation = 0;
  PetscFunctionBeginUser;
  *is_rigid = false;
  const std::string complaint = complaint_of([&] {
    for (const PetscInt v : vertices_[which]) {
      if (!mesh_->owned[static_cast<std::size_t>(v)]) continue;
      std::vector<double> displacement = target(which, v, 1);
      displacement.resize(3, 0);
      for (std::size_t i = 0; i < 3; ++i) {
        is_whole = is_whole && !Expression::is_free(displacement[i]);
        from.push_back(mesh_->coordinates[static_cast<std::size_t>(3 * v) + i]);
        to.push_back(from.back() + displacement[i]);
      }
    }
  });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &is_whole, 1, MPI_INT, MPI_MIN, comm));
  if (!is_whole) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(fit_rigid_motion(comm, from, to, motion, &deviation));
  *is_rigid = deviation <= rounding * box_of(*mesh_).diagonal();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Finds which moves are rigid: those of all components that do not depend on t.
PetscErrorCode Constraints::find_rigid_moves() {
  PetscFunctionBeginUser;
  if (knows_rigid_moves_) PetscFunctionReturn(PETSC_SUCCESS);
  knows_rigid_moves_ = true;
  for (std::size_t which = 0; which < options_.size(); ++which) {
    Move &move = moves_[which];
    if (move.slides || move.formula->uses_time()) continue;
    PetscCall(fit_end(which, &move.motion, &move.is_rigid));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool Constraints::move_in_time() const {
  return std::any_of(moves_.begin(), moves_.end(),
                     [](const Move &move) { return move.formula->uses_time(); });
}

/// Whether a move that depends on t is, somewhere between its ends, far off both ways on which the
/// program would lead it. One that only hurries or lingers is not: t^2 is .25 off t.
PetscErrorCode Constraints::leaves_led_ways(std::size_t which, bool *leaves) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  constexpr int parts = 24;      // as many as a path has steps at the most
  constexpr double alike = 0.3;  // of how far the way leads
  bool is_rigid = false;
  RigidMotion motion;
  double off[3] = {0, 0, 0};  // a way in proportion to t, and a screw; how far the move goes
  PetscFunctionBeginUser;
  PetscCall(fit_end(which, &motion, &is_rigid));
  const auto follow = [&](PetscInt v) {
    const double *place = &mesh_->coordinates[static_cast<std::size_t>(3 * v)];
    const std::vector<double> end = target(which, v, 1);
    for (int part = 1; part < parts; ++part) {
      const double time = static_cast<double>(part) / parts;
      const std::vector<double> here = target(which, v, time);
      const std::array<double, 3> turned = motion.move(place, time);
      for (std::size_t i = 0; i < here.size(); ++i) {
        if (Expression::is_free(here[i]) || Expression::is_free(end[i])) continue;
        off[0] = std::max(off[0], std::abs(here[i] - time * end[i]));
        off[1] = std::max(off[1], std::abs(here[i] - (turned[i] - place[i])));
        off[2] = std::max({off[2], std::abs(here[i]), std::abs(end[i])});
      }
    }
  };
  const std::string complaint = complaint_of([&] {
    for (const PetscInt v : vertices_[which]) follow(v);
  });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, off, 3, MPI_DOUBLE, MPI_MAX, comm));
  const double least = is_rigid ? std::min(off[0], off[1]) : off[0];
  *leaves = least > std::max(alike * off[2], rounding * box_of(*mesh_).diagonal());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Constraints::have_own_way(bool *own) {
  PetscFunctionBeginUser;
  *own = false;
  for (std::size_t which = 0; which < options_.size() && !*own; ++which) {
    if (!moves_[which].formula->uses_time()) continue;
    PetscCall(leaves_led_ways(which, own));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
