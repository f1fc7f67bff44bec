#include <petsc/private/petscimpl.h>

#include "rule/rule.hpp"
#include "simd/instruction_set.hpp"
#include "snes/solver.hpp"
#include "support/log_events.hpp"
#include "support/notice.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
PetscLogEvent event_filter = -1, event_assembly = -1, event_search = -1;
}

static bool registered = false;

/// PetscFinalize forgets every registered type, so the next PetscInitialize starts anew.
static PetscErrorCode TrefoilFinalizePackage(void) {
  PetscFunctionBegin;
  registered = false;
  trefoil::forget_registered_rules();
  trefoil::forget_notices();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilInitializePackage(void) {
  PetscClassId id = 0;
  PetscFunctionBegin;
  if (registered) PetscFunctionReturn(PETSC_SUCCESS);
  const std::string wrong = trefoil::instruction_set_error();
  PetscCheck(wrong.empty(), PETSC_COMM_SELF, PETSC_ERR_USER_INPUT, "%s", wrong.c_str());
  registered = true;
  PetscCall(SNESRegister(SNESTREFOIL, SNESCreate_Trefoil));
  PetscCall(SNESLineSearchRegister(SNESLINESEARCHTREFOIL, SNESLineSearchCreate_Trefoil));
  PetscCall(PetscClassIdRegister("Trefoil", &id));
  PetscCall(PetscLogEventRegister("TrefoilFilter", id, &trefoil::event_filter));
  PetscCall(PetscLogEventRegister("TrefoilAssembly", id, &trefoil::event_assembly));
  PetscCall(PetscLogEventRegister("TrefoilSearch", id, &trefoil::event_search));
  PetscCall(PetscRegisterFinalize(TrefoilFinalizePackage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PetscDLLibraryRegister_trefoil(void) {
  PetscFunctionBegin;
  PetscCall(TrefoilInitializePackage());
  PetscFunctionReturn(PETSC_SUCCESS);
}
