#include "snes/field_selection.hpp"

#include <petscdm.h>

#include <sstream>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode select_fields(SNES snes, Vec x, const std::string &fields,
                             std::vector<char> *in_field) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(snes));
  DM dm = nullptr;
  PetscInt count = 0, size = 0;
  char **names = nullptr;
  IS *unknowns = nullptr;
  PetscFunctionBegin;
  PetscCall(SNESGetDM(snes, &dm));
  PetscCall(DMCreateFieldDecomposition(dm, &count, &names, &unknowns, nullptr));
  PetscCall(VecGetSize(x, &size));
  in_field->assign(static_cast<std::size_t>(size), 0);
  std::istringstream wanted(fields);
  std::string missing;
  for (std::string name; std::getline(wanted, name, ',');) {
    bool found = false;
    for (PetscInt f = 0; f < count; ++f) {
      if (name != std::to_string(f) && (!names || name != names[f])) continue;
      IS all = nullptr;
      const PetscInt *number = nullptr;
      PetscInt length = 0;
      found = true;
      PetscCall(ISAllGather(unknowns[f], &all));
      PetscCall(ISGetLocalSize(all, &length));
      PetscCall(ISGetIndices(all, &number));
      for (PetscInt i = 0; i < length; ++i) {
        (*in_field)[static_cast<std::size_t>(number[i])] = 1;
      }
      PetscCall(ISRestoreIndices(all, &number));
      PetscCall(ISDestroy(&all));
    }
    if (!found) missing = name;
  }
  std::string known;
  for (PetscInt f = 0; f < count; ++f) {
    known += (f ? ", " : "") + std::string(names ? names[f] : std::to_string(f));
    if (names) PetscCall(PetscFree(names[f]));
    PetscCall(ISDestroy(&unknowns[f]));
  }
  PetscCall(PetscFree(names));
  PetscCall(PetscFree(unknowns));
  PetscCheck(missing.empty(), comm, PETSC_ERR_USER_INPUT,
             "-snes_trefoil_fields names the field '%s', which the SNES's DM does not have; its "
             "fields are: %s",
             missing.c_str(), count ? known.c_str() : "none");
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
