#include "snes/split_jacobian.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode check_capabilities(MPI_Comm comm, const SolverOptions &options,
                                  const SplitJacobian &split, const EigenvalueFloor &floor) {
  const bool whole_elements = options.space == TREFOIL_SPACE_ELEMENT;
  const bool obeys_floor = !split || (split.capabilities & TREFOIL_SPLIT_FLOOR);
  PetscFunctionBeginUser;
  PetscCheck(whole_elements || (split.capabilities & TREFOIL_SPLIT_DEFORMATION), comm,
             PETSC_ERR_USER_INPUT,
             "-snes_trefoil_space deformation filters at quadrature points, which are not to be "
             "seen in whole element matrices; use -snes_trefoil_space element");
  PetscCheck(
      floor.share == 0 || (whole_elements && obeys_floor), comm, PETSC_ERR_USER_INPUT,
      "-snes_trefoil_filter %s keeps eigenvalues above %g of an element's largest "
      "(-snes_trefoil_floor), in whole element matrices that Trefoil splits; with "
      "-snes_trefoil_space deformation or split callbacks of your own use another filter, or "
      "-snes_trefoil_floor 0",
      options.filter.c_str(), floor.share);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode forms_at_once(const Solver &solver, double weight, bool *at_once) {
  bool is_tested = false;
  PetscFunctionBeginUser;
  *at_once = weight != 0 && solver.split_jacobian.product && solver.floor(weight).share == 0;
  if (*at_once) PetscCall(JacobianTest::is_wanted(solver.snes, &is_tested));
  *at_once = *at_once && !is_tested;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode compute_split(Solver &solver, Vec x, Mat H, bool keeps_negative,
                             InsertionCounts *counts, double *filter_seconds) {
  const SplitJacobian &split = solver.split_jacobian;
  const bool names_fields = !solver.options.fields.empty();
  Mat *const negative = keeps_negative ? solver.jacobian.place_of_negative() : nullptr;
  TrefoilSplitStatistics mine{};
  PetscFunctionBeginUser;
  if (names_fields) {
    PetscCall(solver.note("-snes_trefoil_fields has no effect with a split callback"));
  }
  PetscCall(split.function(solver.snes, x, H, negative, &mine, split.context));
  PetscInt64 sums[2] = {mine.elements, mine.indefinite};
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPIU_INT64, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(solver.snes))));
  counts->elements = sums[0];
  counts->indefinite = sums[1];
  *filter_seconds = mine.filter_seconds;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
