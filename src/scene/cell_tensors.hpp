#pragma once

#include <vector>

#include "scene/cell_states.hpp"

namespace trefoil {

/// Strain and stress of a cell or vertex.
struct MeanTensors {
  Matrix3<double> F, first_piola, cauchy, green_lagrange;
};

/// Those of all local cells, and of the vertices that this rank owns: means over the vertex's cells
/// by rest volume, where regions meet over those of one region, the one with the greater von Mises
/// stress. Collective.
/// @param u local displacements, 3 a local vertex
PetscErrorCode compute_mean_tensors(const Mesh &mesh, const CellStates &cells, const double *u,
                                    std::vector<MeanTensors> *of_cells,
                                    std::vector<MeanTensors> *of_vertices);

}  // namespace trefoil
