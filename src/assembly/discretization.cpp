#include "assembly/discretization.hpp"

#include <algorithm>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

HeldDofs nothing_held(const Mesh &mesh) {
  HeldDofs held{std::vector<char>(mesh.coordinates.size(), 0),
                std::vector<double>(mesh.coordinates.size(), 0)};
  if (mesh.dimension() == 2) {
    for (std::size_t k = 2; k < held.held.size(); k += 3) held.held[k] = 1;
  }
  return held;
}

Discretization::~Discretization() {
  static_cast<void>(VecDestroy(&prescribed_));  // errors have nowhere to go from here
  static_cast<void>(MatDestroy(&rotation_));
}

PetscErrorCode Discretization::set_up(Mesh &mesh, const HeldDofs &held) {
  PetscSection section = nullptr;
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  mesh_ = &mesh;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscCall(DMPlexGetChart(mesh.dm, &begin, &end));
  PetscCall(PetscSectionCreate(comm, &section));
  PetscCall(PetscSectionSetChart(section, begin, end));
  const auto held_components = [&](PetscInt v) {
    const auto first = held.held.begin() + 3 * v;
    return static_cast<PetscInt>(std::count(first, first + 3, 1));
  };
  for (PetscInt v = 0; v < mesh.local_vertices(); ++v) {
    PetscCall(PetscSectionSetDof(section, mesh.first_vertex + v, 3));
    PetscCall(PetscSectionSetConstraintDof(section, mesh.first_vertex + v, held_components(v)));
  }
  PetscCall(PetscSectionSetUp(section));
  PetscMPIInt wholly = 1;
  for (PetscInt v = 0; v < mesh.local_vertices(); ++v) {
    std::array<PetscInt, 3> component{};
    PetscInt count = 0;
    for (PetscInt i = 0; i < 3; ++i) {
      if (held.held[static_cast<std::size_t>(3 * v + i)]) {
        component[static_cast<std::size_t>(count++)] = i;
      }
    }
    if (count) {
      PetscCall(PetscSectionSetConstraintIndices(section, mesh.first_vertex + v, component.data()));
    }
    wholly = wholly && (count == 3 - mesh.dimension() || count == 3);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &wholly, 1, MPI_INT, MPI_MIN, comm));
  block_size_ = wholly ? mesh.dimension() : 1;
  PetscCall(DMSetLocalSection(mesh.dm, section));
  PetscCall(PetscSectionDestroy(&section));
  PetscCall(number_dofs(held));

  PetscMPIInt any_turned = !held.turned.empty();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &any_turned, 1, MPI_INT, MPI_MAX, comm));
  any_turned_ = any_turned != 0;
  turned_ = held.turned;
  PetscCall(DMCreateLocalVector(mesh.dm, &prescribed_));
  PetscCall(set_prescribed(held));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::set_prescribed(const HeldDofs &held) {
  PetscScalar *value = nullptr;
  PetscMPIInt same = 1;
  PetscFunctionBeginUser;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  for (std::size_t dof = 0; dof < global_dofs_.size(); ++dof) {
    same = same && (global_dofs_[dof] < 0) == (held.held[dof] != 0);
  }
  same = same && turned_.size() == held.turned.size();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &same, 1, MPI_INT, MPI_MIN, comm));
  PetscCheck(same, comm, PETSC_ERR_USER_INPUT,
             "the constraints hold other vertices at one time than at another; let only their "
             "displacements depend on t");
  turned_ = held.turned;
  PetscCall(VecGetArrayWrite(prescribed_, &value));
  std::copy(held.value.begin(), held.value.end(), value);
  PetscCall(VecRestoreArrayWrite(prescribed_, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::number_dofs(const HeldDofs &held) {
  PetscSection global = nullptr;
  PetscInt owned = 0;
  PetscFunctionBeginUser;
  PetscCall(DMGetGlobalSection(mesh_->dm, &global));
  global_dofs_.assign(held.held.size(), -1);
  for (PetscInt v = 0; v < mesh_->local_vertices(); ++v) {
    PetscInt next = 0;
    PetscCall(PetscSectionGetOffset(global, mesh_->first_vertex + v, &next));
    if (next < 0) next = -(next + 1);  // a ghost
    for (PetscInt i = 0; i < 3; ++i) {
      const auto dof = static_cast<std::size_t>(3 * v + i);
      if (!held.held[dof]) global_dofs_[dof] = next++;
    }
  }
  PetscCall(PetscSectionGetConstrainedStorageSize(global, &owned));
  PetscCallMPI(MPI_Allreduce(&owned, &total_, 1, MPIU_INT, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::create_vector(Vec *x) const {
  PetscFunctionBeginUser;
  PetscCall(DMCreateGlobalVector(mesh_->dm, x));
  PetscCall(VecSet(*x, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::get_local(Vec x, Vec *local, const PetscScalar **u) const {
  PetscFunctionBeginUser;
  PetscCall(DMGetLocalVector(mesh_->dm, local));
  PetscCall(VecCopy(prescribed_, *local));
  // Held entries have no global counterpart and keep their values.
  PetscCall(DMGlobalToLocal(mesh_->dm, x, INSERT_VALUES, *local));
  PetscCall(turn_to_space(*local, true));
  PetscCall(VecGetArrayRead(*local, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::get_local_direction(Vec d, Vec *local,
                                                   const PetscScalar **values) const {
  PetscFunctionBeginUser;
  PetscCall(DMGetLocalVector(mesh_->dm, local));
  PetscCall(VecSet(*local, 0));
  PetscCall(DMGlobalToLocal(mesh_->dm, d, INSERT_VALUES, *local));
  PetscCall(turn_to_space(*local, false));
  PetscCall(VecGetArrayRead(*local, values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::restore_local(Vec *local, const PetscScalar **u) const {
  PetscFunctionBeginUser;
  PetscCall(VecRestoreArrayRead(*local, u));
  PetscCall(DMRestoreLocalVector(mesh_->dm, local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::copy_local(Vec x, std::vector<double> *u) const {
  Vec local = nullptr;
  const PetscScalar *values = nullptr;
  PetscFunctionBeginUser;
  PetscCall(get_local(x, &local, &values));
  u->assign(values, values + mesh_->coordinates.size());
  PetscCall(restore_local(&local, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::add_to_global(Vec local, Vec global) const {
  PetscFunctionBeginUser;
  if (any_turned_) {
    PetscScalar *values = nullptr;
    PetscCall(VecGetArray(local, &values));
    turn_to_axes(values);
    PetscCall(VecRestoreArray(local, &values));
  }
  PetscCall(VecSet(global, 0));
  PetscCall(DMLocalToGlobal(mesh_->dm, local, ADD_VALUES, global));
  PetscFunctionReturn(PETSC_SUCCESS);
}

double Discretization::bytes() const {
  return static_cast<double>(global_dofs_.capacity() * sizeof(PetscInt) +
                             mesh_->coordinates.size() * sizeof(PetscScalar));
}

}  // namespace trefoil
