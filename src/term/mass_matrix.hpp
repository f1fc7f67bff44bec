#pragma once

#include <vector>

#include "mesh/mesh.hpp"

namespace trefoil {

/// How the mass of an element comes to its nodes.
enum class MassKind {
  consistent,  ///< by the shape functions: integrals of rho N_a N_b
  lumped       ///< row sums of that; of linear elements only: those of quadratic ones are negative
};

/// The mass matrix of this rank's cells: its part of a sum over all ranks. It is the same for every
/// component of the displacement, so it has one number for two vertices. Local arrays hold 3
/// numbers for each local vertex, ghosts included.
class MassMatrix {
 public:
  /// @param density_of_cell mass per rest volume (in the plane, area) of each local cell
  MassMatrix(const Mesh &mesh, std::vector<double> density_of_cell, MassKind kind);

  /// result += factor M w.
  void add_product(double factor, const double *w, double *result) const;

  /// The matrix of one cell, nodes x nodes row by row, in the order of the mesh.
  void of_cell(PetscInt cell, double *M) const;

  [[nodiscard]] const Mesh &mesh() const { return mesh_; }
  [[nodiscard]] double bytes() const;

 private:
  void find_rows();

  const Mesh &mesh_;
  std::vector<double> density_of_cell_;
  MassKind kind_;
  // Compressed rows; of a lumped matrix the diagonal alone.
  std::vector<std::size_t> start_;
  std::vector<PetscInt> column_;
  std::vector<double> value_;
};

/// Sum of the products of two local arrays, this rank's.
double dot(const std::vector<double> &a, const std::vector<double> &b);

}  // namespace trefoil
