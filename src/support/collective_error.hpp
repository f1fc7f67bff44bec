#pragma once

#include <petscsys.h>

#include <functional>
#include <string>

namespace trefoil {

/// Turns what one or several ranks found wrong into one error on all of them: the sentence of the
/// lowest rank that has one. Collective; returns `code` on all ranks or on none.
/// @param complaint this rank's sentence, empty where nothing is wrong
PetscErrorCode agree_on_complaint(MPI_Comm comm, const std::string &complaint,
                                  PetscErrorCode code = PETSC_ERR_USER_INPUT);

/// Runs `action`, which may throw InputError (or run out of memory), on this rank; the exception's
/// sentence, empty where there is none. No exception gets past this.
std::string complaint_of(const std::function<void()> &action);

}  // namespace trefoil
