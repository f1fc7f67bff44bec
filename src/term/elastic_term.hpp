#pragma once

#include <utility>

#include "element/tet4.hpp"
#include "element/tet4_packs.hpp"
#include "material/material_runs.hpp"
#include "material/spreading.hpp"
#include "mesh/mesh.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/term.hpp"

namespace trefoil {

/// The elastic energy of a body of linear tetrahedra: sum over the elements of psi(F) V.
class ElasticTerm final : public Term {
 public:
  /// A body of one material.
  ElasticTerm(const Mesh &mesh, std::unique_ptr<MaterialModel> material)
      : ElasticTerm(mesh, MaterialRuns(std::move(material), mesh.local_cells())) {}

  /// A body of several materials.
  ElasticTerm(const Mesh &mesh, MaterialRuns materials)
      : ElasticTerm(mesh, std::make_shared<Tet4Packs>(pack_tetrahedra(mesh)),
                    std::move(materials)) {}

  ElasticTerm(const Mesh &mesh, std::shared_ptr<const Tet4Packs> packs, MaterialRuns materials)
      : mesh_(mesh), materials_(std::move(materials)), packs_(std::move(packs)) {
    for (PetscInt c = 0; c < packs_->elements; ++c) {
      stiffness_ += materials_.stiffness_of(c) * volume(c);
    }
    for (const auto &run : materials_.runs()) {
      for (PetscInt c = lanes * run.first; run.is_mixed && c < lanes * (run.first + 1); ++c) {
        if (c < packs_->elements) mixed_rest_energy_ += materials_.rest_density_of(c) * volume(c);
      }
    }
  }

  void add_energy(const double *u, EnergySums *sums) const override {
    double energies[2] = {mixed_rest_energy_, 0};
    materials_.for_each_run(0, packs_->packs(), [&](const MaterialRuns::Run &run) {
      kernels_.energy(*run.material, *packs_, run.first, run.count, u, run.rest_density, energies);
    });
    sums->energy += energies[0];
    sums->scale += energies[1];
    sums->stiffness += stiffness_;
  }

  void add_energy_changes(const double *u, std::size_t, int directions, const double *const *d,
                          int points, const double *coefficients, double *changes) const override {
    materials_.for_each_run(0, packs_->packs(), [&](const MaterialRuns::Run &run) {
      kernels_.energy_changes(*run.material, *packs_, run.first, run.count, u, directions, d,
                              points, coefficients, changes);
    });
  }

  void add_gradient(const double *u, double *gradient) const override {
    materials_.for_each_run(0, packs_->packs(), [&](const MaterialRuns::Run &run) {
      kernels_.forces(*run.material, *packs_, run.first, run.count, u, gradient);
    });
  }

  [[nodiscard]] const Tet4Packs *packs() const override { return packs_.get(); }

  void reduced_hessians(PetscInt first, PetscInt count, const double *u, double *K) const override {
    materials_.for_each_run(first, count, [&](const MaterialRuns::Run &run) {
      kernels_.reduced_hessians(*run.material, *packs_, run.first, run.count, u,
                                K + reduced_entries * lanes * (run.first - first));
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
      materials_.of_cell(c).tangent(F, tangent);
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
      energy_density[c] = materials_.of_cell(c).energy_density(F);
    });
  }

  /// Each material by its own stiffness, so that stiff parts stay as they are.
  [[nodiscard]] std::unique_ptr<Term> spreading(Spreading kind) const override {
    const auto make = [kind](double stiffness) {
      return kind == Spreading::harmonic ? make_material_model(HarmonicSpreading(stiffness))
                                         : make_material_model(RigidSpreading(stiffness));
    };
    return std::make_unique<ElasticTerm>(mesh_, packs_, materials_.by_stiffness(make));
  }

  [[nodiscard]] double bytes() const override { return packs_->bytes() + materials_.bytes(); }

 private:
  [[nodiscard]] double volume(PetscInt c) const {
    return packs_->volumes[static_cast<std::size_t>(c)];
  }
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
  MaterialRuns materials_;
  std::shared_ptr<const Tet4Packs> packs_;
  Tet4Kernels kernels_ = tet4_kernels();
  double stiffness_ = 0;          ///< energy of a strain of order one
  double mixed_rest_energy_ = 0;  ///< what the models of mixed runs leave out
};

}  // namespace trefoil
