#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "element/element_packs.hpp"
#include "mesh/mesh.hpp"
#include "scene/scene_options.hpp"
#include "trefoil/material_model.hpp"

namespace trefoil {

/// Strain and stress of one cell: means over its quadrature points by rest volume, of which a
/// linear cell has one. Stresses are those of the pressure that the element has, see
/// ElementPressure.
struct CellState {
  double volume = 0;               ///< at rest
  double deformed_volume = 0;      ///< negative where the cell is inverted
  double least_determinant = 0;    ///< of F at the quadrature points
  Matrix3<double> F;               ///< deformation gradient
  Matrix3<double> first_piola;     ///< P = dpsi/dF
  Matrix3<double> cauchy;          ///< P F' / det F
  Matrix3<double> green_lagrange;  ///< (F'F - I) / 2
};

/// Computes cells one at a time, for output. In the plane F_33 = 1 (plane strain).
class CellStates {
 public:
  /// `mesh` must outlive this.
  /// @param options the body's material, number 0, and its regions' from 1
  /// @param region_of_cell number of each local cell's material
  CellStates(const Mesh &mesh, const SceneOptions &options, std::vector<int> region_of_cell);

  /// Visits every local cell at local displacements u, 3 a local vertex.
  void visit(const double *u,
             const std::function<void(std::size_t cell, const CellState &state)> &visitor) const;

  /// The volume of a local cell at rest.
  [[nodiscard]] double rest_volume(std::size_t cell) const;

  /// How many materials there are: the body's and its regions'.
  [[nodiscard]] int regions() const { return static_cast<int>(materials_.size()); }
  [[nodiscard]] const std::vector<int> &region_of_cell() const { return region_of_cell_; }

 private:
  const Mesh &mesh_;
  ElementPressure pressure_;
  std::vector<std::unique_ptr<MaterialModel>> materials_;
  std::vector<int> region_of_cell_;
};

/// The equivalent stress sqrt(3/2 s:s), s the deviator of a symmetric stress.
double von_mises(const Matrix3<double> &stress);

/// Eigenvalues of a symmetric matrix, the largest first.
std::array<double, 3> principal_values(const Matrix3<double> &symmetric);

/// Singular values of a deformation gradient, the largest first; the last is negative where det F
/// is.
std::array<double, 3> principal_stretches(const Matrix3<double> &F);

}  // namespace trefoil
