#include "snes/host_jacobian.hpp"

#include <petsc/private/snesimpl.h>

#include "filter/filter.hpp"
#include "hook/matrix_operations.hpp"
#include "snes/field_selection.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr const char *way_out =
    "insert whole element blocks, call TrefoilMatSetElementValues() for each element, or set a "
    "callback with TrefoilSNESSetSplitJacobian(); -snes_trefoil_strict false goes on unfiltered";

/// A matrix without entries has no element blocks either.
PetscErrorCode refuse_matrix_free(Mat J, Mat H) {
  PetscFunctionBegin;
  for (Mat matrix : {J, H}) {
    PetscCheck(!is_matrix_free(matrix), PetscObjectComm(reinterpret_cast<PetscObject>(matrix)),
               PETSC_ERR_SUP,
               "the Jacobian is matrix-free (type %s), which the filter cannot see into: assemble "
               "it, or -snes_trefoil_strict false goes on unfiltered",
               reinterpret_cast<PetscObject>(matrix)->type_name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What no filter can do anything about, said on all ranks in one sentence with the way out.
PetscErrorCode refuse_unfiltered(MPI_Comm comm, HostJacobian::Function host,
                                 const InsertionCounts &counts) {
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
  PetscCheck(
      counts.saddle == 0, comm, PETSC_ERR_SUP,
      "%lld of %lld element blocks are of a saddle point (zeros on the diagonal, or in every "
      "element the same unknowns with a negative one), whose "
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
  PetscCheck(counts.singles == 0, comm, PETSC_ERR_SUP,
             "%lld single numbers were added beside the Jacobian's diagonal, and so are no whole "
             "elements, to %lld element blocks: %s",
             static_cast<long long>(counts.singles), static_cast<long long>(counts.elements),
             way_out);
  PetscCheck(counts.one_sided == 0, comm, PETSC_ERR_SUP,
             "the Jacobian was scaled by rows or by columns alone (MatDiagonalScale()), which "
             "leaves no Hessian of an energy: scale both sides by the same vector, or "
             "-snes_trefoil_strict false goes on");
  PetscCheck(
      counts.changed == 0, comm, PETSC_ERR_SUP,
      "the Jacobian is not the sum of the %lld element blocks that were added to it: it had "
      "other entries before, or was changed afterwards (MatAXPY(), MatCopy(), "
      "MAT_IGNORE_ZERO_ENTRIES ...), which the filter has not seen: add all of it in element "
      "blocks, or -snes_trefoil_strict false goes on",
      static_cast<long long>(counts.elements));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

HostJacobian::~HostJacobian() {
  // Errors, if any, have nowhere to go from a destructor; PETSc has printed them.
  FilteredJacobian none;
  static_cast<void>(release(none));
  static_cast<void>(PetscObjectDereference(context_keeper_));
}

PetscErrorCode HostJacobian::take_over(SNES snes, Function function, void *context) {
  DM dm = nullptr;
  DMSNES problem = nullptr;
  PetscFunctionBegin;
  PetscCall(SNESGetDM(snes, &dm));
  PetscCall(DMGetDMSNES(dm, &problem));
  auto keeper = reinterpret_cast<PetscObject>(problem->jacobianctxcontainer);
  PetscCall(PetscObjectReference(keeper));
  PetscCall(PetscObjectDereference(context_keeper_));
  context_keeper_ = keeper;
  function_ = function;
  context_ = context;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HostJacobian::release(FilteredJacobian &jacobian) {
  PetscFunctionBegin;
  if (!watched_) PetscFunctionReturn(PETSC_SUCCESS);
  const ElementHook *hook = ElementHook::find(watched_);
  if (hook && !hook->always_active()) PetscCall(ElementHook::detach(watched_));
  PetscCall(MatDestroy(&watched_));
  PetscCall(jacobian.forget_negative());
  in_field_.clear();
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Goes over to another Mat when the host has one: after SNESReset(), or with another mesh.
PetscErrorCode HostJacobian::watch(SNES snes, Vec x, Mat H, const std::string &fields,
                                   FilteredJacobian &jacobian, ElementHook **hook) {
  PetscFunctionBegin;
  if (watched_ != H) {
    PetscCall(release(jacobian));
    PetscCall(PetscObjectReference(reinterpret_cast<PetscObject>(H)));
    watched_ = H;
    if (!fields.empty()) PetscCall(select_fields(snes, x, fields, &in_field_));
  }
  PetscCall(ElementHook::attach(H, hook));
  PetscCheck(!(*hook)->always_active() || in_field_.empty(),
             PetscObjectComm(reinterpret_cast<PetscObject>(H)), PETSC_ERR_SUP,
             "-snes_trefoil_fields needs the elements added in the Jacobian callback, not with "
             "TrefoilMatAttach()");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HostJacobian::compute_watched(SNES snes, Vec x, Mat J, Mat H,
                                             const std::string &fields, bool strict,
                                             const EigenvalueFloor &floor,
                                             FilteredJacobian &jacobian, InsertionCounts *counts,
                                             double *filter_seconds) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(snes));
  ElementHook *hook = nullptr;
  PetscFunctionBegin;
  if (strict) PetscCall(refuse_matrix_free(J, H));
  if (is_matrix_free(H)) {
    PetscCall(compute(snes, x, J, H));
    counts->unseen = 1;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(watch(snes, x, H, fields, jacobian, &hook));
  hook->set_floor(floor);
  PetscCall(hook->begin(jacobian.negative(), in_field_.empty() ? nullptr : &in_field_));
  PetscCall(compute(snes, x, J, H));
  hook = ElementHook::find(H);
  PetscCheck(hook, comm, PETSC_ERR_ORDER, "the Jacobian callback has taken the hook off its Mat");
  PetscCall(hook->end(H, jacobian.place_of_negative(), counts, filter_seconds));
  if (strict) PetscCall(refuse_unfiltered(comm, function_, *counts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
