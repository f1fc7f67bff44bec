#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "element/element_packs.hpp"
#include "material/material_runs.hpp"
#include "mesh/mesh.hpp"
#include "term/packed_elements.hpp"
#include "term/term.hpp"

namespace trefoil {

/// What is split into its positive and negative part.
enum class FilterSpace {
  element,     ///< the Hessian of an element, exactly
  deformation  ///< dP/dF at each quadrature point: N_e = sum_q w_q B' N_q B
};

/// The elastic energy of a body of elements of any kind, the sum over their quadrature points of
/// psi(F) w; in the plane of plane strain. Linear tetrahedra filtered by elements are faster as an
/// ElasticTerm.
class ElementTerm final : public Term, private PackedElements {
 public:
  /// A body of one material.
  ElementTerm(const Mesh &mesh, std::unique_ptr<MaterialModel> material, FilterSpace space)
      : ElementTerm(mesh, MaterialRuns(std::move(material), mesh.local_cells()), space) {}

  /// A body of several materials.
  ElementTerm(const Mesh &mesh, MaterialRuns materials, FilterSpace space)
      : ElementTerm(mesh, std::make_shared<ElementPacks>(pack_elements(mesh)), std::move(materials),
                    space) {}

  /// With elements that another term has packed.
  ElementTerm(const Mesh &mesh, std::shared_ptr<const ElementPacks> packs, MaterialRuns materials,
              FilterSpace space);

  void add_energy(const double *u, EnergySums *sums) const override;
  void add_gradient(const double *u, double *gradient) const override;
  PetscErrorCode add_hessian(const double *u, ElementHessianSink &sink) const override;
  /// The least det F and the mean psi of an element's quadrature points.
  void describe_cells(const double *u, double *determinant, double *energy_density) const override;
  [[nodiscard]] const PackedElements *packed_elements() const override { return this; }
  [[nodiscard]] std::unique_ptr<Term> spreading(Spreading kind) const override;
  [[nodiscard]] double bytes() const override { return packs_->bytes() + materials_.bytes(); }

 private:
  [[nodiscard]] PetscInt elements() const override { return packs_->elements; }
  [[nodiscard]] int rows() const override { return packs_->rows(); }
  void hessians(PetscInt first, PetscInt count, const double *u, double *K) const override;
  SplitResult split(PetscInt first, PetscInt count, const double *u, const double *K, double *N,
                    int *negative) const override;
  void add_blocks(PetscInt first, PetscInt count, const double *K, const int *chosen,
                  const ElementPlaces &places, double *const arrays[3]) const override;
  [[nodiscard]] double volume(PetscInt cell) const;
  template <class Visit>
  void for_each_element(const double *u, Visit visit) const;

  const Mesh &mesh_;
  MaterialRuns materials_;
  FilterSpace space_;
  std::shared_ptr<const ElementPacks> packs_;
  ElementKernels kernels_;
  double stiffness_ = 0;          ///< energy of a strain of order one
  double mixed_rest_energy_ = 0;  ///< what the models of mixed runs leave out
};

}  // namespace trefoil
