#include "solve/start_check.hpp"

#include <array>
#include <cmath>

#include "scene/unknown_options.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Refuses options that nothing has used so far. Where every displacement is zero, or the run goes
/// on from another, no solver of the guess was there to use them, and they are not wrong.
PetscErrorCode check_tuning(const Scene &scene) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
  PetscReal moved = 0;
  PetscFunctionBeginUser;
  PetscCall(refuse_unused(comm, {"snes_linesearch_"}));
  if (!scene.options.checkpoint.restart_file.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecNorm(scene.displacement, NORM_INFINITY, &moved));
  if (moved > 0 || scene.options.initial == "rest") PetscCall(refuse_unused(comm, {"guess_"}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode check_start(const Scene &scene, double energy) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
  constexpr double beyond_bodies = 1e100;  // of a determinant: numbers too large to be squared
  PetscMPIInt rank = 0, ranks = 0, speaker = 0;
  PetscInt64 counts[2] = {0, 0};  // inverted elements of infinite energy, and others of it
  std::array<double, 3> first{};
  EnergyFunctional::CellReport report;
  PetscFunctionBeginUser;
  PetscCall(check_tuning(scene));
  if (std::isfinite(energy)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(scene.functional->describe_cells(scene.displacement, &report, false));
  for (std::size_t c = 0; c < report.energy_density.size(); ++c) {
    if (std::isfinite(report.energy_density[c])) continue;
    const bool inverted = report.determinant[c] <= 0 && report.determinant[c] > -beyond_bodies;
    if (counts[0] + counts[1] == 0) first = centroid_of_cell(scene.mesh, c);
    ++counts[inverted ? 0 : 1];
  }
  speaker = counts[0] + counts[1] ? rank : ranks;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &speaker, 1, MPI_INT, MPI_MIN, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPIU_INT64, MPI_SUM, comm));
  if (speaker < ranks) PetscCallMPI(MPI_Bcast(first.data(), 3, MPI_DOUBLE, speaker, comm));
  PetscCheck(counts[0] > 0 && counts[1] == 0, comm, PETSC_ERR_USER_INPUT,
             "the energy of the start is not finite; check the constraints' displacements and the "
             "loads");
  const bool at_once = scene.options.initial == "rest";
  const PetscInt steps = number_of_load_steps(scene.options);
  const std::string in_steps = scene.motion ? std::string("let them begin at 0, in t")
                               : steps > 1  ? "take more -load_steps than " + std::to_string(steps)
                                            : std::string("apply the displacements in -load_steps");
  SETERRQ(comm, PETSC_ERR_USER_INPUT,
          "the energy of the start is infinite: %s %lld elements, the first at rest position (%g, "
          "%g, %g), which the material does not allow; %s%s, or "
          "take a material that allows it, such as stable_neo_hookean",
          at_once ? "the prescribed vertices, moved at once, invert" : "it inverts",
          static_cast<long long>(counts[0]), first[0], first[1], first[2],
          at_once ? "spread the displacements with -initial harmonic or -initial arap, " : "",
          in_steps.c_str());
}

}  // namespace trefoil
