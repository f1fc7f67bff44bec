#pragma once

#include <petscsys.h>

#include <array>
#include <string>
#include <vector>

namespace trefoil {

/// A surface without cells: triangles, or segments with -1 as third corner.
struct SurfaceMesh {
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<int, 3>> facets;
};

/// Wavefront .obj: the lines `v`, `f` (polygons are cut into fans) and `l` (segments); all else is
/// left out. Throws InputError.
SurfaceMesh parse_obj(const std::string &name, const std::string &text);

/// .stl, binary or text; corners at the same place are one point. Throws InputError.
SurfaceMesh parse_stl(const std::string &name, const std::string &text);

/// Reads a surface on one rank and gives it to all. The ending decides: .obj or .stl. Collective;
/// one sentence on all ranks where it cannot be read.
PetscErrorCode read_surface(MPI_Comm comm, const std::string &path, SurfaceMesh *surface);

}  // namespace trefoil
