// A body that swings in one of its discrete modes, so little that it is linear: its amplitude and
// velocity follow the scalar recursion of each scheme. Needs petsc_main.cpp.

#include <gtest/gtest.h>
#include <petscksp.h>

#include <cmath>
#include <string>

#include "scene/scene.hpp"
#include "solve/solve.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

namespace trefoil::test {
namespace {

/// x'v of a scheme for u'' = -w^2 u.
struct Oscillator {
  std::string scheme;
  double w, u, v, u_before = 0, v_before = 0, dt_before = 0;

  void step(double dt) {
    const double u0 = u, v0 = v;
    if (scheme == "newmark") {
      const double a0 = -w * w * u0;
      u = (u0 + dt * v0 + dt * dt / 4 * a0) / (1 + w * w * dt * dt / 4);
      v = v0 + dt / 2 * (a0 - w * w * u);
      return;
    }
    const double r = scheme == "bdf2" && dt_before > 0 ? dt / dt_before : 0;
    const double c = dt * (1 + r) / (1 + 2 * r);
    const auto mix = [&](double now, double before) {
      return ((1 + r) * (1 + r) * now - r * r * before) / (1 + 2 * r);
    };
    const double uh = mix(u0, u_before), vh = mix(v0, v_before);
    u = (uh + c * vh) / (1 + w * w * c * c);
    v = (u - uh) / c;
    u_before = u0, v_before = v0, dt_before = dt;
  }
};

/// Options of a scene, gone with this.
class Options {
 public:
  void set(const std::string &name, const std::string &value) {
    names_.push_back("-" + name);
    static_cast<void>(PetscOptionsSetValue(nullptr, names_.back().c_str(), value.c_str()));
  }
  ~Options() {
    for (const std::string &name : names_) {
      static_cast<void>(PetscOptionsClearValue(nullptr, name.c_str()));
    }
  }

 private:
  std::vector<std::string> names_;
};

/// The lowest mode of K phi = w^2 M phi, |phi|_M = 1, by inverse iteration.
PetscErrorCode lowest_mode(Scene &scene, Vec phi, double *w) {
  const std::vector<double> zero(scene.mesh.coordinates.size(), 0);
  Mat K = nullptr, M = nullptr;
  Vec Mphi = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  TrefoilSplitStatistics ignored{};
  PetscReal square = 0;
  PetscFunctionBeginUser;
  const StepState rest{.inertia_time = 1,
                       .predicted = zero.data(),
                       .velocity_time = 1,
                       .velocity_origin = zero.data()};
  PetscCall(scene.functional->begin_step(rest));
  PetscCall(VecSet(scene.displacement, 0));
  PetscCall(scene.functional->constant_hessian(scene.hessian));
  PetscCall(MatDuplicate(scene.hessian, MAT_COPY_VALUES, &M));
  PetscCall(scene.functional->hessian(scene.displacement, scene.hessian, nullptr, &ignored));
  PetscCall(MatAXPY(scene.hessian, -1, M, SAME_NONZERO_PATTERN));
  PetscCall(MatDuplicate(scene.hessian, MAT_COPY_VALUES, &K));
  PetscCall(VecDuplicate(phi, &Mphi));
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &ksp));
  PetscCall(KSPSetOperators(ksp, K, K));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCCHOLESKY));
  PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  PetscCall(VecSet(phi, 1));
  for (int k = 0; k < 200; ++k) {
    PetscCall(MatMult(M, phi, Mphi));
    PetscCall(KSPSolve(ksp, Mphi, phi));
    PetscCall(MatMult(M, phi, Mphi));
    PetscCall(VecDot(phi, Mphi, &square));
    PetscCall(VecScale(phi, 1 / std::sqrt(square)));
  }
  PetscCall(MatMult(K, phi, Mphi));
  PetscCall(VecDot(phi, Mphi, &square));
  *w = std::sqrt(square);
  PetscCall(KSPDestroy(&ksp));
  PetscCall(VecDestroy(&Mphi));
  PetscCall(MatDestroy(&K));
  PetscCall(MatDestroy(&M));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void check_mode(const std::string &scheme, const std::string &order, const std::string &mass) {
  constexpr double amplitude = 3e-7;
  SCOPED_TRACE(scheme + ", order " + order + ", " + mass);
  Options options;
  for (const auto &[name, value] :
       std::vector<std::pair<std::string, std::string>>{{"mesh_generate", "square"},
                                                        {"mesh_resolution", "4"},
                                                        {"order", order},
                                                        {"material_density", "1e3"},
                                                        {"material_poisson", "0.3"},
                                                        {"constraints", "wall"},
                                                        {"constraint_wall_where", "x == xmin"},
                                                        {"time_end", "0.35"},
                                                        {"time_step", "0.01"},
                                                        {"time_integrator", scheme},
                                                        {"time_mass", mass},
                                                        {"time_velocity_tolerance", "0"},
                                                        {"snes_trefoil_energy_tolerance", "1e-20"},
                                                        {"snes_trefoil_monitor", "false"}}) {
    options.set(name, value);
  }
  SceneOptions read;
  Scene scene;
  SolveOutcome outcome;
  Vec phi = nullptr;
  double w = 0;
  ASSERT_EQ(read_scene_options(PETSC_COMM_WORLD, &read), PETSC_SUCCESS);
  ASSERT_EQ(build_scene(PETSC_COMM_WORLD, read, &scene), PETSC_SUCCESS);
  ASSERT_EQ(scene.discretization.create_vector(&phi), PETSC_SUCCESS);
  ASSERT_EQ(lowest_mode(scene, phi, &w), PETSC_SUCCESS);
  ASSERT_GT(w * 0.35, 3) << "the half of a period";
  ASSERT_EQ(VecCopy(phi, scene.displacement), PETSC_SUCCESS);
  ASSERT_EQ(VecScale(scene.displacement, amplitude), PETSC_SUCCESS);

  Oscillator oscillator{scheme, w, amplitude, 0};
  int steps = 0;
  const auto observe = [&](double t, PetscInt, bool) {
    MotionReport motion;
    Vec difference = nullptr;
    PetscReal size = 0, error = 0;
    PetscFunctionBeginUser;
    if (t > 0) oscillator.step(0.01), ++steps;
    PetscCall(VecDuplicate(phi, &difference));
    PetscCall(VecCopy(scene.displacement, difference));
    PetscCall(VecAXPY(difference, -oscillator.u, phi));
    PetscCall(VecNorm(difference, NORM_2, &error));
    PetscCall(VecNorm(phi, NORM_2, &size));
    EXPECT_LT(error / size, 1e-7 * amplitude) << "t = " << t;
    PetscCall(scene.motion->report(&motion));
    EXPECT_NEAR(std::sqrt(2 * motion.kinetic_energy), std::abs(oscillator.v), 1e-7 * amplitude * w)
        << "t = " << t;
    PetscCall(VecDestroy(&difference));
    PetscFunctionReturn(PETSC_SUCCESS);
  };
  Checkpoint none(scene);
  ASSERT_EQ(solve_scene(scene, observe, none, &outcome), PETSC_SUCCESS);
  EXPECT_TRUE(outcome.converged);
  EXPECT_EQ(steps, 35);
  ASSERT_EQ(VecDestroy(&phi), PETSC_SUCCESS);
}

TEST(TimeModeTest, AmplitudesFollowTheSchemes) {
  for (const char *scheme : {"backward_euler", "bdf2", "newmark"}) {
    check_mode(scheme, "1", "consistent");
    check_mode(scheme, "1", "lumped");
    check_mode(scheme, "2", "consistent");
  }
}

}  // namespace
}  // namespace trefoil::test
