#pragma once

#include <vector>

#include "mesh/mesh.hpp"
#include "scene/scene_options.hpp"
#include "term/elastic_term.hpp"

namespace trefoil {

/// Of which there are cells: the body's material, unless its regions are all of it, and theirs.
std::vector<MaterialOptions> materials_of_cells(const SceneOptions &options);

/// Whether any of them is, see is_nearly_incompressible(MaterialOptions).
bool is_nearly_incompressible(const SceneOptions &options);

/// What the cells are made of, as the options name it.
/// @param region_of_cell number of each local cell's material: the body's is 0
/// @param most_volumetric Lame's lambda is at most so many times mu, and so is a volume term's
///        weight: a body of the same shear modulus whose volume is less dear; infinite: as named
MaterialRuns body_materials(const SceneOptions &options, const Mesh &mesh,
                            const std::vector<int> &region_of_cell, double most_volumetric);

/// The largest lambda / mu of the body's materials, of small strains about rest.
double largest_volumetric(const SceneOptions &options);

}  // namespace trefoil
