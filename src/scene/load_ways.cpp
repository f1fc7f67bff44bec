#include <algorithm>
#include <cmath>

#include "scene/load_formula.hpp"
#include "scene/loads.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

/// Throws InputError.
bool Loads::are_written_in_time() const {
  const auto is = [this](const std::string &formula) {
    return !formula.empty() && LoadFormula(*mesh_, formula, "-load", false).uses_time();
  };
  return is(options_.gravity) ||
         std::any_of(chosen_.begin(), chosen_.end(), [&](const Chosen &load) {
           return is(load.options.traction) || is(load.options.force) || is(load.options.pressure);
         });
}

PetscErrorCode Loads::have_own_way(bool *own) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  constexpr double alike = 0.3;  // of the largest force, as with moves
  std::vector<double> end, here;
  double sizes[2] = {0, 0};  // of the forces, and of what they are off on the way
  bool written = false;
  PetscFunctionBeginUser;
  *own = false;
  const std::string complaint = complaint_of([&] { written = are_written_in_time(); });
  PetscCall(agree_on_complaint(comm, complaint));
  const bool any_moves =
      std::any_of(chosen_.begin(), chosen_.end(), [](const Chosen &load) { return load.moves; });
  if (!written || any_moves) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(forces(1, &end));
  for (const double time : {1. / 3, 2. / 3}) {
    PetscCall(forces(time, &here));
    for (std::size_t k = 0; k < end.size(); ++k) {
      sizes[0] = std::max({sizes[0], std::abs(end[k]), std::abs(here[k])});
      sizes[1] = std::max(sizes[1], std::abs(here[k] - time * end[k]));
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sizes, 2, MPI_DOUBLE, MPI_MAX, comm));
  *own = sizes[1] > alike * sizes[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
