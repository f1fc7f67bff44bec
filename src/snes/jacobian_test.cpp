#include "snes/jacobian_test.hpp"

#include <petsc/private/snesimpl.h>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

#if PETSC_VERSION_LT(3, 25, 0)

constexpr const char *option = "-snes_test_jacobian";

static PetscErrorCode find_database(SNES snes, PetscOptions *database, std::string *name) {
  const char *prefix = nullptr;
  PetscFunctionBegin;
  PetscCall(PetscObjectGetOptions(reinterpret_cast<PetscObject>(snes), database));
  PetscCall(SNESGetOptionsPrefix(snes, &prefix));
  *name = std::string("-").append(prefix ? prefix : "").append(option + 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode JacobianTest::is_wanted(SNES snes, bool *wanted) {
  PetscOptions database = nullptr;
  PetscBool found = PETSC_FALSE;
  std::string name;
  PetscFunctionBegin;
  PetscCall(find_database(snes, &database, &name));
  PetscCall(PetscOptionsFindPair(database, nullptr, name.c_str(), nullptr, &found));
  *wanted = found == PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode JacobianTest::run(SNES snes) {
  PetscOptions database = nullptr;
  const char *value = nullptr;
  PetscBool wanted = PETSC_FALSE;
  std::string name;
  PetscFunctionBegin;
  PetscCall(find_database(snes, &database, &name));
  PetscCall(PetscOptionsFindPair(database, nullptr, name.c_str(), &value, &wanted));
  if (!wanted) PetscFunctionReturn(PETSC_SUCCESS);
  value_ = value ? value : "";
  PetscCall(SNESTestJacobian(snes));
  PetscCall(PetscOptionsClearValue(database, name.c_str()));
  hidden_ = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode JacobianTest::restore(SNES snes) {
  PetscOptions database = nullptr;
  std::string name;
  PetscFunctionBegin;
  if (!hidden_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(find_database(snes, &database, &name));
  PetscCall(
      PetscOptionsSetValue(database, name.c_str(), value_.empty() ? nullptr : value_.c_str()));
  hidden_ = false;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else

PetscErrorCode JacobianTest::is_wanted(SNES snes, bool *wanted) {
  PetscFunctionBegin;
  *wanted = snes->testJac == PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode JacobianTest::run(SNES snes) {
  PetscFunctionBegin;
  if (!snes->testJac) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESTestJacobian(snes, nullptr, nullptr));
  snes->testJac = PETSC_FALSE;
  hidden_ = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode JacobianTest::restore(SNES snes) {
  PetscFunctionBegin;
  if (hidden_) snes->testJac = PETSC_TRUE;
  hidden_ = false;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#endif

}  // namespace trefoil
