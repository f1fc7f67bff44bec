#include "assembly/energy_functional.hpp"

#include <algorithm>
#include <cmath>

#include "mesh/boundary.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

PetscErrorCode sum_over_ranks(DM dm, EnergySums *sums) {
  double values[4] = {sums->energy, sums->strain_energy, sums->load_work, sums->scale};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, values, 4, MPI_DOUBLE, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(dm))));
  *sums = {values[0], values[1], values[2], values[3]};
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode EnergyFunctional::energy(Vec x, EnergySums *sums) const {
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  PetscFunctionBeginUser;
  *sums = {};
  PetscCall(discretization_.get_local(x, &local, &u));
  for (const auto &term : terms_) PetscCall(term->add_energy(u, sums));
  PetscCall(discretization_.restore_local(&local, &u));
  PetscCall(sum_over_ranks(discretization_.mesh().dm, sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::size_of_energy(Vec x, double *scale) const {
  // Times the energy that rounding of the displacements makes: below, no digit of an energy is left
  // that a tolerance could ask for. Only bodies that move without strain come here.
  constexpr double resolved = 1e10;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(x));
  const std::size_t size = discretization_.global_dofs().size();
  EnergySums sums;
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  double stiffness = 0, largest = 0;
  PetscFunctionBeginUser;
  PetscCall(discretization_.get_local(x, &local, &u));
  for (const auto &term : terms_) {
    PetscCall(term->add_energy(u, &sums));
    stiffness += term->stiffness();
  }
  for (std::size_t k = 0; k < size; ++k) largest = std::max(largest, std::abs(u[k]));
  PetscCall(discretization_.restore_local(&local, &u));
  PetscCall(sum_over_ranks(discretization_.mesh().dm, &sums));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &stiffness, 1, MPI_DOUBLE, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm));
  const double rounding = PETSC_MACHINE_EPSILON * largest;
  *scale = std::max(sums.scale, resolved * stiffness * rounding * rounding);
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
    PetscCall(term->add_energy_changes(u, discretization_.global_dofs().size(),
                                       static_cast<int>(directions), values,
                                       static_cast<int>(points), coefficients, changes));
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
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(discretization_.mesh().dm));
  PetscFunctionBeginUser;
  *energy = 0;
  for (const auto &term : terms_) *energy += term->rest_energy();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, energy, 1, MPI_DOUBLE, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const PackedElements *EnergyFunctional::cells() const {
  const auto found = std::find_if(terms_.begin(), terms_.end(),
                                  [](const auto &term) { return term->has_cells(); });
  return found == terms_.end() ? nullptr : (*found)->batch();
}

PetscErrorCode EnergyFunctional::nodal_gradient(Vec x, std::vector<double> *gradient) const {
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  PetscFunctionBeginUser;
  gradient->assign(discretization_.mesh().coordinates.size(), 0);
  PetscCall(discretization_.get_local(x, &local, &u));
  for (const auto &term : terms_) PetscCall(term->add_gradient(u, gradient->data()));
  PetscCall(discretization_.restore_local(&local, &u));
  PetscCall(sum_at_owners(discretization_.mesh(), gradient));
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
  for (const auto &term : terms_) PetscCall(term->add_gradient(u, force));
  PetscCall(VecRestoreArray(forces, &force));
  PetscCall(discretization_.add_to_global(forces, g));
  PetscCall(DMRestoreLocalVector(dm, &forces));
  PetscCall(discretization_.restore_local(&local, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::hessian(Vec x, Mat H, Mat *negative,
                                         TrefoilSplitStatistics *statistics,
                                         const HessianFilter &filter) {
  const HessianFilter *wanted = negative ? &filter : nullptr;
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  PetscFunctionBeginUser;
  PetscCall(discretization_.get_local(x, &local, &u));
  PetscCall(hessian_.update_pattern(u, H, negative));
  PetscCall(hessian_.assemble(u, H, negative ? *negative : nullptr, wanted, statistics));
  if (negative && !*negative) {
    // N is made when the first element is indefinite, with H's pattern.
    PetscInt64 indefinite = statistics->indefinite;
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &indefinite, 1, MPIU_INT64, MPI_SUM,
                               PetscObjectComm(reinterpret_cast<PetscObject>(H))));
    if (indefinite > 0) {
      TrefoilSplitStatistics again{};
      PetscCall(hessian_.make_negative(H, negative));
      PetscCall(hessian_.assemble(u, nullptr, *negative, wanted, &again));
      statistics->filter_seconds += again.filter_seconds;
    }
  }
  PetscCall(discretization_.turn_matrix(H, true));
  if (negative && *negative) PetscCall(discretization_.turn_matrix(*negative, false));
  PetscCall(discretization_.restore_local(&local, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::filtered_hessian(Vec x, Mat H, TrefoilSplitStatistics *statistics,
                                                  double weight) {
  const HessianFilter filter{.weight = weight, .floor = {}, .at_once = true};
  PetscFunctionBeginUser;
  PetscCall(discretization_.copy_local(x, &filtered_at_));
  PetscCall(hessian_.assemble(filtered_at_.data(), H, nullptr, &filter, statistics));
  PetscCall(discretization_.turn_matrix(H, true));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::multiply_by_hessian(Vec p, Vec Hp) const {
  const DM dm = discretization_.mesh().dm;
  Vec local = nullptr, products = nullptr;
  const PetscScalar *values = nullptr;
  PetscScalar *product = nullptr;
  PetscFunctionBeginUser;
  PetscCall(discretization_.get_local_direction(p, &local, &values));
  PetscCall(DMGetLocalVector(dm, &products));
  PetscCall(VecSet(products, 0));
  PetscCall(VecGetArray(products, &product));
  PetscCall(hessian_.add_product(filtered_at_.data(), values, product));
  PetscCall(VecRestoreArray(products, &product));
  PetscCall(discretization_.add_to_global(products, Hp));
  PetscCall(DMRestoreLocalVector(dm, &products));
  PetscCall(discretization_.restore_local(&local, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::set_time(double time) {
  PetscFunctionBeginUser;
  for (const auto &term : terms_) PetscCall(term->set_time(time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::begin_step(const StepState &state) {
  PetscFunctionBeginUser;
  for (const auto &term : terms_) PetscCall(term->begin_step(state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::accept_step(Vec x) {
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  PetscFunctionBeginUser;
  PetscCall(discretization_.get_local(x, &local, &u));
  for (const auto &term : terms_) PetscCall(term->accept_step(u));
  PetscCall(discretization_.restore_local(&local, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::largest_step(Vec x, Vec d, double first, double *largest) const {
  Vec local = nullptr, local_d = nullptr;
  const PetscScalar *u = nullptr, *values = nullptr;
  PetscFunctionBeginUser;
  *largest = first;
  PetscCall(discretization_.get_local(x, &local, &u));
  PetscCall(discretization_.get_local_direction(d, &local_d, &values));
  for (const auto &term : terms_) {
    if (term->limits_step()) PetscCall(term->limit_step(u, values, first, largest));
  }
  PetscCall(discretization_.restore_local(&local_d, &values));
  PetscCall(discretization_.restore_local(&local, &u));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 1, MPI_DOUBLE, MPI_MIN,
                             PetscObjectComm(reinterpret_cast<PetscObject>(x))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::largest_move(Vec d, double *largest) const {
  const std::size_t size = discretization_.mesh().coordinates.size();
  Vec local = nullptr;
  const PetscScalar *move = nullptr;
  PetscFunctionBeginUser;
  *largest = 0;
  PetscCall(discretization_.get_local_direction(d, &local, &move));
  for (std::size_t k = 0; k < size; k += 3) {
    *largest = std::max(*largest, std::hypot(move[k], move[k + 1], move[k + 2]));
  }
  PetscCall(discretization_.restore_local(&local, &move));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 1, MPI_DOUBLE, MPI_MAX,
                             PetscObjectComm(reinterpret_cast<PetscObject>(d))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::unique_ptr<EnergyFunctional> EnergyFunctional::spreading(Spreading kind) const {
  auto other = std::make_unique<EnergyFunctional>(discretization_);
  for (const auto &term : terms_) {
    if (auto spreading = term->spreading(kind)) other->add_term(std::move(spreading));
  }
  other->hessian_.share_places(hessian_);
  return other;
}

PetscErrorCode EnergyFunctional::describe_cells(Vec x, CellReport *report,
                                                bool counts_negative) const {
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  PetscFunctionBeginUser;
  const auto cells = static_cast<std::size_t>(discretization_.mesh().local_cells());
  report->determinant.assign(cells, 1);
  report->energy_density.assign(cells, 0);
  report->negative_eigenvalues.clear();
  PetscCall(discretization_.get_local(x, &local, &u));
  for (const auto &term : terms_) {
    term->describe_cells(u, report->determinant.data(), report->energy_density.data());
  }
  if (counts_negative) PetscCall(hessian_.count_negative(u, &report->negative_eigenvalues));
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
  double sum = hessian_.bytes();
  for (const auto &term : terms_) sum += term->bytes();
  return sum;
}

}  // namespace trefoil
