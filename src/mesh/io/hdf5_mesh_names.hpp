#pragma once

#include <string>

/// The datasets of a mesh in HDF5.
namespace trefoil::hdf5_names {

inline const std::string cells = "/topology/cells", points = "/geometry/vertices";
/// Format, row of the shape in mesh_shapes(), cells, vertices, vertices of the original file.
inline const std::string header = "/trefoil/header";
inline const std::string cell_number = "/trefoil/cell_number",
                         vertex_number = "/trefoil/vertex_number", cell_set = "/trefoil/cell_set";
inline const std::string groups = "/trefoil/groups", group_names = "/trefoil/group_names";
inline constexpr int format = 2, header_size = 5;
/// Of every list, see kept_check(); format 1 has none.
inline const char *const check = "check";

/// What is in groups of one dimension: rows of a cell that has it, its set, its corners.
inline std::string entities(std::size_t dimension) {
  return "/trefoil/entities_" + std::to_string(dimension);
}

}  // namespace trefoil::hdf5_names
