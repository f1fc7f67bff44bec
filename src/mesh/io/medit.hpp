#pragma once

#include "mesh/cell_list.hpp"
#include "mesh/io/mesh_file.hpp"

namespace trefoil {

/// Reads an ASCII Medit mesh: its Vertices and Tetrahedra (1-based, each with a reference that is
/// not kept), whatever their order; of a mesh without Tetrahedra its Triangles. Surfaces, edges and
/// fields are skipped, other volume cells are an InputError. Format: P. Frey, "Medit: an
/// interactive mesh visualization software", INRIA RT-0253 (2001), section 4.
CellList read_medit(MeshFile &file);

}  // namespace trefoil
