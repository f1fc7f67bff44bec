#pragma once

#include <string>

#include "mesh/cell_list.hpp"

namespace trefoil {

/// The tetrahedra of a mesh file (of a plane one its triangles), with all its vertices, in the
/// file's own order and with its own orientation. The content decides on the format, not the file's
/// extension: Medit .mesh (ASCII), Gmsh .msh 2.2 and 4.1 (ASCII and binary). Coordinates keep the
/// file's unit of length. InputError, naming the file and the line, byte or element, for whatever
/// cannot be read.
CellList read_mesh(const std::string &path);

}  // namespace trefoil
