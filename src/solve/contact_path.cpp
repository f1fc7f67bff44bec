#include "solve/contact_path.hpp"

#include <sstream>

#include "scene/initial_displacement.hpp"
#include "solve/starting_guess.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

ContactPath::~ContactPath() {
  static_cast<void>(VecDestroy(&unknowns_));  // an error has nowhere to go from here
}

bool ContactPath::exists() const {
  return scene_.contact != nullptr;
}

PetscErrorCode ContactPath::begin() {
  PetscInt64 count = 0;
  std::string first;
  PetscFunctionBeginUser;
  time_ = 0;
  stand_.assign(scene_.mesh.coordinates.size(), 0);
  PetscCall(VecDuplicate(scene_.displacement, &unknowns_));
  PetscCall(VecSet(unknowns_, 0));
  PetscCall(scene_.contact->set_time(0));
  if (scene_.motion) {
    PetscCall(scene_.discretization.copy_local(scene_.displacement, &stand_));
    PetscCall(VecCopy(scene_.displacement, unknowns_));
    PetscCall(scene_.contact->find_intersections(stand_.data(), &count, &first));
    PetscCheck(count == 0, PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm)),
               PETSC_ERR_USER_INPUT,
               "the state at t = 0 intersects itself or an obstacle, first %s; contact needs a "
               "start where all are apart",
               first.c_str());
  }
  PetscCall(scene_.contact->accept_step(stand_.data()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactPath::move_to(double time, std::string *blocked) {
  std::vector<double> u;
  AllowedMotion motion;
  PetscFunctionBeginUser;
  blocked->clear();
  solves_ = 1;
  lagged_.clear();
  PetscCall(scene_.contact->set_time(time));
  PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
  PetscCall(scene_.contact->find_allowed_motion(stand_.data(), time_, u.data(), time, &motion));
  if (motion.share >= 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecCopy(unknowns_, scene_.displacement));
  PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
  PetscCall(scene_.contact->find_allowed_motion(stand_.data(), time_, u.data(), time, &motion));
  if (motion.share >= 1) PetscFunctionReturn(PETSC_SUCCESS);
  if (motion.share > 0) {
    AllowedMotion pushed;
    PetscCall(predict(u, time, 1e-3 * motion.share));
    PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
    PetscCall(scene_.contact->find_allowed_motion(stand_.data(), time_, u.data(), time, &pushed));
    if (pushed.share >= 1) PetscFunctionReturn(PETSC_SUCCESS);
    if (pushed.share > motion.share) motion = pushed;
  }
  std::ostringstream text;
  text << "what is prescribed cannot move so far: " << motion.what << " would meet after "
       << motion.share << " of the way from t = " << time_;
  *blocked = text.str();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Goes to a point of the straight way from the last equilibrium, with all that is prescribed.
PetscErrorCode ContactPath::hold_between(const std::vector<double> &target, double time,
                                         double at) {
  const std::vector<PetscInt> &dofs = scene_.discretization.global_dofs();
  HeldDofs held = nothing_held(scene_.mesh);
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    if (dofs[k] >= 0) continue;
    held.held[k] = 1;
    held.value[k] = at < 1 ? (1 - at) * stand_[k] + at * target[k] : target[k];
  }
  PetscCall(scene_.discretization.set_prescribed(held));
  PetscCall(scene_.functional->set_time(at < 1 ? time_ + at * (time - time_) : time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where what is prescribed pushes through contact, unknowns give way: x += -H^-1 dg/dt, of the
/// clamped H without friction at the last equilibrium. A guess only: the way there is checked.
PetscErrorCode ContactPath::predict(const std::vector<double> &target, double time, double share) {
  const HessianFilter clamp{.weight = 0.5, .floor = {}};
  const Mat H = scene_.hessian;
  Mat negative = nullptr;
  Vec change = nullptr, push = nullptr;
  KSP ksp = nullptr;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  TrefoilSplitStatistics ignored{};
  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(unknowns_, &change));
  PetscCall(VecDuplicate(unknowns_, &push));
  scene_.contact->ignore_friction(true);
  // The gradient's change along the way, by a difference over a small share of it.
  PetscCall(hold_between(target, time, share));
  PetscCall(scene_.functional->gradient(unknowns_, change));
  PetscCall(hold_between(target, time, 0));
  PetscCall(scene_.functional->gradient(unknowns_, push));
  PetscCall(VecAXPY(change, -1, push));
  PetscCall(VecScale(change, 1 / share));
  PetscCall(scene_.functional->hessian(unknowns_, H, &negative, &ignored, clamp));
  if (negative) PetscCall(MatAXPY(H, 1, negative, SAME_NONZERO_PATTERN));
  PetscCall(hold_between(target, time, 1));
  scene_.contact->ignore_friction(false);
  PetscCall(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(H)), &ksp));
  PetscCall(KSPSetOperators(ksp, H, H));
  PetscCall(set_guess_solver(ksp, scene_.linear_solver.kind != SolverKind::direct));
  PetscCall(KSPSolve(ksp, change, push));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  if (reason > 0) PetscCall(VecWAXPY(scene_.displacement, -1, push, unknowns_));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(MatDestroy(&negative));
  PetscCall(VecDestroy(&push));
  PetscCall(VecDestroy(&change));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactPath::repeats(PetscInt iterations, bool *again) {
  constexpr int most = 20;
  const PetscInt wanted = scene_.options.contact.friction_iterations;
  std::vector<double> u;
  PetscFunctionBeginUser;
  *again = scene_.contact->has_friction() &&
           (wanted < 0 ? solves_ < most && (solves_ == 1 || iterations > 1) : solves_ < wanted);
  if (!*again) PetscFunctionReturn(PETSC_SUCCESS);
  ++solves_;
  PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
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
  time_ = time;
  stand_.swap(u);
  lagged_.clear();
  PetscCall(VecCopy(scene_.displacement, unknowns_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ContactPath::save(SavedRun *run) const {
  run->numbers["contact"] = {{"time", time_},
                             {"stiffening", scene_.contact->stiffening_of_step()},
                             {"solves", solves_},
                             {"lags", !lagged_.empty()}};
  run->fields["contact_stand"] = stand_;
  if (!lagged_.empty()) run->fields["contact_lag"] = lagged_;
}

PetscErrorCode ContactPath::go_on(const Checkpoint &checkpoint) {
  double stiffening = 1;
  PetscFunctionBeginUser;
  PetscCall(checkpoint.take([&](const Checkpoint::Json &numbers) {
    time_ = numbers.at("contact").at("time");
    stiffening = numbers.at("contact").at("stiffening");
  }));
  PetscCall(checkpoint.fetch("contact_stand", &stand_));
  PetscCall(VecDuplicate(scene_.displacement, &unknowns_));
  PetscCall(set_unknowns(stand_, scene_.discretization, unknowns_));
  PetscCall(scene_.contact->go_on(stand_.data(), time_, stiffening));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactPath::go_on_in_step(const Checkpoint &checkpoint, double time) {
  bool lags = false;
  PetscFunctionBeginUser;
  PetscCall(checkpoint.take([&](const Checkpoint::Json &numbers) {
    solves_ = numbers.at("contact").at("solves");
    lags = numbers.at("contact").at("lags");
  }));
  PetscCall(scene_.contact->set_time(time));
  if (!lags) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(checkpoint.fetch("contact_lag", &lagged_));
  PetscCall(scene_.contact->lag_friction(lagged_.data()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
