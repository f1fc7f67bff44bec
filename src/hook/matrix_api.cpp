// The functions of trefoil.h on element matrices and on Mats, see their comments there.

#include "filter/filter.hpp"
#include "hook/element_hook.hpp"
#include "hook/matrix_operations.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

using trefoil::ElementHook;

PetscErrorCode TrefoilSplitElementMatrix(PetscInt n, const PetscScalar H[], PetscScalar N[],
                                         PetscInt *negative) {
  int count = 0;
  PetscFunctionBegin;
  const trefoil::SplitResult result = trefoil::split(static_cast<int>(n), 1, H, N, &count);
  PetscCheck(result.status != trefoil::SplitStatus::bad_size, PETSC_COMM_SELF,
             PETSC_ERR_ARG_OUTOFRANGE, "an element matrix has 1 to %d rows, not %" PetscInt_FMT,
             trefoil::largest_element_matrix, n);
  PetscCheck(result.status != trefoil::SplitStatus::not_finite, PETSC_COMM_SELF, PETSC_ERR_FP,
             "the element matrix has entries that are not finite");
  PetscCheck(result.status == trefoil::SplitStatus::ok, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "LAPACK found no eigenvalues of the element matrix");
  if (negative) *negative = count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilMatAttach(Mat matrix) {
  ElementHook *hook = nullptr;
  PetscFunctionBegin;
  PetscCall(TrefoilInitializePackage());
  PetscCall(ElementHook::attach(matrix, &hook));
  hook->keep_active();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilMatDetach(Mat matrix) {
  PetscFunctionBegin;
  PetscCall(ElementHook::detach(matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilMatSetElementValues(Mat matrix, PetscInt n, const PetscInt index[],
                                          const PetscScalar H[]) {
  ElementHook *hook = ElementHook::find(matrix);
  PetscFunctionBegin;
  if (hook) PetscCall(hook->take_element(n, index, H));
  PetscCall(trefoil::set_values_unrecorded(matrix, n, index, H));
  PetscFunctionReturn(PETSC_SUCCESS);
}
