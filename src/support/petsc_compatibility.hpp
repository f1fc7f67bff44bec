#pragma once

#include <petscsys.h>

// One name for what PETSc 3.18 and later versions call differently.

#if PETSC_VERSION_LT(3, 19, 0)
#define PETSC_SUCCESS 0
#endif

#if PETSC_VERSION_LT(3, 25, 0)
#define SNES_DIVERGED_FUNCTION_NANORINF SNES_DIVERGED_FNORM_NAN
#endif

#if PETSC_VERSION_LT(3, 22, 0)
#define PETSC_UNLIMITED (-1)
#endif

#if PETSC_VERSION_LT(3, 23, 0)
#define TREFOIL_CONTEXT_DESTROY(name, argument) static PetscErrorCode name(void *argument)
#define TREFOIL_CONTEXT_OF(type, argument) static_cast<type *>(argument)
#define PetscContainerSetCtxDestroy PetscContainerSetUserDestroy
using TrefoilOptionItems = PetscOptionItems *;
#else
#if PETSC_VERSION_LT(3, 25, 0)
using PetscCtxRt = void **;
#endif
#define TREFOIL_CONTEXT_DESTROY(name, argument) static PetscErrorCode name(PetscCtxRt argument)
#define TREFOIL_CONTEXT_OF(type, argument) (*reinterpret_cast<type **>(argument))
using TrefoilOptionItems = PetscOptionItems;
#endif
