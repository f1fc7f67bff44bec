#include <petsc/private/snesimpl.h>
#include <petscdm.h>

#include <sstream>

#include "filter/filter.hpp"
#include "snes/solve_context.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr const char *way_out =
    "insert whole element blocks, call TrefoilMatSetElementValues() for each element, or set a "
    "callback with TrefoilSNESSetSplitJacobian(); -snes_trefoil_strict false goes on unfiltered";

/// A matrix without entries has no element blocks either.
PetscErrorCode refuse_matrix_free(SolveContext &context, Mat J, Mat H) {
  PetscFunctionBegin;
  for (Mat matrix : {J, H}) {
    PetscBool free = PETSC_FALSE;
    PetscCall(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(matrix), &free, MATMFFD,
                                        MATSHELL, ""));
    PetscCheck(!free || !context.options.strict,
               PetscObjectComm(reinterpret_cast<PetscObject>(context.snes)), PETSC_ERR_SUP,
               "the Jacobian is matrix-free (type %s), which the filter cannot see into: assemble "
               "it, or -snes_trefoil_strict false goes on unfiltered",
               reinterpret_cast<PetscObject>(matrix)->type_name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What no filter can do anything about, said on all ranks in one sentence with the way out.
PetscErrorCode refuse_unfiltered(SolveContext &context, const InsertionCounts &counts) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(context.snes));
  PetscErrorCode (*host)(SNES, Vec, Mat, Mat, void *) = context.host_jacobian;
  PetscFunctionBegin;
  PetscCheck(host != SNESComputeJacobianDefault && host != SNESComputeJacobianDefaultColor, comm,
             PETSC_ERR_SUP,
             "the Jacobian is made by finite differences (colouring), which has no element blocks: "
             "%s",
             way_out);
  PetscCheck(counts.partial == 0, comm, PETSC_ERR_SUP,
             "%lld blocks were added to the Jacobian whose rows are only a part of their columns, "
             "as for elements on the interface between ranks of a DMDA: %s",
             static_cast<long long>(counts.partial), way_out);
  PetscCheck(counts.rectangular == 0, comm, PETSC_ERR_SUP,
             "%lld blocks were added to the Jacobian that are not whole elements (rows differ from "
             "columns, as in row-by-row insertion): %s",
             static_cast<long long>(counts.rectangular), way_out);
  PetscCheck(counts.elements > 0, comm, PETSC_ERR_SUP,
             "no element block was added to the Jacobian (MatSetValuesCOO, number by number, or "
             "inserted instead of added?): %s",
             way_out);
  PetscCheck(counts.saddle == 0, comm, PETSC_ERR_SUP,
             "%lld of %lld element blocks are of a saddle point (zeros on the diagonal), whose "
             "negative eigenvalues must stay: name the fields to filter with -snes_trefoil_fields, "
             "or -snes_trefoil_strict false goes on unfiltered",
             static_cast<long long>(counts.saddle), static_cast<long long>(counts.elements));
  PetscCheck(counts.too_large == 0, comm, PETSC_ERR_SUP,
             "%lld of %lld element blocks have more than the filter's largest number of rows, %d: "
             "-snes_trefoil_strict false goes on with these unfiltered",
             static_cast<long long>(counts.too_large), static_cast<long long>(counts.elements),
             largest_element_matrix);
  PetscCheck(counts.not_finite == 0, comm, PETSC_ERR_FP,
             "%lld of %lld element blocks have entries that are not finite",
             static_cast<long long>(counts.not_finite), static_cast<long long>(counts.elements));
  PetscCheck(counts.nonsymmetric == 0, comm, PETSC_ERR_SUP,
             "%lld of %lld element blocks are not symmetric, so they are no Hessians of an energy "
             "(follower loads?): -snes_trefoil_strict false goes on with these unfiltered",
             static_cast<long long>(counts.nonsymmetric), static_cast<long long>(counts.elements));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Marks the unknowns of the fields that -snes_trefoil_fields names, by the DM's own division.
PetscErrorCode find_fields(SolveContext &context, Vec x) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(context.snes));
  DM dm = nullptr;
  PetscInt count = 0, size = 0;
  char **names = nullptr;
  IS *unknowns = nullptr;
  PetscFunctionBegin;
  if (context.options.fields.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetDM(context.snes, &dm));
  PetscCall(DMCreateFieldDecomposition(dm, &count, &names, &unknowns, nullptr));
  PetscCall(VecGetSize(x, &size));
  context.in_field.assign(static_cast<std::size_t>(size), 0);
  std::istringstream wanted(context.options.fields);
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
        context.in_field[static_cast<std::size_t>(number[i])] = 1;
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

/// Goes over to another Mat when the host has one: after SNESReset(), or with another mesh.
PetscErrorCode watch_matrix(SolveContext &context, Vec x, Mat H, ElementHook **hook) {
  PetscFunctionBegin;
  if (context.watched != H) {
    PetscCall(release_host_matrix(context));
    PetscCall(PetscObjectReference(reinterpret_cast<PetscObject>(H)));
    context.watched = H;
    PetscCall(find_fields(context, x));
  }
  PetscCall(ElementHook::attach(H, hook));
  PetscCheck(!(*hook)->always_active() || context.in_field.empty(),
             PetscObjectComm(reinterpret_cast<PetscObject>(H)), PETSC_ERR_SUP,
             "-snes_trefoil_fields needs the elements added in the Jacobian callback, not with "
             "TrefoilMatAttach()");
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode release_host_matrix(SolveContext &context) {
  PetscFunctionBegin;
  if (!context.watched) PetscFunctionReturn(PETSC_SUCCESS);
  const ElementHook *hook = ElementHook::find(context.watched);
  if (hook && !hook->always_active()) PetscCall(ElementHook::detach(context.watched));
  PetscCall(MatDestroy(&context.watched));
  PetscCall(MatDestroy(&context.negative));
  context.in_field.clear();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode keep_host_context(SolveContext &context) {
  DM dm = nullptr;
  DMSNES problem = nullptr;
  PetscFunctionBegin;
  PetscCall(SNESGetDM(context.snes, &dm));
  PetscCall(DMGetDMSNES(dm, &problem));
  auto keeper = reinterpret_cast<PetscObject>(problem->jacobianctxcontainer);
  PetscCall(PetscObjectReference(keeper));
  PetscCall(PetscObjectDereference(context.host_context_keeper));
  context.host_context_keeper = keeper;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode watch_host_jacobian(SolveContext &context, Vec x, Mat J, Mat H, bool filtered,
                                   InsertionCounts *counts, double *filter_seconds) {
  ElementHook *hook = nullptr;
  PetscFunctionBegin;
  if (!filtered) {
    PetscCall(context.host_jacobian(context.snes, x, J, H, context.host_jacobian_context));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(refuse_matrix_free(context, J, H));
  PetscCall(watch_matrix(context, x, H, &hook));
  hook->set_floor(eigenvalue_floor(context));
  PetscCall(hook->begin(context.negative, context.in_field.empty() ? nullptr : &context.in_field));
  PetscCall(context.host_jacobian(context.snes, x, J, H, context.host_jacobian_context));
  hook = ElementHook::find(H);
  PetscCheck(hook, PetscObjectComm(reinterpret_cast<PetscObject>(H)), PETSC_ERR_ORDER,
             "the Jacobian callback has taken the hook off its Mat");
  PetscCall(hook->end(H, &context.negative, counts, filter_seconds));
  if (context.options.strict) PetscCall(refuse_unfiltered(context, *counts));
  context.unfiltered.rectangular += counts->rectangular;
  context.unfiltered.partial += counts->partial;
  context.unfiltered.too_large += counts->too_large;
  context.unfiltered.nonsymmetric += counts->nonsymmetric;
  context.unfiltered.saddle += counts->saddle;
  context.unfiltered.not_finite += counts->not_finite;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
