// What a checkpoint keeps of the way with contact.

#include "scene/initial_displacement.hpp"
#include "solve/contact_path.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

void ContactPath::save(SavedRun *run) const {
  run->numbers["contact"] = {{"time", stand_.time},
                             {"stiffening", scene_.contact->stiffening_of_step()},
                             {"solves", solves_},
                             {"lags", !lagged_.empty()}};
  run->fields["contact_stand"] = stand_.u;
  if (!lagged_.empty()) run->fields["contact_lag"] = lagged_;
}

PetscErrorCode ContactPath::go_on(const Checkpoint &checkpoint) {
  double stiffening = 1;
  PetscFunctionBeginUser;
  PetscCall(checkpoint.take([&](const Checkpoint::Json &numbers) {
    stand_.time = numbers.at("contact").at("time");
    stiffening = numbers.at("contact").at("stiffening");
  }));
  PetscCall(checkpoint.fetch("contact_stand", &stand_.u));
  PetscCall(VecDuplicate(scene_.displacement, &stand_.unknowns));
  PetscCall(set_unknowns(stand_.u, scene_.discretization, stand_.unknowns));
  PetscCall(scene_.contact->go_on(stand_.u.data(), stand_.time, stiffening));
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
