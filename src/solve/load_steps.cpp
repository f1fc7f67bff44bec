#include "solve/load_steps.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {

LoadPath::~LoadPath() {
  for (Vec *vector : {&stand_, &spread_, &spread_of_stand_}) {
    static_cast<void>(VecDestroy(vector));  // an error has nowhere to go from here
  }
}

PetscErrorCode LoadPath::changes(double first, double last, bool *any) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm));
  HeldDofs held_first, held_last;
  std::vector<double> first_forces, last_forces;
  PetscMPIInt changes = 0;
  PetscFunctionBeginUser;
  PetscCall(scene_.constraints.hold(first, &held_first));
  PetscCall(scene_.constraints.hold(last, &held_last));
  if (scene_.loads.any()) {
    PetscCall(scene_.loads.forces(first, &first_forces));
    PetscCall(scene_.loads.forces(last, &last_forces));
  }
  changes = scene_.loads.any_follows() || held_first.value != held_last.value ||
            first_forces != last_forces || (scene_.contact && scene_.contact->moves(first, last));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changes, 1, MPI_INT, MPI_MAX, comm));
  *any = changes != 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadPath::check(double first, double last) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm));
  bool any = false;
  PetscFunctionBeginUser;
  PetscCall(changes(first, last, &any));
  PetscCheck(any, comm, PETSC_ERR_USER_INPUT,
             "-load_steps %s would repeat one solve: nothing is moved or loaded, or all that is "
             "stays the same from t = 0 to 1",
             scene_.options.load_steps.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadPath::set_time(double time) {
  HeldDofs held;
  PetscFunctionBeginUser;
  time_ = time;
  PetscCall(scene_.constraints.hold(time, &held));
  PetscCall(scene_.discretization.set_prescribed(held));
  PetscCall(scene_.functional->set_time(time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// x += h(t) - h(t before), h the harmonic extension of the prescribed displacements.
PetscErrorCode LoadPath::follow(GuessCost *cost) {
  GuessCost spent;
  PetscFunctionBeginUser;
  if (!spread_) PetscCall(VecDuplicate(scene_.displacement, &spread_));
  PetscCall(VecSet(spread_, 0));
  PetscCall(spread_displacements(
      *scene_.functional, scene_.discretization, scene_.matrix_of_cells(), 0,
      scene_.linear_solver.kind != SolverKind::direct, scene_.progress, spread_, &spent));
  if (stand_) {
    PetscCall(VecAXPY(scene_.displacement, 1, spread_));
    PetscCall(VecAXPY(scene_.displacement, -1, spread_of_stand_));
  }
  cost->linear_solves += spent.linear_solves;
  cost->seconds += spent.seconds;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadPath::go_to(double time, GuessCost *cost) {
  PetscFunctionBeginUser;
  PetscCall(set_time(time));
  if (scene_.options.initial != "rest") PetscCall(follow(cost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadPath::follow_to(double time, GuessCost *cost) {
  PetscFunctionBeginUser;
  PetscCall(set_time(time));
  PetscCall(follow(cost));
  if (!stand_) PetscCall(VecCopy(spread_, scene_.displacement));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadPath::accept() {
  PetscFunctionBeginUser;
  if (!stand_) PetscCall(VecDuplicate(scene_.displacement, &stand_));
  PetscCall(VecCopy(scene_.displacement, stand_));
  time_of_stand_ = time_;
  if (spread_) {
    if (!spread_of_stand_) PetscCall(VecDuplicate(spread_, &spread_of_stand_));
    PetscCall(VecCopy(spread_, spread_of_stand_));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadPath::go_back() {
  PetscFunctionBeginUser;
  PetscCall(set_time(time_of_stand_));
  if (stand_) {
    PetscCall(VecCopy(stand_, scene_.displacement));
  } else {
    PetscCall(VecSet(scene_.displacement, 0));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadPath::save(const Checkpoint &checkpoint, SavedRun *run) const {
  PetscFunctionBeginUser;
  run->numbers["stands"] = has_stand();
  run->numbers["time_of_stand"] = time_of_stand_;
  if (has_stand()) PetscCall(checkpoint.keep(stand_, "stand", false, run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadPath::go_on(const Checkpoint &checkpoint, bool follows, GuessCost *cost) {
  bool stands = false;
  double time = 0;
  PetscFunctionBeginUser;
  PetscCall(checkpoint.take([&](const Checkpoint::Json &numbers) {
    stands = numbers.at("stands");
    time = numbers.at("time_of_stand");
  }));
  if (!stands) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(set_time(time));
  if (follows || scene_.options.initial != "rest") PetscCall(follow(cost));
  PetscCall(checkpoint.fetch("stand", scene_.displacement));
  PetscCall(accept());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode choose_load_steps(Scene *scene) {
  PetscBool given = PETSC_FALSE;
  bool changes = false;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(nullptr, nullptr, "-load_steps", &given));
  if (given || !scene->contact || scene->motion) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(LoadPath(*scene).changes(0.5, 1, &changes));
  if (changes) scene->options.load_steps = "auto";
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
