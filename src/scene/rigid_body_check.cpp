#include <petscsys.h>

// PETSc's names for LAPACK need the types of the header above.
#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "scene/constraints.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr int modes = 6;

/// Gram matrices of the rigid-body modes over the held dofs, one for each connected part: a mode
/// that the held dofs do not see is in its null space. Lengths are in units of `size`.
std::vector<double> gram_matrices(const Mesh &mesh, const HeldDofs &held,
                                  const std::vector<PetscInt> &part, PetscInt parts, double size) {
  std::array<double, 3> centre{};
  for (std::size_t i = 0; i < 3; ++i) centre[i] = 0.5 * (mesh.box_min[i] + mesh.box_max[i]);
  std::vector<double> gram(static_cast<std::size_t>(parts) * modes * modes, 0);
  for (std::size_t v = 0; v < part.size(); ++v) {
    if (!mesh.owned[v]) continue;
    double *G = &gram[static_cast<std::size_t>(part[v]) * modes * modes];
    for (int i = 0; i < 3; ++i) {
      if (!held.held[3 * v + static_cast<std::size_t>(i)]) continue;
      double value[modes];
      for (int m = 0; m < modes; ++m) {
        value[m] = rigid_body_mode(m, i, &mesh.coordinates[3 * v], centre) / (m < 3 ? 1 : size);
      }
      for (int m = 0; m < modes; ++m) {
        for (int n = 0; n < modes; ++n) G[modes * m + n] += value[m] * value[n];
      }
    }
  }
  return gram;
}

/// Dimension of the null space of a 6x6 Gram matrix; destroys it.
PetscErrorCode null_space_dimension(double *G, int *dimension) {
  const PetscBLASInt size = modes, work_size = 10 * modes;
  double eigenvalues[modes], work[10 * modes];
  PetscBLASInt info = 0;
  PetscFunctionBeginUser;
  LAPACKsyev_("N", "U", &size, G, &size, eigenvalues, work, &work_size, &info);
  PetscCheck(info == 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK dsyev failed with %d",
             static_cast<int>(info));
  const double threshold = 1e-12 * std::max(eigenvalues[modes - 1], 1e-300);
  *dimension = static_cast<int>(
      std::count_if(eigenvalues, eigenvalues + modes, [&](double e) { return e <= threshold; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode check_rigid_body_modes(const Mesh &mesh, const HeldDofs &held) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  const PetscInt parts = mesh.parts;
  double size = 0;
  PetscFunctionBeginUser;
  for (std::size_t i = 0; i < 3; ++i) size = std::max(size, mesh.box_max[i] - mesh.box_min[i]);
  std::vector<double> gram = gram_matrices(mesh, held, mesh.part, parts, size);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, gram.data(), static_cast<PetscMPIInt>(gram.size()),
                             MPI_DOUBLE, MPI_SUM, comm));
  PetscInt loose_parts = 0;
  int free_modes = 0;
  for (PetscInt p = 0; p < parts; ++p) {
    int dimension = 0;
    PetscCall(null_space_dimension(&gram[static_cast<std::size_t>(p) * modes * modes], &dimension));
    if (dimension > 0 && loose_parts++ == 0) free_modes = dimension;
  }
  const std::string whose = parts == 1 ? "the body"
                                       : std::to_string(loose_parts) + " of the mesh's " +
                                             std::to_string(parts) + " unconnected parts";
  PetscCheck(
      loose_parts == 0, comm, PETSC_ERR_USER_INPUT,
      "the constraints let %s move rigidly (%d of %d rigid-body modes free%s); hold at least "
      "%s, in all components",
      whose.c_str(), free_modes, mesh.dimension() == 2 ? 3 : 6, parts == 1 ? "" : " in the first",
      mesh.dimension() == 2 ? "two vertices" : "three vertices that are not on one line");
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
