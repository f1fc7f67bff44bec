#pragma once

#include <string>

#include "output/snapshot.hpp"

/// The light half of a snapshot: what the datasets of its HDF5 file mean, in XDMF 3.
namespace trefoil::xdmf {

/// Coordinates of a point in the file. Flat meshes too have three, with z = 0: a viewer can then
/// move their points by a vector field like those of any other.
inline constexpr int coordinates = 3;

/// How much the ranks hold together.
struct Totals {
  PetscInt64 points = 0;
  PetscInt64 cells = 0;
};

/// The dataset with the points of the mesh: points x 3.
inline constexpr const char *points_dataset = "points";
/// The dataset with the vertex numbers of the cells: cells x corners.
inline constexpr const char *cells_dataset = "cells";
/// The group that holds the dataset of a field; the dataset has the name of the field.
const char *group_of(const Snapshot::Field &field);

/// @param data_file name of the HDF5 file, seen from the directory of the XDMF file
/// @param snapshot any rank's part: only its shape and the names and kinds of its fields count
/// @param totals of all ranks
/// @return the whole text of the XDMF file
std::string describe(const std::string &data_file, const Snapshot &snapshot, const Totals &totals);

}  // namespace trefoil::xdmf
