// Backward Euler against PETSc's own: TSBEULER on (u, v) with stock Newton. Needs petsc_main.cpp.

#include <gtest/gtest.h>
#include <petscts.h>

#include <algorithm>
#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "solve/solve.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil::test {
namespace {

constexpr double step = 0.02;
constexpr int steps = 10;

const std::vector<std::pair<std::string, std::string>> options{
    {"mesh_generate", "box"},
    {"mesh_resolution", "2"},
    {"material_density", "1e3"},
    {"material_young", "2e4"},
    {"constraints", "wall"},
    {"constraint_wall_where", "x == xmin"},
    {"load_gravity", "0, 0, -9.81"},
    {"initial_velocity", "0, 2*x, 0"},
    {"time_end", "0.2"},
    {"time_step", "0.02"},
    {"time_velocity_tolerance", "0"},
    {"snes_trefoil_energy_tolerance", "1e-26"},
    {"snes_trefoil_monitor", "false"}};

/// u' = v, M v' = -g(u), the unknowns u before v.
struct FirstOrder {
  Scene *scene = nullptr;
  Mat M = nullptr;
  Vec u = nullptr, v = nullptr, force = nullptr, product = nullptr;
};

PetscErrorCode residual(TS, PetscReal, Vec state, Vec rate, Vec F, void *context) {
  auto &system = *static_cast<FirstOrder *>(context);
  const PetscScalar *x = nullptr, *dx = nullptr, *force = nullptr, *inertia = nullptr;
  PetscScalar *f = nullptr, *u = nullptr, *v = nullptr;
  PetscInt n = 0;
  PetscFunctionBeginUser;
  PetscCall(VecGetSize(system.u, &n));
  PetscCall(VecGetArrayRead(state, &x));
  PetscCall(VecGetArrayRead(rate, &dx));
  PetscCall(VecGetArray(system.u, &u));
  PetscCall(VecGetArray(system.v, &v));
  std::copy_n(x, n, u);
  std::copy_n(dx + n, n, v);
  PetscCall(VecRestoreArray(system.u, &u));
  PetscCall(VecRestoreArray(system.v, &v));
  PetscCall(system.scene->functional->gradient(system.u, system.force));
  PetscCall(MatMult(system.M, system.v, system.product));
  PetscCall(VecGetArray(F, &f));
  PetscCall(VecGetArrayRead(system.force, &force));
  PetscCall(VecGetArrayRead(system.product, &inertia));
  for (PetscInt k = 0; k < n; ++k) {
    f[k] = dx[k] - x[n + k];
    f[n + k] = inertia[k] + force[k];
  }
  PetscCall(VecRestoreArrayRead(system.product, &inertia));
  PetscCall(VecRestoreArrayRead(system.force, &force));
  PetscCall(VecRestoreArray(F, &f));
  PetscCall(VecRestoreArrayRead(rate, &dx));
  PetscCall(VecRestoreArrayRead(state, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The terms' gradient without inertia, and M.
PetscErrorCode set_up(Scene &scene, FirstOrder *system) {
  const std::vector<double> zero(scene.mesh.coordinates.size(), 0);
  StepState state{.inertia_time = 1,
                  .predicted = zero.data(),
                  .velocity_time = 1,
                  .velocity_origin = zero.data()};
  PetscFunctionBeginUser;
  system->scene = &scene;
  PetscCall(scene.functional->begin_step(state));
  PetscCall(scene.functional->constant_hessian(scene.hessian));
  PetscCall(MatDuplicate(scene.hessian, MAT_COPY_VALUES, &system->M));
  state.inertia_time = 1e100;
  PetscCall(scene.functional->begin_step(state));
  for (Vec *vector : {&system->u, &system->v, &system->force, &system->product}) {
    PetscCall(VecDuplicate(scene.displacement, vector));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// PETSc's states after each step: u of the unknowns.
PetscErrorCode solve_by_petsc(FirstOrder &system, const std::vector<double> &velocity,
                              std::vector<double> *u) {
  const auto n = static_cast<PetscInt>(velocity.size());
  TS ts = nullptr;
  SNES snes = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  Vec state = nullptr;
  Mat J = nullptr;
  PetscScalar *x = nullptr;
  PetscFunctionBeginUser;
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, 2 * n, &state));
  PetscCall(VecGetArray(state, &x));
  std::copy(velocity.begin(), velocity.end(), x + n);
  PetscCall(VecRestoreArray(state, &x));
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, 2 * n, 2 * n, nullptr, &J));
  PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
  PetscCall(TSSetType(ts, TSBEULER));
  PetscCall(TSSetIFunction(ts, nullptr, residual, &system));
  PetscCall(TSGetSNES(ts, &snes));
  PetscCall(SNESSetJacobian(snes, J, J, SNESComputeJacobianDefault, nullptr));
  PetscCall(SNESSetTolerances(snes, 1e-9, 1e-14, 0, 50, 100000));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCLU));
  PetscCall(TSSetTimeStep(ts, step));
  PetscCall(TSSetMaxSteps(ts, steps));
  PetscCall(TSSetMaxTime(ts, 1));
  PetscCall(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
  PetscCall(TSSolve(ts, state));
  PetscCall(VecGetArray(state, &x));
  u->assign(x, x + n);
  PetscCall(VecRestoreArray(state, &x));
  PetscCall(TSDestroy(&ts));
  PetscCall(MatDestroy(&J));
  PetscCall(VecDestroy(&state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(TimePetscTest, TheSameStatesAsBackwardEulerOfPetsc) {
  for (const auto &[name, value] : options) {
    ASSERT_EQ(PetscOptionsSetValue(nullptr, ("-" + name).c_str(), value.c_str()), PETSC_SUCCESS);
  }
  SceneOptions read;
  Scene scene, other;
  SolveOutcome outcome;
  FirstOrder system;
  ASSERT_EQ(read_scene_options(PETSC_COMM_WORLD, &read), PETSC_SUCCESS);
  ASSERT_EQ(build_scene(PETSC_COMM_WORLD, read, &scene), PETSC_SUCCESS);
  ASSERT_EQ(build_scene(PETSC_COMM_WORLD, read, &other), PETSC_SUCCESS);
  std::vector<double> velocity;
  const auto &dofs = scene.discretization.global_dofs();
  const auto observe = [&](double t, PetscInt, bool) {
    PetscFunctionBeginUser;
    if (t > 0) PetscFunctionReturn(PETSC_SUCCESS);
    velocity.resize(static_cast<std::size_t>(scene.discretization.total_dofs()));
    for (std::size_t k = 0; k < dofs.size(); ++k) {
      if (dofs[k] >= 0) velocity[static_cast<std::size_t>(dofs[k])] = scene.motion->state().v[k];
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  };
  Checkpoint none(scene);
  ASSERT_EQ(solve_scene(scene, observe, none, &outcome), PETSC_SUCCESS);
  ASSERT_TRUE(outcome.converged);
  for (const auto &[name, value] : options) {
    ASSERT_EQ(PetscOptionsClearValue(nullptr, ("-" + name).c_str()), PETSC_SUCCESS);
  }
  std::vector<double> u;
  ASSERT_EQ(set_up(other, &system), PETSC_SUCCESS);
  ASSERT_EQ(solve_by_petsc(system, velocity, &u), PETSC_SUCCESS);
  const PetscScalar *ours = nullptr;
  double gap = 0, size = 0;
  ASSERT_EQ(VecGetArrayRead(scene.displacement, &ours), PETSC_SUCCESS);
  for (std::size_t k = 0; k < u.size(); ++k) {
    gap = std::max(gap, std::abs(u[k] - ours[k]));
    size = std::max(size, std::abs(u[k]));
  }
  ASSERT_EQ(VecRestoreArrayRead(scene.displacement, &ours), PETSC_SUCCESS);
  EXPECT_GT(size, 0.1);
  EXPECT_LT(gap, 1e-8 * size);
  ASSERT_EQ(MatDestroy(&system.M), PETSC_SUCCESS);
  for (Vec *vector : {&system.u, &system.v, &system.force, &system.product}) {
    ASSERT_EQ(VecDestroy(vector), PETSC_SUCCESS);
  }
}

}  // namespace
}  // namespace trefoil::test
