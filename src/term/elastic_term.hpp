#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "element/element_packs.hpp"
#include "material/material_runs.hpp"
#include "material/spreading.hpp"
#include "mesh/mesh.hpp"
#include "term/packed_elements.hpp"
#include "term/term.hpp"

namespace trefoil {

/// The cells of a mesh in packs.
std::shared_ptr<const ElementPacks> pack_cells(const Mesh &mesh);

/// The elastic energy of a body of elements of any kind, the sum over their quadrature points of
/// psi(F) w; in the plane of plane strain. Nearly incompressible bodies of quadratic elements do
/// better with their volumetric part at the element's mean of J, see ElementPressure.
class ElasticTerm final : public Term, private PackedElements {
 public:
  /// A body of one material.
  ElasticTerm(const Mesh &mesh, std::unique_ptr<MaterialModel> material, FilterSpace space,
              ElementPressure pressure = ElementPressure::pointwise)
      : ElasticTerm(mesh, MaterialRuns(std::move(material), mesh.local_cells()), space, pressure) {}

  /// A body of several materials.
  /// @param pressure other than `pointwise` for quadratic cells of materials that split their
  ///        volumetric part off, filtered by elements
  ElasticTerm(const Mesh &mesh, MaterialRuns materials, FilterSpace space,
              ElementPressure pressure = ElementPressure::pointwise)
      : ElasticTerm(mesh, pack_cells(mesh), std::move(materials), space, pressure) {}

  /// With elements that another term has packed.
  ElasticTerm(const Mesh &mesh, std::shared_ptr<const ElementPacks> packs, MaterialRuns materials,
              FilterSpace space, ElementPressure pressure = ElementPressure::pointwise);

  /// Takes other materials for the same cells, and gives back those it had. What is known of the
  /// body at rest stays: rest_energy() and stiffness().
  void exchange_materials(MaterialRuns &other) { std::swap(materials_, other); }

  /// Hessians, in batches, have from now on pressures of the elements that are unknowns of their
  /// own: those after a step d, linearised at u. Where elements have one.
  /// @param u, d local arrays, 3 numbers a local vertex
  void hold_pressures(const double *u, const double *d);
  /// They have those at u again.
  void release_pressures() { held_pressures_.clear(); }

  PetscErrorCode add_energy(const double *u, EnergySums *sums) const override;
  [[nodiscard]] double rest_energy() const override { return rest_energy_; }
  [[nodiscard]] double stiffness() const override { return stiffness_; }
  PetscErrorCode add_energy_changes(const double *u, std::size_t size, int directions,
                                    const double *const *d, int points, const double *coefficients,
                                    double *changes) const override;
  PetscErrorCode add_gradient(const double *u, double *gradient) const override;
  [[nodiscard]] HessianKind hessian_kind() const override { return HessianKind::packed; }
  PetscErrorCode add_hessian(const double *u, StencilSink &sink) const override;
  [[nodiscard]] const PackedElements *batch() const override { return this; }
  [[nodiscard]] bool has_cells() const override { return true; }
  /// The least det F and the mean psi of an element's quadrature points.
  void describe_cells(const double *u, double *determinant, double *energy_density) const override;
  [[nodiscard]] std::unique_ptr<Term> spreading(Spreading kind) const override;
  [[nodiscard]] double bytes() const override { return packs_->bytes() + materials_.bytes(); }

 private:
  [[nodiscard]] const ElementPacks &elements() const override { return *packs_; }
  [[nodiscard]] decltype(ElementKernels::expand) expand() const override { return kernels_.expand; }
  [[nodiscard]] FilterSpace filter_space() const override { return space_; }
  void hessians(PetscInt first, PetscInt count, const double *u, double *K) const override;
  SplitResult split(PetscInt first, PetscInt count, const double *u, const double *K, double *N,
                    int *negative) const override;
  /// Finds rest_energy_ and stiffness_.
  void measure_at_rest();
  template <class Visit>
  void for_each_element(const double *u, Visit visit) const;

  const Mesh &mesh_;
  MaterialRuns materials_;
  FilterSpace space_;
  ElementPressure pressure_;
  std::shared_ptr<const ElementPacks> packs_;
  ElementKernels kernels_;
  double stiffness_ = 0;
  double rest_energy_ = 0;              ///< what the models leave out
  std::vector<double> held_pressures_;  ///< empty, or eight a pack
};

}  // namespace trefoil
