#include "scene/load_steps.hpp"

#include <nlohmann/json.hpp>

#include "scene/constraints.hpp"
#include "scene/loads.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

LoadPath::~LoadPath() {
  static_cast<void>(VecDestroy(&spread_));  // an error has nowhere to go from here
}

PetscErrorCode LoadPath::check() {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm));
  HeldDofs first, last;
  std::vector<double> first_forces, last_forces;
  PetscMPIInt changes = 0;
  PetscFunctionBeginUser;
  PetscCall(scene_.constraints.hold(1. / steps_, &first));
  PetscCall(scene_.constraints.hold(1, &last));
  if (scene_.loads.any()) {
    PetscCall(scene_.loads.forces(1. / steps_, &first_forces));
    PetscCall(scene_.loads.forces(1, &last_forces));
  }
  changes = first.value != last.value || first_forces != last_forces;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changes, 1, MPI_INT, MPI_MAX, comm));
  PetscCheck(changes, comm, PETSC_ERR_USER_INPUT,
             "-load_steps %" PetscInt_FMT
             " would repeat one solve: nothing is moved or loaded, or all that is stays the same "
             "from t = 0 to 1",
             steps_);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadPath::set_time(double time) {
  HeldDofs held;
  PetscFunctionBeginUser;
  PetscCall(scene_.constraints.hold(time, &held));
  PetscCall(scene_.discretization.set_prescribed(held));
  PetscCall(scene_.functional->set_time(time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// x += h(t) - h(t before), h the harmonic extension of the prescribed displacements.
PetscErrorCode LoadPath::follow(PetscInt step, GuessCost *cost) {
  Vec before = spread_;
  GuessCost spent;
  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(scene_.displacement, &spread_));
  PetscCall(VecSet(spread_, 0));
  PetscCall(spread_displacements(*scene_.functional, scene_.discretization, scene_.hessian, 0,
                                 spread_, &spent));
  if (step > 1) {
    PetscCall(VecAXPY(scene_.displacement, 1, spread_));
    PetscCall(VecAXPY(scene_.displacement, -1, before));
  }
  PetscCall(VecDestroy(&before));
  cost->linear_solves += spent.linear_solves;
  cost->seconds += spent.seconds;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoadPath::go_to(PetscInt step, GuessCost *cost) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm));
  const double time = step == steps_ ? 1 : static_cast<double>(step) / steps_;
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(comm, "load step %" PetscInt_FMT " of %" PetscInt_FMT ", t = %g\n", step,
                        steps_, time));
  PetscCall(set_time(time));
  if (scene_.options.initial != "rest") PetscCall(follow(step, cost));
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::string join_records(const std::vector<std::string> &records) {
  using Json = nlohmann::ordered_json;
  if (records.size() == 1) return records.front();
  Json joined, history = Json::array(), iterations = Json::array();
  int linear_solves = 0;
  for (std::size_t step = 0; step < records.size(); ++step) {
    Json record = Json::parse(records[step], nullptr, false);
    if (!record.is_object()) return "";
    for (Json entry : record["history"]) {
      entry["k"] = history.size();
      entry["linear_solves"] = linear_solves + entry["linear_solves"].get<int>();
      entry["load_step"] = step + 1;
      history.push_back(entry);
    }
    iterations.push_back(record["result"]["iterations"]);
    if (step > 0) {
      for (const char *count : {"saddles_left", "verification_solves", "iterations",
                                "linear_solves", "line_search_trials"}) {
        record["result"][count] =
            record["result"][count].get<int>() + joined["result"][count].get<int>();
      }
      record["result"]["energy_start"] = joined["result"]["energy_start"];
      for (auto &[phase, seconds] : record["time"].items()) {
        seconds = seconds.get<double>() + joined["time"][phase].get<double>();
      }
    }
    linear_solves = record["result"]["linear_solves"];
    joined = record;
  }
  joined["result"]["load_step_iterations"] = iterations;
  joined["history"] = history;
  return joined.dump(1);
}

}  // namespace trefoil
