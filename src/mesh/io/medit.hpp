#pragma once

#include "mesh/cell_list.hpp"
#include "mesh/io/mesh_file.hpp"

namespace trefoil {

/// Reads an ASCII Medit mesh: its Vertices and Tetrahedra (1-based), whatever their order; of a
/// mesh without Tetrahedra its Triangles. What has the same reference is a group; reference 0 is
/// one of cells only, where some cells have others. Fields and other sections are skipped, other
/// cells of the body's dimension are an InputError. Format: P. Frey, "Medit: an interactive mesh
/// visualization software", INRIA RT-0253 (2001), section 4.
CellList read_medit(MeshFile &file);

}  // namespace trefoil
