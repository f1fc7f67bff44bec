#pragma once

#include <petscsystypes.h>

#include <optional>
#include <string>
#include <vector>

namespace trefoil {

/// Where a file has a vector for each vertex, in the order of their numbers.
struct WrittenField {
  std::string path;
  std::string dataset = {};               ///< of an HDF5 file; or
  std::optional<PetscInt64> offset = {};  ///< of the first number in a VTU file
  PetscInt rows = 0;                      ///< there

  /// Rows first ... first + count - 1 of `total`, 3 numbers each, read by this rank alone. Throws
  /// InputError.
  [[nodiscard]] std::vector<double> read(PetscInt total, PetscInt first, PetscInt count) const;
};

/// A displacement, and the rest positions that it belongs to.
struct WrittenDisplacement {
  WrittenField values, points;  ///< without a path: the file does not say
};

/// The displacement of an output of Trefoil, of a series the last: .xdmf, its HDF5 files, .vtu.
/// Throws InputError.
WrittenDisplacement find_displacement(const std::string &path);

/// Whether a file is HDF5 and has a dataset.
bool has_dataset(const std::string &path, const std::string &dataset);

}  // namespace trefoil
