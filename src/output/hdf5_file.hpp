#pragma once

#include <petscviewer.h>

#include <functional>

#include "output/arranged.hpp"

/// The heavy half of an output: datasets in an HDF5 file, written by all ranks together.
namespace trefoil {

/// Opens a file, writes it and closes it. Collective, but where the disk fails on some ranks the
/// outcome may differ between ranks. What PETSc and HDF5 say about a failure is kept silent.
PetscErrorCode with_hdf5(MPI_Comm comm, const std::string &file, PetscFileMode mode,
                         const std::function<PetscErrorCode(PetscViewer)> &write);

/// Writes a dataset of `components` columns (a plain list where that is 1), rank below rank.
/// Collective.
PetscErrorCode write_reals(PetscViewer viewer, const std::string &name, int components,
                           const std::vector<double> &values);

/// Writes a mesh and its fields into a file that is there, and empty, as with_hdf5() does.
/// @param mesh null: the file has fields only
PetscErrorCode write_hdf5(MPI_Comm comm, const std::string &file, const ArrangedMesh *mesh,
                          const std::vector<ArrangedField> &fields);

/// The dataset of a field.
std::string dataset_of(const FieldKind &field);

/// The dataset with the points of the mesh: points x 3.
inline constexpr const char *points_dataset = "points";
/// The dataset with the vertices of the cells: cells x nodes.
inline constexpr const char *cells_dataset = "cells";

/// Room that the file needs, in bytes.
/// @param totals of the mesh, which is written where `with_mesh`
PetscInt64 size_in_hdf5(const ArrangedMesh &totals, bool with_mesh,
                        const std::vector<ArrangedField> &fields);

}  // namespace trefoil
