#include "scene/moving_body.hpp"

#include <petscksp.h>

#include <algorithm>
#include <utility>

#include "input/expression.hpp"
#include "input/selection.hpp"
#include "scene/held_motion.hpp"
#include "scene/scene.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/damping_term.hpp"
#include "term/inertia_term.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

MPI_Comm comm_of(const Scene &scene) {
  return PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
}

/// An initial velocity at the rest positions of the local vertices. Throws InputError.
std::vector<double> evaluate_velocity(const std::string &text, const Mesh &mesh) {
  const std::string option = "-initial_velocity";
  const Expression formula(text, option, box_of(mesh));
  const auto dimension = static_cast<std::size_t>(mesh.dimension());
  std::vector<double> velocity(mesh.coordinates.size(), 0);
  for (std::size_t k = 0; k < velocity.size(); k += 3) {
    const std::vector<double> values = formula.evaluate(&mesh.coordinates[k], 0, dimension);
    if (std::any_of(values.begin(), values.end(), Expression::is_free)) {
      throw InputError(option + ": 'free' is for constraints; a velocity is a number");
    }
    std::copy(values.begin(), values.end(), velocity.begin() + static_cast<std::ptrdiff_t>(k));
  }
  return velocity;
}

}  // namespace

MovingBody::MovingBody(Scene &scene) : scene_(scene), integrator_(scene.options.time.scheme()) {}

MovingBody::~MovingBody() {
  static_cast<void>(VecDestroy(&stand_));  // an error has nowhere to go from here
}

PetscErrorCode MovingBody::check_masses(const std::vector<int> &region_of_cell) const {
  const MPI_Comm comm = comm_of(scene_);
  const SceneOptions &options = scene_.options;
  const auto &regions = options.regions;
  std::vector<int> has_cells(1 + regions.size(), 0);
  PetscFunctionBeginUser;
  for (const int region : region_of_cell) has_cells[static_cast<std::size_t>(region)] = 1;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, has_cells.data(),
                             static_cast<PetscMPIInt>(has_cells.size()), MPI_INT, MPI_MAX, comm));
  PetscCheck(options.material.density > 0 || !has_cells[0], comm, PETSC_ERR_USER_INPUT,
             "in time a body needs mass: give -material_density");
  for (std::size_t r = 0; r < regions.size(); ++r) {
    PetscCheck(regions[r].material.density > 0, comm, PETSC_ERR_USER_INPUT,
               "in time every part of the body needs mass: region '%s' has density 0; give "
               "-region_%s_material_density",
               regions[r].name.c_str(), regions[r].name.c_str());
  }
  PetscCheck(options.time.mass == "consistent" ||
                 scene_.mesh.nodes_per_cell() == scene_.mesh.dimension() + 1,
             comm, PETSC_ERR_USER_INPUT,
             "-time_mass lumped is for linear cells: the row sums of quadratic ones are not "
             "positive; leave it out, or take -order 1");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::set_up(const std::vector<int> &region_of_cell) {
  const SceneOptions &options = scene_.options;
  const PackedElements *cells = scene_.functional->cells();
  std::vector<double> density_of_cell;
  PetscFunctionBeginUser;
  PetscCall(check_masses(region_of_cell));
  for (const int region : region_of_cell) {
    const auto &material = region == 0
                               ? options.material
                               : options.regions[static_cast<std::size_t>(region - 1)].material;
    density_of_cell.push_back(material.density);
  }
  const MassKind kind = options.time.mass == "lumped" ? MassKind::lumped : MassKind::consistent;
  mass_ = std::make_shared<MassMatrix>(scene_.mesh, std::move(density_of_cell), kind);
  scene_.functional->add_term(
      std::make_unique<InertiaTerm>(mass_, cells->elements(), options.time.damping_mass));
  if (options.time.damping_stiffness > 0) {
    scene_.functional->add_term(std::make_unique<DampingTerm>(
        *cells, scene_.mesh.coordinates.size(), options.time.damping_stiffness));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::set_time(double time) {
  HeldDofs held;
  PetscFunctionBeginUser;
  PetscCall(scene_.constraints.hold(time, &held));
  PetscCall(scene_.discretization.set_prescribed(held));
  PetscCall(scene_.functional->set_time(time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::hold(double time, double length, HeldMotion *motion) {
  PetscFunctionBeginUser;
  PetscCall(find_held_motion(scene_.constraints, *scene_.options.time.end, time, length, motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::hold_start() {
  PetscFunctionBeginUser;
  PetscCall(hold(0, *scene_.options.time.step, &held_at_start_));
  PetscCall(set_time(0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::set_initial_velocity(std::vector<double> *velocity) const {
  const std::string &formula = scene_.options.time.initial_velocity;
  PetscFunctionBeginUser;
  velocity->assign(scene_.mesh.coordinates.size(), 0);
  if (!formula.empty()) {
    const std::string complaint =
        complaint_of([&] { *velocity = evaluate_velocity(formula, scene_.mesh); });
    PetscCall(agree_on_complaint(comm_of(scene_), complaint));
  }
  for (std::size_t k = 0; k < velocity->size(); ++k) {
    if (held_at_start_.held[k]) (*velocity)[k] = held_at_start_.at_end.v[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::start() {
  Motion state;
  PetscFunctionBeginUser;
  if (!stand_) PetscCall(VecDuplicate(scene_.displacement, &stand_));
  PetscCall(VecCopy(scene_.displacement, stand_));
  PetscCall(scene_.discretization.copy_local(scene_.displacement, &state.u));
  PetscCall(set_initial_velocity(&state.v));
  state.a.assign(state.u.size(), 0);
  for (std::size_t k = 0; k < state.u.size(); ++k) {
    if (held_at_start_.held[k]) state.a[k] = held_at_start_.at_end.a[k];
  }
  integrator_.start(0, std::move(state));
  PetscCall(scene_.functional->accept_step(scene_.displacement));
  PetscCall(balance());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Tells the terms of a step without length, in which the state has its velocity and acceleration:
/// the gradient is what is left of the forces, inertia and damping included.
PetscErrorCode MovingBody::balance() {
  const Motion &state = integrator_.state();
  std::vector<double> predicted(state.u), origin(state.u);
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < predicted.size(); ++k) {
    predicted[k] -= state.a[k];
    origin[k] -= state.v[k];
  }
  PetscCall(scene_.functional->begin_step({.time = 0,
                                           .step = 0,
                                           .inertia_time = 1,
                                           .predicted = predicted.data(),
                                           .velocity_time = 1,
                                           .velocity_origin = origin.data()}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::accelerate() {
  Motion state = integrator_.state();
  PetscFunctionBeginUser;
  PetscCall(solve_for_acceleration(&state.a));
  integrator_.start(0, std::move(state));
  PetscCall(balance());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::go_on(double time, Motion state, Motion previous, double previous_step) {
  PetscFunctionBeginUser;
  PetscCall(set_time(time));
  if (!stand_) PetscCall(VecDuplicate(scene_.displacement, &stand_));
  PetscCall(VecCopy(scene_.displacement, stand_));
  time_of_stand_ = time;
  integrator_.resume(time, std::move(state), std::move(previous), previous_step);
  PetscCall(scene_.functional->accept_step(scene_.displacement));
  PetscCall(balance());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds to accelerations what balances the forces on the unknowns.
PetscErrorCode MovingBody::solve_for_acceleration(std::vector<double> *acceleration) const {
  Mat mass = scene_.hessian;
  Vec forces = nullptr, found = nullptr, local = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  const PetscScalar *values = nullptr;
  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(scene_.displacement, &forces));
  PetscCall(VecDuplicate(scene_.displacement, &found));
  PetscCall(scene_.functional->gradient(scene_.displacement, forces));
  // The functional's constant part is (1 + alpha) M, see balance().
  PetscCall(VecScale(forces, -(1 + scene_.options.time.damping_mass)));
  PetscCall(scene_.functional->constant_hessian(mass));
  PetscCall(KSPCreate(comm_of(scene_), &ksp));
  PetscCall(KSPSetOptionsPrefix(ksp, "acceleration_"));
  PetscCall(KSPSetOperators(ksp, mass, mass));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetTolerances(ksp, 1e-14, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCJACOBI));
  PetscCall(KSPSolve(ksp, forces, found));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  PetscCheck(reason > 0, comm_of(scene_), PETSC_ERR_CONV_FAILED,
             "the accelerations at t = 0 were not found: the mass matrix is nearly singular; check "
             "the mesh for flat cells and the regions' densities");
  PetscCall(scene_.discretization.get_local_direction(found, &local, &values));
  for (std::size_t k = 0; k < acceleration->size(); ++k) (*acceleration)[k] += values[k];
  PetscCall(scene_.discretization.restore_local(&local, &values));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(VecDestroy(&forces));
  PetscCall(VecDestroy(&found));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::begin_step(double length, double time) {
  HeldMotion held;
  PetscFunctionBeginUser;
  PetscCall(hold(time, length, &held));
  PetscCall(set_time(time));
  PetscCall(scene_.functional->begin_step(integrator_.begin(length, held)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::accept(double time) {
  std::vector<double> u;
  PetscFunctionBeginUser;
  PetscCall(scene_.functional->accept_step(scene_.displacement));
  PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
  integrator_.accept(u.data());
  PetscCall(VecCopy(scene_.displacement, stand_));
  time_of_stand_ = time;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::go_back() {
  PetscFunctionBeginUser;
  PetscCall(set_time(time_of_stand_));
  PetscCall(VecCopy(stand_, scene_.displacement));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MovingBody::report(MotionReport *report) const {
  const std::vector<double> &X = scene_.mesh.coordinates;
  const auto &[u, v, a] = integrator_.state();
  std::vector<double> momentum(v.size(), 0);
  double sums[7] = {};  // twice the kinetic energy, momentum, angular momentum
  PetscFunctionBeginUser;
  mass_->add_product(1, v.data(), momentum.data());
  sums[0] = dot(v, momentum);
  for (std::size_t k = 0; k < v.size(); k += 3) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, l = (i + 2) % 3;
      sums[1 + i] += momentum[k + i];
      sums[4 + i] +=
          (X[k + j] + u[k + j]) * momentum[k + l] - (X[k + l] + u[k + l]) * momentum[k + j];
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 7, MPI_DOUBLE, MPI_SUM, comm_of(scene_)));
  *report = {integrator_.previous_step(),
             sums[0] / 2,
             {sums[1], sums[2], sums[3]},
             {sums[4], sums[5], sums[6]}};
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
