#pragma once

#include "element/element_packs.hpp"
#include "element/isoparametric_element.hpp"

namespace trefoil {

/// The elastic energy of one element at given displacements, and its derivatives: the plain
/// counterpart of ElementKernels, term by term as the formulas are written.
class ElementEnergy {
 public:
  /// Keeps references to the element and the material.
  /// @param displacements of the nodes, nodes x 3
  ElementEnergy(const IsoparametricElement &element, const MaterialModel &material,
                ElementPressure pressure, const double *displacements);

  /// Sum of (psi - psi(I)) w.
  [[nodiscard]] double energy() const;
  /// The least det F of the quadrature points.
  [[nodiscard]] double least_jacobian() const;
  /// The first Piola-Kirchhoff stress at a quadrature point, at the element's pressure.
  [[nodiscard]] Matrix3<double> stress(int point) const;
  /// Adds the nodes' forces, nodes x 3.
  void add_force(double *force) const;
  /// Adds to the Hessian of dim x nodes rows.
  void add_hessian(double *hessian) const;

 private:
  /// V U'' g g' with the derivative g of the mean of J.
  void add_mean_stiffness(double *hessian) const;

  const IsoparametricElement &element_;
  bool on_mean_;
  const MaterialModel &at_points_;
  int points_;
  Matrix3<double> H_[ReferenceElement::most_points];  ///< displacement gradients
  double volume_ = 0;
  VolumetricLaw<double> law_{0, 0, 0};  ///< at the mean of J, where the element has one
};

}  // namespace trefoil
