#include "output/hdf5_file.hpp"

#include <hdf5.h>
#include <petscis.h>
#include <petscvec.h>
#include <petscviewerhdf5.h>

#include <type_traits>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

static_assert(std::is_same_v<PetscScalar, double>,
              "the files hold doubles: Trefoil needs a PETSc of real numbers in double precision");

const char *group_of(const FieldKind &field) {
  return field.on_vertices ? "/vertex_fields" : "/cell_fields";
}

}  // namespace

PetscErrorCode write_reals(PetscViewer viewer, const std::string &name, int components,
                           const std::vector<double> &values) {
  Vec vector = nullptr;
  PetscFunctionBeginUser;
  PetscCall(VecCreateMPIWithArray(PetscObjectComm((PetscObject)viewer), components,
                                  static_cast<PetscInt>(values.size()), PETSC_DETERMINE,
                                  values.data(), &vector));
  PetscErrorCode outcome = PetscObjectSetName((PetscObject)vector, name.c_str());
  if (!outcome) outcome = VecView(vector, viewer);
  PetscCall(VecDestroy(&vector));
  PetscCall(outcome);
  PetscFunctionReturn(PETSC_SUCCESS);
}

namespace {

/// Writes the cells as a dataset of cells x nodes, rank below rank.
PetscErrorCode write_cells(PetscViewer viewer, const ArrangedMesh &mesh) {
  IS nodes = nullptr;
  PetscFunctionBeginUser;
  PetscCall(ISCreateGeneral(PetscObjectComm((PetscObject)viewer),
                            static_cast<PetscInt>(mesh.cells.size()), mesh.cells.data(),
                            PETSC_USE_POINTER, &nodes));
  PetscErrorCode outcome = PetscObjectSetName((PetscObject)nodes, cells_dataset);
  if (!outcome) outcome = ISSetBlockSize(nodes, mesh.shape->nodes);
  if (!outcome) outcome = ISView(nodes, viewer);
  PetscCall(ISDestroy(&nodes));
  PetscCall(outcome);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode write_datasets(PetscViewer viewer, const ArrangedMesh *mesh,
                              const std::vector<ArrangedField> &fields) {
  PetscFunctionBeginUser;
  if (mesh) {
    PetscCall(write_reals(viewer, points_dataset, 3, mesh->points));
    PetscCall(write_cells(viewer, *mesh));
  }
  for (const ArrangedField &field : fields) {
    PetscCall(PetscViewerHDF5PushGroup(viewer, group_of(field)));
    PetscCall(write_reals(viewer, field.name, field.components, field.values));
    PetscCall(PetscViewerHDF5PopGroup(viewer));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

std::string dataset_of(const FieldKind &field) {
  return std::string(group_of(field)) + "/" + field.name;
}

PetscInt64 size_in_hdf5(const ArrangedMesh &totals, bool with_mesh,
                        const std::vector<ArrangedField> &fields) {
  constexpr PetscInt64 hdf5_itself = 1 << 20;  // generous: some 4 kB a dataset were seen
  const PetscInt64 points = totals.total_points, cells = totals.total_cells;
  PetscInt64 doubles = with_mesh ? 3 * points : 0;
  for (const ArrangedField &field : fields)
    doubles += (field.on_vertices ? points : cells) * field.components;
  const PetscInt64 integers = with_mesh ? cells * totals.shape->nodes : 0;
  return doubles * static_cast<PetscInt64>(sizeof(double)) +
         integers * static_cast<PetscInt64>(sizeof(PetscInt)) + hdf5_itself;
}

PetscErrorCode with_hdf5(MPI_Comm comm, const std::string &file, PetscFileMode mode,
                         const std::function<PetscErrorCode(PetscViewer)> &write) {
  PetscViewer viewer = nullptr;
  H5E_auto2_t printer = nullptr;
  void *printer_data = nullptr;
  PetscFunctionBeginUser;
  H5Eget_auto2(H5E_DEFAULT, &printer, &printer_data);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
  PetscErrorCode outcome = PetscViewerHDF5Open(comm, file.c_str(), mode, &viewer);
  if (!outcome) outcome = write(viewer);
  const PetscErrorCode closing = PetscViewerDestroy(&viewer);
  PetscCall(PetscPopErrorHandler());
  H5Eset_auto2(H5E_DEFAULT, printer, printer_data);
  PetscFunctionReturn(outcome ? outcome : closing);
}

PetscErrorCode write_hdf5(MPI_Comm comm, const std::string &file, const ArrangedMesh *mesh,
                          const std::vector<ArrangedField> &fields) {
  PetscFunctionBeginUser;
  PetscCall(with_hdf5(comm, file, mesh ? FILE_MODE_WRITE : FILE_MODE_APPEND,
                      [&](PetscViewer viewer) { return write_datasets(viewer, mesh, fields); }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
