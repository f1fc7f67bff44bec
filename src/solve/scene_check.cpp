#include "solve/scene_check.hpp"

#include <sys/resource.h>

#include <array>
#include <cmath>
#include <string>

#include "solve/solve.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

MPI_Comm comm_of(const Scene &scene) {
  return PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
}

std::string format(const char *pattern, double value) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), pattern, value);
  return text.data();
}

std::string megabytes(double bytes) {
  return format(bytes < 1e7 ? "%.2g MB" : "%.0f MB", bytes / 1e6);
}

PetscErrorCode print_mesh(const Scene &scene) {
  constexpr const char *members[] = {"points", "edges", "facets", "cells"};
  const Mesh &mesh = scene.mesh;
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(comm_of(scene),
                        "box: [%g, %g] x [%g, %g] x [%g, %g]; %" PetscInt_FMT " unknowns\n",
                        mesh.box_min[0], mesh.box_max[0], mesh.box_min[1], mesh.box_max[1],
                        mesh.box_min[2], mesh.box_max[2], scene.discretization.total_dofs()));
  for (const Group &group : mesh.groups.list()) {
    const bool of_edges = group.dimension == 1 && mesh.dimension() == 2;
    PetscCall(PetscPrintf(comm_of(scene), "group: %s, %" PetscInt_FMT " %s\n",
                          text_of(group).c_str(), group.count,
                          of_edges ? "facets"
                          : group.dimension == mesh.dimension()
                              ? "cells"
                              : members[static_cast<std::size_t>(group.dimension)]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode print_moments(const Scene &scene) {
  PetscFunctionBeginUser;
  for (const LoadReport &load : scene.load_reports) {
    const auto &moment = load.resultant.moment;
    PetscCall(PetscPrintf(comm_of(scene), "%s: moment about the origin (%.6g, %.6g, %.6g)\n",
                          load.name.c_str(), moment[0], moment[1], moment[2]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// "stable_neo_hookean, E 1e+06, nu 0.45, mu ..., lambda ..., bulk modulus ..., density 0"
std::string text_of(const MaterialOptions &material) {
  const ElasticConstants &constants = material.parameters.constants;
  const double mu = constants.mu(), lambda = constants.lambda();
  return material.model + ", E " + format("%.6g", constants.young) + ", nu " +
         format("%.6g", constants.poisson) + ", mu " + format("%.6g", mu) + ", lambda " +
         format("%.6g", lambda) + ", bulk modulus " + format("%.6g", lambda + 2 * mu / 3) +
         ", density " + format("%.6g", material.density);
}

/// "to t = 1 in steps of 0.02 by newmark, mass consistent, Rayleigh damping 0 and 0.001"
std::string text_of(const TimeOptions &time) {
  std::string text = "to t = " + format("%.6g", *time.end) + " in steps of " +
                     format("%.6g", *time.step) + " by " + time.integrator + ", mass " + time.mass;
  if (time.damping_mass > 0 || time.damping_stiffness > 0) {
    text += ", Rayleigh damping " + format("%.6g", time.damping_mass) + " and " +
            format("%.6g", time.damping_stiffness);
  }
  return text;
}

PetscErrorCode print_materials(const Scene &scene) {
  PetscFunctionBeginUser;
  for (const RegionReport &region : scene.regions) {
    const MaterialOptions *material = &scene.options.material;
    for (const RegionOptions &options : scene.options.regions) {
      if (options.name == region.name) material = &options.material;
    }
    PetscCall(PetscPrintf(comm_of(scene), "%s: %lld cells, %s %.6g, mass %.6g; %s\n",
                          region.name.c_str(), static_cast<long long>(region.cells),
                          scene.mesh.dimension() == 2 ? "area" : "volume", region.volume,
                          region.mass, text_of(*material).c_str()));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Bytes of the matrices H and N, of all ranks: a number and a column an entry.
PetscErrorCode bytes_of_matrices(const Scene &scene, double *bytes) {
  MatInfo info;
  PetscFunctionBeginUser;
  PetscCall(MatGetInfo(scene.hessian, MAT_GLOBAL_SUM, &info));
  *bytes = 2 * info.nz_allocated * static_cast<double>(sizeof(PetscScalar) + sizeof(PetscInt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode print_solver(Scene &scene) {
  const std::string &steps = scene.options.load_steps;
  LinearSolver solver;
  double matrices = 0;
  struct rusage usage;
  PetscFunctionBeginUser;
  PetscCall(expect_linear_solver(scene, &solver));
  PetscCall(bytes_of_matrices(scene, &matrices));
  getrusage(RUSAGE_SELF, &usage);
  double now = 1024. * static_cast<double>(usage.ru_maxrss);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &now, 1, MPI_DOUBLE, MPI_SUM, comm_of(scene)));
  if (scene.motion) {
    PetscCall(PetscPrintf(comm_of(scene), "solver: %s; %s\n", solver.text.c_str(),
                          text_of(scene.options.time).c_str()));
  } else {
    PetscCall(PetscPrintf(comm_of(scene), "solver: %s; load steps: %s\n", solver.text.c_str(),
                          steps == "1" ? "none" : steps.c_str()));
  }
  PetscCall(PetscPrintf(
      comm_of(scene), "memory to expect: %s, of which matrices %s%s\n",
      megabytes(now + matrices + solver.factor_bytes).c_str(), megabytes(matrices).c_str(),
      solver.factor_bytes > 0 ? (", factor " + megabytes(solver.factor_bytes)).c_str() : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode print_scene_check(Scene &scene) {
  PetscFunctionBeginUser;
  PetscCall(print_mesh(scene));
  PetscCall(print_moments(scene));
  PetscCall(print_materials(scene));
  PetscCall(print_solver(scene));
  PetscCall(PetscPrintf(comm_of(scene), "the scene is complete; nothing was solved\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
