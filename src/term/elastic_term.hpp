#pragma once

#include <utility>

#include "element/tet4.hpp"
#include "element/tet4_packs.hpp"
#include "mesh/mesh.hpp"
#include "petsc_compatibility.hpp"
#include "term/term.hpp"

namespace trefoil {

/// The elastic energy of a body of linear tetrahedra: sum over the elements of psi(F) V.
class ElasticTerm final : public Term {
 public:
  ElasticTerm(const Mesh &mesh, std::unique_ptr<MaterialModel> material)
      : ElasticTerm(mesh, std::make_shared<Tet4Packs>(pack_tetrahedra(mesh)), std::move(material)) {
  }

  ElasticTerm(const Mesh &mesh, std::shared_ptr<const Tet4Packs> packs,
              std::unique_ptr<MaterialModel> material)
      : mesh_(mesh), material_(std::move(material)), packs_(std::move(packs)) {
    for (double volume : packs_->volumes) volume_ += volume;
    Matrix3<double> identity;
    for (int i = 0; i < 3; ++i) identity(i, i) = 1;
    rest_density_ = material_->energy_density(identity);
    Tangent<double> tangent;
    material_->tangent(identity, tangent);
    for (std::size_t p = 0; p < 9; ++p) mean_stiffness_ += tangent[10 * p] / 9;
  }

  void add_energy(const double *u, EnergySums *sums) const override {
    double energies[2] = {0, 0};
    kernels_.energy(*material_, *packs_, 0, packs_->packs(), u, rest_density_, energies);
    sums->energy += energies[0];
    sums->scale += energies[1];
    sums->stiffness += mean_stiffness_ * volume_;
  }

  void add_energy_changes(const double *u, std::size_t, int directions, const double *const *d,
                          int points, const double *coefficients, double *changes) const override {
    kernels_.energy_changes(*material_, *packs_, 0, packs_->packs(), u, directions, d, points,
                            coefficients, changes);
  }

  void add_gradient(const double *u, double *gradient) const override {
    kernels_.forces(*material_, *packs_, 0, packs_->packs(), u, gradient);
  }

  [[nodiscard]] const Tet4Packs *packs() const override { return packs_.get(); }

  void reduced_hessians(PetscInt first, PetscInt count, const double *u, double *K) const override {
    kernels_.reduced_hessians(*material_, *packs_, first, count, u, K);
  }

  PetscErrorCode add_hessian(const double *u, ElementHessianSink &sink) const override {
    PetscErrorCode error = PETSC_SUCCESS;
    PetscFunctionBeginUser;
    for_each_element(u, [&](PetscInt c, const Tet4 &tet, const Matrix3<double> &F) {
      if (error) return;
      Tangent<double> tangent;
      double H[Tet4::dofs * Tet4::dofs];
      PetscInt dofs[Tet4::dofs];
      material_->tangent(F, tangent);
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
      energy_density[c] = material_->energy_density(F);
    });
  }

  [[nodiscard]] std::unique_ptr<Term> spreading(Spreading kind) const override {
    return std::make_unique<ElasticTerm>(
        mesh_, packs_,
        kind == Spreading::harmonic ? make_material_model(HarmonicSpreading(mean_stiffness_))
                                    : make_material_model(RigidSpreading(mean_stiffness_)));
  }

  [[nodiscard]] double bytes() const override { return packs_->bytes(); }

 private:
  /// Local number of component i of corner a of cell c.
  [[nodiscard]] std::size_t dof(PetscInt c, int a, int i) const {
    return static_cast<std::size_t>(3 * mesh_.cells[static_cast<std::size_t>(4 * c + a)] + i);
  }

  /// One element at a time: the plain path, for output and for what has no batched kernel.
  template <class Visit>
  void for_each_element(const double *u, Visit visit) const {
    for (PetscInt c = 0; c < mesh_.local_cells(); ++c) {
      double corner[4][3], displacement[Tet4::dofs];
      for (int a = 0; a < 4; ++a) {
        for (int i = 0; i < 3; ++i) {
          corner[a][i] = mesh_.coordinates[dof(c, a, i)];
          displacement[3 * a + i] = u[dof(c, a, i)];
        }
      }
      const Tet4 tet = Tet4::at_rest(corner);
      visit(c, tet, tet.deformation_gradient(displacement));
    }
  }

  const Mesh &mesh_;
  std::unique_ptr<MaterialModel> material_;
  std::shared_ptr<const Tet4Packs> packs_;
  Tet4Kernels kernels_ = tet4_kernels();
  double rest_density_ = 0, mean_stiffness_ = 0, volume_ = 0;
};

}  // namespace trefoil
