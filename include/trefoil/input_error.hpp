#pragma once

#include <stdexcept>

namespace trefoil {

/// What a user's input gets wrong, said in one sentence that names the culprit and the way out.
/// Thrown by code that knows no PETSc; whoever calls it from PETSc turns it into a PetscError.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace trefoil
