#include "assembly/energy_functional.hpp"

#include <algorithm>

#include "assembly/hessian_assembler.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

PetscErrorCode sum_over_ranks(DM dm, EnergySums *sums) {
  double values[3] = {sums->energy, sums->scale, sums->stiffness};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, values, 3, MPI_DOUBLE, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(dm))));
  *sums = {values[0], values[1], values[2]};
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode EnergyFunctional::energy(Vec x, EnergySums *sums) const {
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  PetscFunctionBeginUser;
  *sums = {};
  PetscCall(discretization_.get_local(x, &local, &u));
  for (const auto &term : terms_) term->add_energy(u, sums);
  PetscCall(discretization_.restore_local(&local, &u));
  PetscCall(sum_over_ranks(discretization_.mesh().dm, sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::energy_changes(Vec x, PetscInt directions, const Vec d[],
                                                PetscInt points, const PetscReal coefficients[],
                                                PetscReal changes[]) const {
  constexpr PetscInt most_directions = 2;
  Vec local = nullptr, local_d[most_directions] = {nullptr, nullptr};
  const PetscScalar *u = nullptr, *values[most_directions] = {nullptr, nullptr};
  PetscFunctionBeginUser;
  PetscCheck(directions >= 1 && directions <= most_directions,
             PetscObjectComm(reinterpret_cast<PetscObject>(x)), PETSC_ERR_ARG_OUTOFRANGE,
             "energies are sampled on a line or a plane, not on %" PetscInt_FMT " directions",
             directions);
  PetscCall(discretization_.get_local(x, &local, &u));
  for (PetscInt k = 0; k < directions; ++k) {
    PetscCall(discretization_.get_local_direction(d[k], &local_d[k], &values[k]));
  }
  std::fill_n(changes, points, 0);
  for (const auto &term : terms_) {
    term->add_energy_changes(u, discretization_.global_dofs().size(), static_cast<int>(directions),
                             values, static_cast<int>(points), coefficients, changes);
  }
  for (PetscInt k = 0; k < directions; ++k) {
    PetscCall(discretization_.restore_local(&local_d[k], &values[k]));
  }
  PetscCall(discretization_.restore_local(&local, &u));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, changes, static_cast<PetscMPIInt>(points), MPI_DOUBLE,
                             MPI_SUM, PetscObjectComm(reinterpret_cast<PetscObject>(x))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::energy_at_rest(double *energy) const {
  EnergySums sums;
  PetscFunctionBeginUser;
  const std::vector<double> u(discretization_.mesh().coordinates.size(), 0);
  for (const auto &term : terms_) term->add_energy(u.data(), &sums);
  PetscCall(sum_over_ranks(discretization_.mesh().dm, &sums));
  *energy = sums.energy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::gradient(Vec x, Vec g) const {
  const DM dm = discretization_.mesh().dm;
  Vec local = nullptr, forces = nullptr;
  const PetscScalar *u = nullptr;
  PetscScalar *force = nullptr;
  PetscFunctionBeginUser;
  PetscCall(discretization_.get_local(x, &local, &u));
  PetscCall(DMGetLocalVector(dm, &forces));
  PetscCall(VecSet(forces, 0));
  PetscCall(VecGetArray(forces, &force));
  for (const auto &term : terms_) term->add_gradient(u, force);
  PetscCall(VecRestoreArray(forces, &force));
  PetscCall(discretization_.add_to_global(forces, g));
  PetscCall(DMRestoreLocalVector(dm, &forces));
  PetscCall(discretization_.restore_local(&local, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether the batched path serves: of all terms only the first has a Hessian, and that has packs.
bool EnergyFunctional::is_batched() const {
  return assembly_ == Assembly::split && floor_.share == 0 && !terms_.empty() &&
         (terms_.front()->packs() || terms_.front()->packed_elements()) &&
         std::none_of(terms_.begin() + 1, terms_.end(),
                      [](const auto &term) { return term->has_hessian(); });
}

PetscErrorCode EnergyFunctional::prepare(Mat H) {
  PetscFunctionBeginUser;
  if (is_batched() && !batched_->ready())
    PetscCall(batched_->set_up(discretization_, *terms_.front(), H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Sets H and N, either of which may be null, from all terms at local displacements u.
PetscErrorCode EnergyFunctional::assemble(const PetscScalar *u, Mat H, Mat N, bool filtering,
                                          TrefoilSplitStatistics *statistics) const {
  PetscFunctionBeginUser;
  if (is_batched()) {
    if (!batched_->ready())
      PetscCall(batched_->set_up(discretization_, *terms_.front(), H ? H : N));
    PetscCall(batched_->assemble(*terms_.front(), u, H, N, filtering, statistics));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  HessianAssembler assembler(discretization_, H, N, statistics);
  assembler.set_filtering(filtering);
  assembler.set_floor(floor_);
  for (Mat matrix : {H, N}) {
    if (matrix) PetscCall(MatZeroEntries(matrix));
  }
  for (const auto &term : terms_) PetscCall(term->add_hessian(u, assembler));
  PetscCall(assembler.flush());
  for (Mat matrix : {H, N}) {
    if (!matrix) continue;
    PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::hessian(Vec x, Mat H, Mat *negative,
                                         TrefoilSplitStatistics *statistics) const {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(H));
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  PetscFunctionBeginUser;
  PetscCall(discretization_.get_local(x, &local, &u));
  PetscCall(assemble(u, H, negative ? *negative : nullptr, negative != nullptr, statistics));
  if (negative && !*negative) {
    // N is made when the first element is indefinite, with H's pattern.
    PetscInt64 indefinite = statistics->indefinite;
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &indefinite, 1, MPIU_INT64, MPI_SUM, comm));
    if (indefinite > 0) {
      TrefoilSplitStatistics again{};
      PetscCall(MatDuplicate(H, MAT_DO_NOT_COPY_VALUES, negative));
      PetscCall(assemble(u, nullptr, *negative, true, &again));
      statistics->filter_seconds += again.filter_seconds;
    }
  }
  PetscCall(discretization_.restore_local(&local, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::unique_ptr<EnergyFunctional> EnergyFunctional::spreading(Spreading kind) const {
  auto other = std::make_unique<EnergyFunctional>(discretization_);
  for (const auto &term : terms_) {
    if (auto spreading = term->spreading(kind)) other->add_term(std::move(spreading));
  }
  if (is_batched()) other->batched_ = batched_;
  return other;
}

PetscErrorCode EnergyFunctional::describe_cells(Vec x, CellReport *report) const {
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  TrefoilSplitStatistics ignored{};
  PetscFunctionBeginUser;
  const auto cells = static_cast<std::size_t>(discretization_.mesh().local_cells());
  report->determinant.assign(cells, 1);
  report->energy_density.assign(cells, 0);
  report->negative_eigenvalues.clear();
  PetscCall(discretization_.get_local(x, &local, &u));
  for (const auto &term : terms_) {
    term->describe_cells(u, report->determinant.data(), report->energy_density.data());
  }
  if (is_batched()) {
    PetscCall(BatchedHessian::count_negative(*terms_.front(), u, &report->negative_eigenvalues));
  } else {
    HessianAssembler counter(discretization_, nullptr, nullptr, &ignored);
    counter.keep_counts(&report->negative_eigenvalues);
    for (const auto &term : terms_) PetscCall(term->add_hessian(u, counter));
    PetscCall(counter.flush());
  }
  report->negative_eigenvalues.resize(cells, 0);
  PetscCall(discretization_.restore_local(&local, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::count_inverted(Vec x, PetscInt64 *inverted) const {
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  const auto cells = static_cast<std::size_t>(discretization_.mesh().local_cells());
  std::vector<double> determinant(cells, 1), energy_density(cells, 0);
  PetscFunctionBeginUser;
  PetscCall(discretization_.get_local(x, &local, &u));
  for (const auto &term : terms_) {
    term->describe_cells(u, determinant.data(), energy_density.data());
  }
  PetscCall(discretization_.restore_local(&local, &u));
  *inverted =
      std::count_if(determinant.begin(), determinant.end(), [](double det) { return !(det > 0); });
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, inverted, 1, MPIU_INT64, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(x))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

double EnergyFunctional::bytes() const {
  double sum = batched_->bytes();
  for (const auto &term : terms_) sum += term->bytes();
  return sum;
}

namespace {

PetscErrorCode objective(SNES, Vec x, PetscReal *energy, void *ctx) {
  EnergySums sums;
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->energy(x, &sums));
  *energy = sums.energy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode residual(SNES, Vec x, Vec g, void *ctx) {
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->gradient(x, g));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode split_hessian(SNES snes, Vec x, Mat H, Mat *negative,
                             TrefoilSplitStatistics *statistics, void *ctx) {
  PetscReal share = 0, weight = 0;
  PetscFunctionBeginUser;
  PetscCall(TrefoilSNESGetEigenvalueFloor(snes, &share, &weight));
  static_cast<EnergyFunctional *>(ctx)->set_floor({share, weight});
  PetscCall(static_cast<EnergyFunctional *>(ctx)->hessian(x, H, negative, statistics));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode plain_hessian(SNES, Vec x, Mat, Mat H, void *ctx) {
  TrefoilSplitStatistics ignored{};
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->hessian(x, H, nullptr, &ignored));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode changes_on_plane(SNES, Vec x, PetscInt directions, const Vec d[], PetscInt points,
                                const PetscReal coefficients[], PetscReal changes[], void *ctx) {
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->energy_changes(x, directions, d, points,
                                                                 coefficients, changes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode energy_scale(SNES, Vec x, PetscReal *scale, void *ctx) {
  EnergySums sums;
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->energy(x, &sums));
  // A body at rest has no energy to compare with; strains of 1e-9 count as rest.
  *scale = std::max(sums.scale, 1e-18 * sums.stiffness);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode EnergyFunctional::attach(SNES snes, Mat H, Assembly assembly) {
  PetscFunctionBeginUser;
  assembly_ = assembly;
  PetscCall(SNESSetObjective(snes, objective, this));
  PetscCall(SNESSetFunction(snes, nullptr, residual, this));
  if (assembly != Assembly::hook) {
    PetscCall(TrefoilSNESSetSplitJacobian(snes, H, split_hessian, this));
    // Linear tetrahedra in packs of their own are filtered whole; other terms as they were told.
    const bool whole =
        std::any_of(terms_.begin(), terms_.end(), [](const auto &term) { return term->packs(); });
    PetscCall(TrefoilSNESSetSplitCapabilities(
        snes, TREFOIL_SPLIT_FLOOR | (whole ? 0 : TREFOIL_SPLIT_DEFORMATION)));
  } else {
    PetscCall(SNESSetJacobian(snes, H, H, plain_hessian, this));
  }
  PetscCall(TrefoilSNESSetEnergyScale(snes, energy_scale, this));
  PetscCall(TrefoilSNESSetEnergyChanges(snes, changes_on_plane, this));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
