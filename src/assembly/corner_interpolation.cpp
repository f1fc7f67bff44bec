#include "assembly/corner_interpolation.hpp"

#include <algorithm>

#include "assembly/near_null_space.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// What makes the entries of the matrix, row by row.
class Rows {
 public:
  explicit Rows(const Discretization &discretization)
      : discretization_(discretization),
        mesh_(discretization.mesh()),
        ends_(mesh_.owned.size(), {-1, -1}),
        turned_(mesh_.owned.size(), nullptr) {}

  /// Collective.
  PetscErrorCode make();

  std::vector<PetscInt> corners;  ///< of this rank's unknowns, those of corners
  std::vector<PetscInt> row, column;
  std::vector<PetscScalar> value;

 private:
  PetscErrorCode number_corners();
  void add(PetscInt to, PetscInt from, double weight);
  [[nodiscard]] bool is_midpoint(std::size_t v) const { return ends_[v][0] >= 0; }
  /// Axis k of a vertex's unknowns; zero where it is held.
  [[nodiscard]] std::array<double, 3> free_axis(PetscInt vertex, int k) const;

  const Discretization &discretization_;
  const Mesh &mesh_;
  std::vector<std::array<PetscInt, 2>> ends_;  ///< of a midpoint's edge: local vertices
  std::vector<const TurnedVertex *> turned_;   ///< of each local vertex; null: it is not turned
  std::vector<PetscInt> coarse_;               ///< number of a local dof among the corners', or -1
};

std::array<double, 3> Rows::free_axis(PetscInt vertex, int k) const {
  const TurnedVertex *turned = turned_[static_cast<std::size_t>(vertex)];
  std::array<double, 3> axis{};
  if (!turned) {
    axis[static_cast<std::size_t>(k)] = 1;
  } else if (k >= turned->held) {
    axis = turned->axes[static_cast<std::size_t>(k)];
  }
  return axis;
}

/// The owners number them; those of ghosts come by the way of displacements.
PetscErrorCode Rows::number_corners() {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_.dm));
  const std::vector<PetscInt> &dofs = discretization_.global_dofs();
  Vec numbers = nullptr, local = nullptr;
  const PetscScalar *number = nullptr;
  PetscInt first = 0;
  PetscFunctionBeginUser;
  for (std::size_t dof = 0; dof < dofs.size(); ++dof) {
    const bool counts = mesh_.owned[dof / 3] && !is_midpoint(dof / 3) && dofs[dof] >= 0;
    if (counts) corners.push_back(dofs[dof]);
  }
  const auto count = static_cast<PetscInt>(corners.size());
  PetscCallMPI(MPI_Exscan(&count, &first, 1, MPIU_INT, MPI_SUM, comm));
  PetscCall(discretization_.create_vector(&numbers));
  for (PetscInt dof : corners) {  // from 1: where nothing arrives is none
    PetscCall(VecSetValue(numbers, dof, static_cast<PetscScalar>(++first), INSERT_VALUES));
  }
  PetscCall(VecAssemblyBegin(numbers));
  PetscCall(VecAssemblyEnd(numbers));
  PetscCall(DMGetLocalVector(mesh_.dm, &local));
  PetscCall(VecSet(local, 0));
  PetscCall(DMGlobalToLocal(mesh_.dm, numbers, INSERT_VALUES, local));
  PetscCall(VecGetArrayRead(local, &number));
  coarse_.resize(dofs.size());
  std::transform(number, number + dofs.size(), coarse_.begin(),
                 [](PetscScalar n) { return static_cast<PetscInt>(PetscRealPart(n)) - 1; });
  PetscCall(VecRestoreArrayRead(local, &number));
  PetscCall(DMRestoreLocalVector(mesh_.dm, &local));
  PetscCall(VecDestroy(&numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds `weight` times the displacement of one vertex to that of another, in their unknowns.
void Rows::add(PetscInt to, PetscInt from, double weight) {
  const auto rows = discretization_.dofs_of_vertex(to);
  const PetscInt *columns = &coarse_[static_cast<std::size_t>(3 * from)];
  for (int m = 0; m < 3; ++m) {
    const std::array<double, 3> axis = free_axis(to, m);
    for (int k = 0; k < 3; ++k) {
      const std::array<double, 3> other = free_axis(from, k);
      const double overlap = axis[0] * other[0] + axis[1] * other[1] + axis[2] * other[2];
      if (rows[static_cast<std::size_t>(m)] < 0 || columns[k] < 0 || overlap == 0) continue;
      row.push_back(rows[static_cast<std::size_t>(m)]);
      column.push_back(columns[k]);
      value.push_back(weight * overlap);
    }
  }
}

PetscErrorCode Rows::make() {
  const CellShape &shape = *mesh_.shape;
  PetscFunctionBeginUser;
  for (std::size_t cell = 0; cell < mesh_.cells.size();
       cell += static_cast<std::size_t>(shape.nodes)) {
    const PetscInt *nodes = &mesh_.cells[cell];
    const PetscInt *midpoint = nodes + shape.corners;
    for (const std::array<int, 2> &edge : shape.edges) {
      ends_[static_cast<std::size_t>(*midpoint++)] = {nodes[edge[0]], nodes[edge[1]]};
    }
  }
  for (const TurnedVertex &turned : discretization_.turned()) {
    turned_[static_cast<std::size_t>(turned.vertex)] = &turned;
  }
  PetscCall(number_corners());
  for (PetscInt v = 0; v < mesh_.local_vertices(); ++v) {
    const auto at = static_cast<std::size_t>(v);
    if (!mesh_.owned[at] || !is_midpoint(at)) continue;
    for (PetscInt end : ends_[at]) add(v, end, 0.5);
  }
  for (PetscInt dof : corners) {
    row.push_back(dof);
    value.push_back(1);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

CornerInterpolation::~CornerInterpolation() {
  static_cast<void>(MatDestroy(&matrix_));  // errors have nowhere to go from here
  static_cast<void>(ISDestroy(&corners_));
}

PetscErrorCode CornerInterpolation::set_up(const Discretization &discretization) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(discretization.mesh().dm));
  Rows rows(discretization);
  Vec like = nullptr;
  PetscInt owned = 0, first = 0;
  PetscFunctionBeginUser;
  PetscCall(rows.make());
  const auto count = static_cast<PetscInt>(rows.corners.size());
  PetscCallMPI(MPI_Exscan(&count, &first, 1, MPIU_INT, MPI_SUM, comm));
  for (PetscInt k = 0; k < count; ++k) rows.column.push_back(first + k);
  PetscCall(discretization.create_vector(&like));
  PetscCall(VecGetLocalSize(like, &owned));
  PetscCall(VecDestroy(&like));
  PetscCall(MatCreate(comm, &matrix_));
  PetscCall(MatSetSizes(matrix_, owned, count, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetBlockSize(matrix_, discretization.block_size()));
  PetscCall(MatSetType(matrix_, MATAIJ));
  PetscCall(MatSetPreallocationCOO(matrix_, static_cast<PetscCount>(rows.row.size()),
                                   rows.row.data(), rows.column.data()));
  PetscCall(MatSetValuesCOO(matrix_, rows.value.data(), INSERT_VALUES));
  PetscCall(ISCreateGeneral(comm, count, rows.corners.data(), PETSC_COPY_VALUES, &corners_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CornerInterpolation::attach_modes(Mat fine, Mat coarse) const {
  MatNullSpace space = nullptr;
  PetscInt count = 0;
  const Vec *modes = nullptr;
  PetscFunctionBeginUser;
  PetscCall(MatGetNearNullSpace(fine, &space));
  PetscCall(MatNullSpaceGetVecs(space, nullptr, &count, &modes));
  std::vector<Vec> restricted(static_cast<std::size_t>(count), nullptr);
  for (std::size_t m = 0; m < restricted.size(); ++m) {
    PetscCall(MatCreateVecs(coarse, &restricted[m], nullptr));
    PetscCall(VecISCopy(modes[m], corners_, SCATTER_REVERSE, restricted[m]));
  }
  PetscCall(attach_near_null_space(coarse, &restricted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
