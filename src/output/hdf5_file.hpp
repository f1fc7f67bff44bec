#pragma once

#include <petscsys.h>

#include "output/arranged.hpp"

/// The heavy half of an output: datasets in an HDF5 file, written by all ranks together.
namespace trefoil {

/// Creates the file with the mesh, or opens one that is there, and writes fields into groups.
/// Collective, but where the disk fails on some ranks the outcome may differ between ranks. What
/// PETSc and HDF5 say about a failure is kept silent.
/// @param mesh null: the file has it already
/// @param prefix of the groups, "" or "/step3"
PetscErrorCode write_hdf5(MPI_Comm comm, const std::string &file, const ArrangedMesh *mesh,
                          const std::string &prefix, const std::vector<ArrangedField> &fields);

/// The dataset of a field.
std::string dataset_of(const std::string &prefix, const FieldKind &field);

/// The dataset with the points of the mesh: points x 3.
inline constexpr const char *points_dataset = "points";
/// The dataset with the vertices of the cells: cells x nodes.
inline constexpr const char *cells_dataset = "cells";

/// Room that the datasets need, in bytes.
PetscInt64 size_in_hdf5(const ArrangedMesh &mesh, bool with_mesh,
                        const std::vector<ArrangedField> &fields);

}  // namespace trefoil
