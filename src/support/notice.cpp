#include "support/notice.hpp"

#include <set>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

/// Never destroyed: a host may finalise PETSc from a destructor of its own, after ours.
static std::set<std::string> &said() {
  static auto &sentences = *new std::set<std::string>;
  return sentences;
}

PetscErrorCode say_once(MPI_Comm comm, const std::string &sentence) {
  PetscFunctionBeginUser;
  if (said().insert(sentence).second)
    PetscCall(PetscPrintf(comm, "trefoil: %s\n", sentence.c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void forget_notices() {
  said().clear();
}

}  // namespace trefoil
