#pragma once

#include <string>

#include "mesh/cell_list.hpp"

namespace trefoil {

/// A conforming mesh of positively oriented tetrahedra or, of `square`, of triangles, with 2000 to
/// 5000 of them by default.
///
/// - `box`: the unit cube [0,1]^3; resolution: cells along an edge (8)
/// - `cylinder`: axis z, radius 0.5, 0 <= z <= 2; resolution: rings from axis to surface (4)
/// - `knot`: tube of radius 0.4 around the trefoil knot; resolution: rings, axis to surface (2)
/// - `ball`: radius 0.5 around the origin; resolution: cells from centre to surface (4)
/// - `square`: the unit square [0,1]^2; resolution: cells along an edge, two triangles each (40)
///
/// The axis of the knot is c(t) = ((2 + cos 3t) cos 2t, (2 + cos 3t) sin 2t, sin 3t), which lies on
/// a torus. `resolution` 0 stands for the default in brackets; `refine` doubles it that many times,
/// each time with eight times the tetrahedra (four times the triangles), and rounds curved
/// boundaries better. InputError for an unknown kind, a negative number, or a mesh of more than
/// 2^31 entries.
CellList generate_mesh(const std::string &kind, PetscInt resolution, PetscInt refine);

}  // namespace trefoil
