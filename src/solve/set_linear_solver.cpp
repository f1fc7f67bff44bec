#include "solve/set_linear_solver.hpp"

#include <petscpc.h>

#include <algorithm>
#include <array>

#include "scene/body_materials.hpp"
#include "scene/element_pressure.hpp"
#include "scene/scene.hpp"
#include "solve/multigrid.hpp"
#include "support/free_memory.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

namespace trefoil {
namespace {

PetscErrorCode is_set(const char *option, bool *set) {
  PetscBool found = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(nullptr, nullptr, option, &found));
  *set = found == PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A default for one of PETSc's own options; only third-party factors have some.
[[maybe_unused]] PetscErrorCode set_unless_given(const char *option, const char *value) {
  bool given = false;
  PetscFunctionBeginUser;
  PetscCall(is_set(option, &given));
  if (!given) PetscCall(PetscOptionsSetValue(nullptr, option, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What the user gives of one of PETSc's own options; empty: nothing.
PetscErrorCode text_of_user(const char *option, std::string *text) {
  std::array<char, 64> given{};
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetString(nullptr, nullptr, option, given.data(), given.size(), nullptr));
  *text = given.data();
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool is_of_factors(const std::string &preconditioner) {
  return preconditioner == PCCHOLESKY || preconditioner == PCLU;
}

/// The package that factors a matrix unless the user names one; empty: PETSc's choice.
std::string package_of([[maybe_unused]] const std::string &preconditioner,
                       [[maybe_unused]] PetscMPIInt ranks, [[maybe_unused]] bool is_definite) {
#if defined(PETSC_HAVE_SUITESPARSE)
  if (preconditioner == PCCHOLESKY && ranks == 1 && is_definite) return MATSOLVERCHOLMOD;
#endif
#if defined(PETSC_HAVE_MUMPS)
  return MATSOLVERMUMPS;
#else
  return "";
#endif
}

/// What a package is told unless the user tells it otherwise.
PetscErrorCode set_package(const std::string &package, [[maybe_unused]] bool may_be_indefinite,
                           PC pc) {
  PetscFunctionBeginUser;
  if (!package.empty()) PetscCall(PCFactorSetMatSolverType(pc, package.c_str()));
#if defined(PETSC_HAVE_SUITESPARSE)
  if (package == MATSOLVERCHOLMOD) {
    // Its other factors exist for indefinite matrices as well. These tell whether a point is a
    // minimum, and that it is none is an answer, not worth a warning.
    PetscCall(set_unless_given("-mat_cholmod_factor", "SUPERNODAL"));
    PetscCall(set_unless_given("-mat_cholmod_print", "0"));
  }
#endif
#if defined(PETSC_HAVE_MUMPS)
  if (package == MATSOLVERMUMPS) {
    // Negative pivots are counted, also those of the root, which several ranks would share.
    if (may_be_indefinite) PetscCall(set_unless_given("-mat_mumps_icntl_13", "1"));
    // Its own guess of the memory, 20 % more than the analysis says, is sometimes short of one
    // number.
    PetscCall(set_unless_given("-mat_mumps_icntl_14", "100"));
  }
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_direct(SNES snes, KSP ksp, PC pc) {
  std::string preconditioner, package;
  PetscMPIInt ranks = 0;
  PetscBool may_be_indefinite = PETSC_FALSE, retries = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(snes)), &ranks));
  PetscCall(TrefoilSNESJacobianMayBeIndefinite(snes, &may_be_indefinite));
  PetscCall(TrefoilSNESRetriesFactors(snes, &retries));
  PetscCall(text_of_user("-pc_type", &preconditioner));
  PetscCall(text_of_user("-pc_factor_mat_solver_type", &package));
  if (preconditioner.empty()) preconditioner = PCCHOLESKY;
  if (package.empty()) package = package_of(preconditioner, ranks, !may_be_indefinite || retries);
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(PCSetType(pc, preconditioner.c_str()));
  PetscCall(set_package(package, may_be_indefinite, pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether the scene has linear elements under its own, with a matrix of the cells' pattern.
bool has_two_orders(const Scene &scene) {
  return is_quadratic(*scene.mesh.shape) && !scene.spreading;
}

PetscErrorCode set_iterative(const Scene &scene, KSP ksp, PC pc) {
  std::string users;
  PetscFunctionBeginUser;
  PetscCall(text_of_user("-pc_type", &users));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetTolerances(ksp, 1e-1, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
  if (has_two_orders(scene) && users != PCGAMG) {
    PetscCall(set_p_multigrid(scene.discretization, scene.hessian, pc));
  } else {
    PetscCall(set_aggregation(pc));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Conjugate gradients as exact as a preconditioner of any quality needs to be trusted.
PetscErrorCode set_users(KSP ksp) {
  PetscFunctionBeginUser;
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetTolerances(ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 2000));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Refuses a package that the user names and that has no such factors: PETSc's sentence names no
/// way out.
PetscErrorCode check_package(const Scene &scene, const std::string &preconditioner) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
  const bool is_lu = preconditioner == PCLU;
  std::string package;
  PetscMPIInt ranks = 0;
  PetscBool exists = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(text_of_user("-pc_factor_mat_solver_type", &package));
  if (package.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(MatGetFactorAvailable(scene.hessian, package.c_str(),
                                  is_lu ? MAT_FACTOR_LU : MAT_FACTOR_CHOLESKY, &exists));
  PetscCheck(exists, comm, PETSC_ERR_USER_INPUT,
             "-pc_factor_mat_solver_type %s: there are no %s factors of that name on %d rank%s; "
             "without the option they are those of %s",
             package.c_str(), is_lu ? "LU" : "Cholesky", ranks, ranks == 1 ? "" : "s",
             package_of(is_lu ? PCLU : PCCHOLESKY, ranks, true).c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

double largest_poisson(const SceneOptions &options) {
  double largest = -1;
  for (const MaterialOptions &material : materials_of_cells(options)) {
    largest = std::max(largest, poisson_at_rest(material));
  }
  return largest;
}

PetscErrorCode describe_task(const Scene &scene, SolverTask *task) {
  const Mesh &mesh = scene.mesh;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscMPIInt ranks = 0;
  MatInfo info;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  task->cells = mesh.total_cells;
  task->cell = mesh.dimension() == 3 ? "tetrahedra" : "triangles";
  task->order = mesh.shape->order;
  task->poisson = largest_poisson(scene.options);
  task->one_pressure = element_pressure(scene.options) == ElementPressure::constant;
  task->ranks = ranks;
#if !defined(PETSC_HAVE_MUMPS)
  task->can_factor = ranks == 1;
#endif
  PetscCall(estimate_factor(scene.discretization, &task->factor));
  PetscCall(free_memory(comm, &task->free_bytes));
  PetscCall(MatGetInfo(scene.hessian, MAT_GLOBAL_SUM, &info));
  // N, of the Hessian's pattern.
  task->other_bytes =
      info.nz_allocated * static_cast<double>(sizeof(PetscScalar) + sizeof(PetscInt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode choose_linear_solver(const Scene &scene, SolverChoice *choice) {
  const std::string &wish = scene.options.solver;
  std::string users;
  SolverTask task;
  PetscFunctionBeginUser;
  PetscCall(text_of_user("-pc_type", &users));
  if (users.empty()) {
    PetscCall(describe_task(scene, &task));
    *choice = choose_solver(task, wish);
  } else {
    const bool ours = users == PCGAMG || (users == PCMG && has_two_orders(scene));
    choice->kind = is_of_factors(users) ? SolverKind::direct
                   : ours               ? SolverKind::iterative
                                        : SolverKind::users;
    choice->reason = "as -pc_type says";
    if (wish != "auto" && (wish == "direct") != is_of_factors(users)) {
      choice->reason += ", which wins over -solver " + wish;
    }
  }
  if (choice->kind == SolverKind::direct) PetscCall(check_package(scene, users));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_defaults_of_linear_solver(const SolverChoice &choice, SNES snes) {
  KSP ksp = nullptr;
  PC pc = nullptr;
  PetscFunctionBeginUser;
  // The types come later, and so do their options: PETSc's own default would take them for its own.
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCNONE));
  if (choice.kind != SolverKind::iterative) PetscFunctionReturn(PETSC_SUCCESS);
  // A solve to a tenth is as cheap beside a set-up as one with factors beside a factorisation.
  PetscCall(TrefoilSNESSetCorrections(snes, 8));
  // What is left of the energy after an inexact direction is worth a step.
  PetscCall(TrefoilSNESSetTakeLast(snes, PETSC_TRUE));
  PetscCall(TrefoilSNESSetVerifyShare(snes, 0.05));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_linear_solver(const Scene &scene, SNES snes) {
  KSP ksp = nullptr;
  PC pc = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  switch (scene.linear_solver.kind) {
    case SolverKind::direct:
      PetscCall(set_direct(snes, ksp, pc));
      break;
    case SolverKind::iterative:
      PetscCall(set_iterative(scene, ksp, pc));
      break;
    case SolverKind::users:
      PetscCall(set_users(ksp));
      break;
  }
  PetscCall(KSPSetFromOptions(ksp));
  if (scene.linear_solver.kind == SolverKind::iterative) PetscCall(set_large_aggregates(pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
