#include "scene/state_report.hpp"

#include <cmath>
#include <limits>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

MPI_Comm comm_of(const Scene &scene) {
  return PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
}

/// Makes the largest of all ranks' values everybody's. Collective.
PetscErrorCode share_largest(MPI_Comm comm, Extreme *extreme) {
  struct {
    double value;
    int rank;
  } best{extreme->value, 0};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &best.rank));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &best, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm));
  extreme->value = best.value;
  PetscCallMPI(MPI_Bcast(extreme->at.data(), 3, MPI_DOUBLE, best.rank, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds up the reactions of the vertices that each constraint holds, and their moments about the
/// origin where the vertices are now.
PetscErrorCode add_up_reactions(const Scene &scene, const double *u,
                                std::vector<Resultant> *reactions) {
  const Mesh &mesh = scene.mesh;
  const std::vector<int> &holder = scene.constraints.holder();
  std::vector<double> force;
  PetscFunctionBeginUser;
  PetscCall(reactions_of_vertices(scene, &force));
  std::vector<double> sums(6 * scene.constraints.reports().size(), 0);
  const auto add = [&](std::size_t first, std::array<double, 3> f, int which) {
    if (which < 0) return;
    double *sum = &sums[6 * static_cast<std::size_t>(which)];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, l = (i + 2) % 3;
      sum[i] += f[i];
      sum[3 + i] += (mesh.coordinates[first + j] + u[first + j]) * f[l] -
                    (mesh.coordinates[first + l] + u[first + l]) * f[j];
    }
  };
  for (std::size_t k = 0; k < force.size(); ++k) {
    std::array<double, 3> along{};
    along[k % 3] = force[k];
    add(k - k % 3, along, holder[k]);
  }
  for (const TurnedVertex &turned : scene.discretization.turned()) {
    const auto first = static_cast<std::size_t>(3 * turned.vertex);
    std::array<double, 3> f{force[first], force[first + 1], force[first + 2]};
    turned.to_axes(f.data());
    for (std::size_t j = 0; j < static_cast<std::size_t>(turned.held); ++j) {
      std::array<double, 3> along = turned.axes[j];
      for (double &component : along) component *= f[j];
      add(first, along, turned.holder[j]);
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<PetscMPIInt>(sums.size()),
                             MPI_DOUBLE, MPI_SUM, comm_of(scene)));
  reactions->clear();
  for (std::size_t k = 0; k < sums.size(); k += 6) {
    reactions->push_back(
        {{sums[k], sums[k + 1], sums[k + 2]}, {sums[k + 3], sums[k + 4], sums[k + 5]}});
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode find_largest_displacement(const Scene &scene, const double *u, Extreme *largest) {
  PetscFunctionBeginUser;
  *largest = {-1, {}};
  for (std::size_t v = 0; v < scene.mesh.owned.size(); ++v) {
    const double length = std::hypot(u[3 * v], u[3 * v + 1], u[3 * v + 2]);
    if (!scene.mesh.owned[v] || !(length > largest->value)) continue;
    const double *p = &scene.mesh.coordinates[3 * v];
    *largest = {length, {p[0], p[1], p[2]}};
  }
  PetscCall(share_largest(comm_of(scene), largest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Extremes over the cells, at their centroids, and the volume.
PetscErrorCode look_at_cells(const Scene &scene, const double *u, StateReport *state) {
  constexpr double least = -std::numeric_limits<double>::max();
  Extreme minus_determinant{least, {}}, stress{least, {}};
  PetscFunctionBeginUser;
  state->volume = 0;
  scene.cells->visit(u, [&](std::size_t c, const CellState &cell) {
    const double equivalent = von_mises(cell.cauchy);
    state->volume += cell.deformed_volume;
    if (equivalent > stress.value) stress = {equivalent, centroid_of_cell(scene.mesh, c)};
    if (-cell.least_determinant > minus_determinant.value) {
      minus_determinant = {-cell.least_determinant, centroid_of_cell(scene.mesh, c)};
    }
  });
  PetscCall(share_largest(comm_of(scene), &minus_determinant));
  PetscCall(share_largest(comm_of(scene), &stress));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &state->volume, 1, MPI_DOUBLE, MPI_SUM, comm_of(scene)));
  state->least_determinant = {-minus_determinant.value, minus_determinant.at};
  state->largest_von_mises = stress;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

std::vector<double> held_part(const Scene &scene, const std::vector<double> &forces) {
  const std::vector<PetscInt> &dofs = scene.discretization.global_dofs();
  std::vector<double> held(dofs.size(), 0);
  for (std::size_t k = 0; k < dofs.size(); ++k) held[k] = dofs[k] < 0 ? forces[k] : 0;
  for (const TurnedVertex &turned : scene.discretization.turned()) {
    const auto first = static_cast<std::size_t>(3 * turned.vertex);
    double force[3];
    std::copy_n(&forces[first], 3, force);
    turned.to_axes(force);
    for (int i = turned.held; i < 3; ++i) force[i] = 0;
    turned.to_space(force);
    std::copy_n(force, 3, &held[first]);
  }
  return held;
}

PetscErrorCode reactions_of_vertices(const Scene &scene, std::vector<double> *reactions) {
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  PetscFunctionBeginUser;
  PetscCall(scene.functional->nodal_gradient(scene.displacement, reactions));
  PetscCall(scene.discretization.get_local(scene.displacement, &local, &u));
  PetscCall(scene.loads.add_at_rims(u, reactions));
  PetscCall(scene.discretization.restore_local(&local, &u));
  *reactions = held_part(scene, *reactions);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode describe_state(Scene &scene, double t, StateReport *state) {
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  EnergySums sums;
  double energy_rest = 0;
  std::vector<LoadReport> loads;
  PetscFunctionBeginUser;
  state->t = t;
  PetscCall(scene.functional->energy(scene.displacement, &sums));
  PetscCall(scene.functional->energy_at_rest(&energy_rest));
  PetscCall(scene.discretization.get_local(scene.displacement, &local, &u));
  PetscCall(add_up_reactions(scene, u, &state->reactions));
  PetscCall(scene.loads.report(t, u, &loads));
  PetscCall(scene.loads.work(t, u, &state->load_work));
  PetscCall(find_largest_displacement(scene, u, &state->largest_displacement));
  PetscCall(look_at_cells(scene, u, state));
  PetscCall(scene.probes.report(u, &state->probes));
  state->contact.reset();
  if (scene.contact) {
    ContactReport contact;
    PetscCall(scene.contact->report(u, &contact));
    state->contact = {.energy = contact.energy,
                      .least_gap = contact.gap,
                      .distance = scene.contact->parameters().distance,
                      .stiffening = contact.stiffening,
                      .pairs = contact.pairs,
                      .friction_iterations = contact.friction_solves,
                      .friction_force = contact.friction_force,
                      .friction_change = contact.friction_change};
    for (const auto &[name, force] : contact.obstacle_forces) {
      state->contact->obstacles.push_back({name, {force.x, force.y, force.z}});
    }
  }
  PetscCall(scene.discretization.restore_local(&local, &u));
  state->energy = sums.energy + energy_rest;
  state->strain_energy = sums.strain_energy;
  if (scene.motion) {  // there is inertia in the sums
    MotionReport motion;
    PetscCall(scene.motion->report(&motion));
    state->motion = motion;
    state->energy = energy_rest + sums.strain_energy - state->load_work;
  }
  state->loads.clear();
  for (const LoadReport &load : loads) state->loads.push_back(load.resultant);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
