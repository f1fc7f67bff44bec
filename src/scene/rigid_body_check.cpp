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

/// Gram matrices of the rigid-body modes over all that is held, one for each connected part: a mode
/// that the held dofs do not see is in its null space. Lengths are in units of `size`.
class GramMatrices {
 public:
  GramMatrices(const Mesh &mesh, double size)
      : mesh_(mesh), size_(size), gram_(static_cast<std::size_t>(mesh.parts) * modes * modes, 0) {
    for (std::size_t i = 0; i < 3; ++i) centre_[i] = 0.5 * (mesh.box_min[i] + mesh.box_max[i]);
  }

  void add(const Support &support) {
    const auto v = static_cast<std::size_t>(support.vertex);
    double *G = &gram_[static_cast<std::size_t>(mesh_.part[v]) * modes * modes];
    double value[modes] = {};
    for (int m = 0; m < modes; ++m) {
      for (int i = 0; i < 3; ++i) {
        value[m] += support.direction[static_cast<std::size_t>(i)] *
                    rigid_body_mode(m, i, &mesh_.coordinates[3 * v], centre_) / (m < 3 ? 1 : size_);
      }
    }
    for (int m = 0; m < modes; ++m) {
      for (int n = 0; n < modes; ++n) G[modes * m + n] += value[m] * value[n];
    }
  }
  void add(const HeldDofs &held) {
    for (std::size_t v = 0; v < mesh_.owned.size(); ++v) {
      for (std::size_t i = 0; mesh_.owned[v] && i < 3; ++i) {
        Support support{static_cast<PetscInt>(v), {}};
        support.direction[i] = 1;
        if (held.held[3 * v + i]) add(support);
      }
    }
  }
  std::vector<double> &values() { return gram_; }

 private:
  const Mesh &mesh_;
  double size_;
  std::array<double, 3> centre_{};
  std::vector<double> gram_;
};

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

PetscErrorCode check_rigid_body_modes(const Mesh &mesh, const HeldDofs &held,
                                      const std::vector<Support> &supports, bool meets) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  const PetscInt parts = mesh.parts;
  double size = 0;
  PetscFunctionBeginUser;
  for (std::size_t i = 0; i < 3; ++i) size = std::max(size, mesh.box_max[i] - mesh.box_min[i]);
  GramMatrices matrices(mesh, size);
  matrices.add(held);
  for (const Support &support : supports) matrices.add(support);
  std::vector<double> &gram = matrices.values();
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
      "%s, in all components%s",
      whose.c_str(), free_modes, mesh.dimension() == 2 ? 3 : 6, parts == 1 ? "" : " in the first",
      mesh.dimension() == 2 ? "two vertices" : "three vertices that are not on one line",
      meets ? "; what only contact is to hold needs a weak spring until it touches, "
              "-load_NAME_spring, or masses and -time_end, -time_step"
            : "");
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
