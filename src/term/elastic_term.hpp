#pragma once

#include <cmath>
#include <vector>

#include "element/tet4.hpp"
#include "material/material.hpp"
#include "mesh/mesh.hpp"
#include "petsc_compatibility.hpp"
#include "term/term.hpp"

namespace trefoil {

/// The elastic energy of a body of linear tetrahedra: sum over the elements of psi(F) V.
template <Material M>
class ElasticTerm final : public Term {
 public:
  ElasticTerm(const Mesh &mesh, const M &material) : mesh_(mesh), material_(material) {
    elements_.reserve(static_cast<std::size_t>(mesh.local_cells()));
    for (PetscInt c = 0; c < mesh.local_cells(); ++c) {
      double corner[4][3];
      for (int a = 0; a < 4; ++a) {
        for (int i = 0; i < 3; ++i) corner[a][i] = mesh.coordinates[dof(c, a, i)];
      }
      elements_.push_back(Tet4::at_rest(corner));
    }
    Matrix3<double> identity;
    for (int i = 0; i < 3; ++i) identity(i, i) = 1;
    rest_density_ = material_.energy_density(identity);
    Tangent<double> tangent;
    material_.tangent(identity, tangent);
    for (std::size_t p = 0; p < 9; ++p) mean_stiffness_ += tangent[10 * p] / 9;
  }

  void add_energy(const double *u, EnergySums *sums) const override {
    for_each_element(u, [&](PetscInt, const Tet4 &tet, const Matrix3<double> &F) {
      const double density = material_.energy_density(F);
      sums->energy += density * tet.volume;
      sums->scale += std::abs(density - rest_density_) * tet.volume;
      sums->stiffness += mean_stiffness_ * tet.volume;
    });
  }

  void add_gradient(const double *u, double *gradient) const override {
    for_each_element(u, [&](PetscInt c, const Tet4 &tet, const Matrix3<double> &F) {
      double force[Tet4::dofs]{};
      tet.add_force(material_.stress(F), force);
      for (int a = 0; a < 4; ++a) {
        for (int i = 0; i < 3; ++i) gradient[dof(c, a, i)] += force[3 * a + i];
      }
    });
  }

  PetscErrorCode add_hessian(const double *u, ElementHessianSink &sink) const override {
    PetscErrorCode error = PETSC_SUCCESS;
    PetscFunctionBeginUser;
    for_each_element(u, [&](PetscInt c, const Tet4 &tet, const Matrix3<double> &F) {
      if (error) return;
      Tangent<double> tangent;
      double H[Tet4::dofs * Tet4::dofs];
      PetscInt dofs[Tet4::dofs];
      material_.tangent(F, tangent);
      tet.hessian(tangent, H);
      for (int a = 0; a < 4; ++a) {
        for (int i = 0; i < 3; ++i) dofs[3 * a + i] = static_cast<PetscInt>(dof(c, a, i));
      }
      error = sink.add(Tet4::dofs, dofs, H);
    });
    PetscCall(error);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  void describe_cells(const double *u, double *det, double *energy_density) const override {
    for_each_element(u, [&](PetscInt c, const Tet4 &, const Matrix3<double> &F) {
      det[c] = determinant(F);
      energy_density[c] = material_.energy_density(F);
    });
  }

  [[nodiscard]] double bytes() const override {
    return static_cast<double>(elements_.capacity() * sizeof(Tet4));
  }

 private:
  /// Local number of component i of corner a of cell c.
  [[nodiscard]] std::size_t dof(PetscInt c, int a, int i) const {
    return static_cast<std::size_t>(3 * mesh_.cells[static_cast<std::size_t>(4 * c + a)] + i);
  }

  template <class Visit>
  void for_each_element(const double *u, Visit visit) const {
    for (PetscInt c = 0; c < static_cast<PetscInt>(elements_.size()); ++c) {
      const Tet4 &tet = elements_[static_cast<std::size_t>(c)];
      double displacement[Tet4::dofs];
      for (int a = 0; a < 4; ++a) {
        for (int i = 0; i < 3; ++i) displacement[3 * a + i] = u[dof(c, a, i)];
      }
      visit(c, tet, tet.deformation_gradient(displacement));
    }
  }

  const Mesh &mesh_;
  M material_;
  std::vector<Tet4> elements_;
  double rest_density_ = 0, mean_stiffness_ = 0;
};

}  // namespace trefoil
