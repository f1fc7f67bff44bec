#include "solve/contact_path.hpp"

#include <sstream>

#include "solve/prescribed_way.hpp"
#include "solve/starting_guess.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

ContactPath::~ContactPath() {
  for (Place *place : {&stand_, &part_}) {
    static_cast<void>(VecDestroy(&place->unknowns));  // an error has nowhere to go from here
  }
}

bool ContactPath::exists() const {
  return scene_.contact != nullptr;
}

PetscErrorCode ContactPath::begin() {
  PetscInt64 count = 0;
  std::string first;
  PetscFunctionBeginUser;
  stand_.time = 0;
  stand_.u.assign(scene_.mesh.coordinates.size(), 0);
  PetscCall(VecDuplicate(scene_.displacement, &stand_.unknowns));
  PetscCall(VecSet(stand_.unknowns, 0));
  PetscCall(scene_.contact->set_time(0));
  if (scene_.motion) {
    PetscCall(scene_.discretization.copy_local(scene_.displacement, &stand_.u));
    PetscCall(VecCopy(scene_.displacement, stand_.unknowns));
    PetscCall(scene_.contact->find_intersections(stand_.u.data(), &count, &first));
    PetscCheck(count == 0, PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm)),
               PETSC_ERR_USER_INPUT,
               "the state at t = 0 intersects itself or an obstacle, first %s; contact needs a "
               "start where all are apart",
               first.c_str());
  }
  PetscCall(scene_.contact->accept_step(stand_.u.data()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

namespace {

std::string sentence_of(const AllowedMotion &motion, double time) {
  const bool meets = !motion.what.empty();
  std::ostringstream text;
  text << "the way from t = " << time
       << (meets ? " is not free: after " : " is too long to search for what may meet: ")
       << motion.share << " of it "
       << (meets ? motion.what + " would come too near to each other" : "was searched");
  return text.str();
}

}  // namespace

PetscErrorCode ContactPath::move_to(double time, Attempt *attempt) {
  std::vector<double> u;
  AllowedMotion motion;
  PetscFunctionBeginUser;
  attempt->reason.clear();
  solves_ = 1;
  lagged_.clear();
  PetscCall(scene_.contact->set_time(time));
  PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
  PetscCall(
      scene_.contact->find_allowed_motion(stand_.u.data(), stand_.time, u.data(), time, &motion));
  if (motion.share >= 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(find_way(stand_, time, &motion));
  if (motion.share >= 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(find_meeting_of_prescribed(scene_, stand_.u, stand_.time, time, &attempt->reason));
  attempt->is_hopeless = !attempt->reason.empty();
  if (!attempt->is_hopeless) attempt->reason = sentence_of(motion, stand_.time);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// How far one can go from a place to the prescribed values of a time, with the unknowns where they
/// are there or, if that leads farther, where they are pushed. Leaves them at the end of that way.
PetscErrorCode ContactPath::find_way(const Place &from, double time, AllowedMotion *motion) {
  AllowedMotion pushed;
  std::vector<double> u;
  const auto look = [&](AllowedMotion *allowed) {
    PetscFunctionBeginUser;
    PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
    PetscCall(
        scene_.contact->find_allowed_motion(from.u.data(), from.time, u.data(), time, allowed));
    PetscFunctionReturn(PETSC_SUCCESS);
  };
  PetscFunctionBeginUser;
  PetscCall(VecCopy(from.unknowns, scene_.displacement));
  PetscCall(look(motion));
  if (motion->share >= 1 || motion->share <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(predict(from, u, time, 1e-3 * motion->share));
  PetscCall(look(&pushed));
  if (pushed.share > motion->share) {
    *motion = pushed;
  } else {
    PetscCall(VecCopy(from.unknowns, scene_.displacement));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactPath::begin_step(double time) {
  PetscFunctionBeginUser;
  solves_ = 1;
  lagged_.clear();
  parts_ = 0;
  end_.time = time;
  PetscCall(scene_.discretization.copy_local(scene_.displacement, &end_.u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactPath::move_on(bool *arrived, Attempt *attempt) {
  constexpr int most_parts = 50;
  const Place &from = parts_ == 0 ? stand_ : part_;
  const double here = from.time;
  AllowedMotion motion;
  bool moved = false;
  PetscFunctionBeginUser;
  attempt->reason.clear();
  if (parts_ > 0) {
    PetscCall(scene_.discretization.copy_local(scene_.displacement, &part_.u));
    PetscCall(VecCopy(scene_.displacement, part_.unknowns));
    PetscCall(hold_between(part_, end_.u, end_.time, 1));
  }
  PetscCall(find_way(from, end_.time, &motion));
  *arrived = motion.share >= 1;
  if (*arrived) PetscFunctionReturn(PETSC_SUCCESS);
  if (parts_ == 0) {
    PetscCall(find_meeting_of_prescribed(scene_, stand_.u, here, end_.time, &attempt->reason));
    attempt->is_hopeless = !attempt->reason.empty();
    if (attempt->is_hopeless) PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (parts_ < most_parts) PetscCall(go_part(motion.share, &moved));
  if (moved) PetscFunctionReturn(PETSC_SUCCESS);
  const double reached = here + motion.share * (end_.time - here);
  attempt->reason =
      sentence_of({(reached - stand_.time) / (end_.time - stand_.time), motion.what}, stand_.time);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Goes a share of the way, or less: obstacles may not go straight.
PetscErrorCode ContactPath::go_part(double share, bool *moved) {
  constexpr int most_tries = 4;
  const Place from = parts_ == 0 ? stand_ : part_;
  Vec change = nullptr;
  std::vector<double> u;
  PetscFunctionBeginUser;
  if (!part_.unknowns) PetscCall(VecDuplicate(stand_.unknowns, &part_.unknowns));
  PetscCall(VecDuplicate(stand_.unknowns, &change));
  PetscCall(VecWAXPY(change, -1, from.unknowns, scene_.displacement));
  *moved = false;
  for (int k = 0; k < most_tries && share > 0 && !*moved; ++k, share /= 2) {
    AllowedMotion motion;
    const double time = from.time + share * (end_.time - from.time);
    PetscCall(hold_between(from, end_.u, end_.time, share));
    PetscCall(VecWAXPY(scene_.displacement, share, change, from.unknowns));
    PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
    PetscCall(
        scene_.contact->find_allowed_motion(from.u.data(), from.time, u.data(), time, &motion));
    *moved = motion.share >= 1;
    part_.time = time;
  }
  PetscCall(VecDestroy(&change));
  ++parts_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Goes to a point of the straight way from a place, with all that is prescribed.
PetscErrorCode ContactPath::hold_between(const Place &from, const std::vector<double> &target,
                                         double time, double at) {
  const std::vector<PetscInt> &dofs = scene_.discretization.global_dofs();
  HeldDofs held = nothing_held(scene_.mesh);
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    if (dofs[k] >= 0) continue;
    held.held[k] = 1;
    held.value[k] = at < 1 ? (1 - at) * from.u[k] + at * target[k] : target[k];
  }
  PetscCall(scene_.discretization.set_prescribed(held));
  PetscCall(scene_.functional->set_time(at < 1 ? from.time + at * (time - from.time) : time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where what is prescribed pushes through contact, unknowns give way: x += -H^-1 dg/dt, of the
/// clamped H without friction at the last equilibrium. A guess only: the way there is checked.
PetscErrorCode ContactPath::predict(const Place &from, const std::vector<double> &target,
                                    double time, double share) {
  const HessianFilter clamp{.weight = 0.5, .floor = {}};
  const Mat H = scene_.hessian;
  Mat negative = nullptr;
  Vec change = nullptr, push = nullptr;
  KSP ksp = nullptr;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  TrefoilSplitStatistics ignored{};
  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(from.unknowns, &change));
  PetscCall(VecDuplicate(from.unknowns, &push));
  scene_.contact->ignore_friction(true);
  // The gradient's change along the way, by a difference over a small share of it.
  PetscCall(hold_between(from, target, time, share));
  PetscCall(scene_.functional->gradient(from.unknowns, change));
  PetscCall(hold_between(from, target, time, 0));
  PetscCall(scene_.functional->gradient(from.unknowns, push));
  PetscCall(VecAXPY(change, -1, push));
  PetscCall(VecScale(change, 1 / share));
  PetscCall(scene_.functional->hessian(from.unknowns, H, &negative, &ignored, clamp));
  if (negative) PetscCall(MatAXPY(H, 1, negative, SAME_NONZERO_PATTERN));
  PetscCall(hold_between(from, target, time, 1));
  scene_.contact->ignore_friction(false);
  PetscCall(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(H)), &ksp));
  PetscCall(KSPSetOperators(ksp, H, H));
  PetscCall(set_guess_solver(ksp, scene_.linear_solver.kind != SolverKind::direct));
  PetscCall(KSPSolve(ksp, change, push));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  if (reason > 0) PetscCall(VecWAXPY(scene_.displacement, -1, push, from.unknowns));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(MatDestroy(&negative));
  PetscCall(VecDestroy(&push));
  PetscCall(VecDestroy(&change));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactPath::repeats(PetscInt iterations, bool *again) {
  const PetscInt wanted = scene_.options.contact.friction_iterations;
  // In time the next step has the forces of this one.
  const PetscInt most = wanted < 0 ? 20 : wanted > 0 ? wanted : scene_.motion ? 1 : 5;
  double lag = 0;
  std::vector<double> u;
  PetscFunctionBeginUser;
  *again = scene_.contact->has_friction() && solves_ < most &&
           (wanted > 0 || solves_ == 1 || iterations > 1);
  if (*again) PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
  if (*again && wanted == 0) {
    PetscCall(scene_.contact->find_friction_lag(u.data(), &lag));
    *again = lag > tolerated_friction_lag;
  }
  if (!*again) PetscFunctionReturn(PETSC_SUCCESS);
  ++solves_;
  PetscCall(scene_.contact->lag_friction(u.data()));
  lagged_.swap(u);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactPath::accept(double time, std::string *broken) {
  PetscInt64 count = 0;
  std::vector<double> u;
  PetscFunctionBeginUser;
  PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
  PetscCall(scene_.contact->find_intersections(u.data(), &count, broken));
  if (count > 0) {
    *broken = "surfaces have passed through each other, " + *broken;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  broken->clear();
  stand_.time = time;
  stand_.u.swap(u);
  lagged_.clear();
  PetscCall(VecCopy(scene_.displacement, stand_.unknowns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
