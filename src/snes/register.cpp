#include <petsc/private/petscimpl.h>

#include "rule/rule.hpp"
#include "simd/instruction_set.hpp"
#include "snes/solver.hpp"
#include "support/log_events.hpp"
#include "support/notice.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
PetscLogEvent event_filter = -1, event_assembly = -1, event_search = -1, event_pairs = -1;
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

/// Refuses a PETSc that is another than this library was compiled with: what is ours would read its
/// numbers and structures wrongly. Asked of the PETSc that runs, whose functions are found first.
static PetscErrorCode TrefoilCheckPetsc(void) {
  PetscDataType scalar = PETSC_DATATYPE_UNKNOWN, real = PETSC_DATATYPE_UNKNOWN;
  PetscBool found = PETSC_FALSE;
  PetscInt major = 0, minor = 0;
  std::size_t index_bytes = 0;
  PetscFunctionBegin;
  PetscCall(PetscDataTypeFromString("scalar", &scalar, &found));
  PetscCheck(scalar == PETSC_SCALAR, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "libtrefoil.so was built with a PETSc of real numbers in double precision, this "
             "program's has others (%s): it works with such a PETSc only",
             PetscDataTypes[scalar]);
  PetscCall(PetscDataTypeFromString("real", &real, &found));
  PetscCheck(real == PETSC_REAL, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "libtrefoil.so was built with a PETSc in double precision, this program's has another "
             "(%s): build Trefoil with it",
             PetscDataTypes[real]);
  PetscCall(PetscDataTypeGetSize(PETSC_INT, &index_bytes));
  PetscCheck(index_bytes == sizeof(PetscInt), PETSC_COMM_SELF, PETSC_ERR_SUP,
             "libtrefoil.so was built with a PETSc whose indices have %d bits, this program's have "
             "%d: build Trefoil with it",
             static_cast<int>(8 * sizeof(PetscInt)), static_cast<int>(8 * index_bytes));
  PetscCall(PetscGetVersionNumber(&major, &minor, nullptr, nullptr));
  PetscCheck(
      major == PETSC_VERSION_MAJOR && minor == PETSC_VERSION_MINOR, PETSC_COMM_SELF, PETSC_ERR_SUP,
      "libtrefoil.so was built with PETSc %d.%d, this program runs with %d.%d: build Trefoil "
      "with it",
      PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, static_cast<int>(major), static_cast<int>(minor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilInitializePackage(void) {
  PetscClassId id = 0;
  PetscFunctionBegin;
  if (registered) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TrefoilCheckPetsc());
  const std::string wrong = trefoil::instruction_set_error();
  PetscCheck(wrong.empty(), PETSC_COMM_SELF, PETSC_ERR_USER_INPUT, "%s", wrong.c_str());
  registered = true;
  PetscCall(SNESRegister(SNESTREFOIL, SNESCreate_Trefoil));
  PetscCall(SNESLineSearchRegister(SNESLINESEARCHTREFOIL, SNESLineSearchCreate_Trefoil));
  PetscCall(PetscClassIdRegister("Trefoil", &id));
  PetscCall(PetscLogEventRegister("TrefoilFilter", id, &trefoil::event_filter));
  PetscCall(PetscLogEventRegister("TrefoilAssembly", id, &trefoil::event_assembly));
  PetscCall(PetscLogEventRegister("TrefoilSearch", id, &trefoil::event_search));
  PetscCall(PetscLogEventRegister("TrefoilPairs", id, &trefoil::event_pairs));
  PetscCall(PetscRegisterFinalize(TrefoilFinalizePackage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PetscDLLibraryRegister_trefoil(void) {
  PetscFunctionBegin;
  PetscCall(TrefoilInitializePackage());
  PetscFunctionReturn(PETSC_SUCCESS);
}
