#include "term/elastic_term.hpp"

#include <algorithm>
#include <utility>

#include "element/element_energy.hpp"
#include "filter/packed_filter.hpp"
#include "material/spreading.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// The part of dP_ij/dF_kl with all indices below dim, dim^2 x dim^2.
void in_plane_part(int dim, const Tangent<double> &A, double *part) {
  const int rows = dim * dim;
  for (int p = 0; p < rows; ++p) {
    for (int q = 0; q < rows; ++q) {
      const int row = 3 * (p / dim) + p % dim, column = 3 * (q / dim) + q % dim;
      part[rows * p + q] = A[static_cast<std::size_t>(9 * row + column)];
    }
  }
}

/// And back, zero elsewhere.
Tangent<double> from_in_plane_part(int dim, const double *part) {
  Tangent<double> A{};
  const int rows = dim * dim;
  for (int p = 0; p < rows; ++p) {
    for (int q = 0; q < rows; ++q) {
      const int row = 3 * (p / dim) + p % dim, column = 3 * (q / dim) + q % dim;
      A[static_cast<std::size_t>(9 * row + column)] = part[rows * p + q];
    }
  }
  return A;
}

}  // namespace

std::shared_ptr<const ElementPacks> pack_cells(const Mesh &mesh) {
  return std::make_shared<ElementPacks>(pack_elements(
      reference_element(mesh.dimension(), mesh.nodes_per_cell()), mesh.cells, mesh.coordinates));
}

ElasticTerm::ElasticTerm(const Mesh &mesh, std::shared_ptr<const ElementPacks> packs,
                         MaterialRuns materials, FilterSpace space, ElementPressure pressure)
    : mesh_(mesh),
      materials_(std::move(materials)),
      space_(space),
      pressure_(pressure),
      packs_(std::move(packs)),
      kernels_(element_kernels(*packs_->reference, pressure)) {
  measure_at_rest();
}

void ElasticTerm::measure_at_rest() {
  const ReferenceElement &reference = *packs_->reference;
  const int dim = reference.dimension, modes = reference.nodes - 1, numbers = dim * dim + 1;
  for (PetscInt cell = 0; cell < packs_->elements; ++cell) {
    double volume = 0,
           squares = 0;  // V, and the sum over the nodes of |g_a|^2 V: that of |G_k|^2 V
    for (int q = 0; q < reference.points; ++q) {
      const double *entry = &packs_->jacobians[static_cast<std::size_t>(
          (reference.points * (cell / lanes) + q) * numbers * lanes + cell % lanes)];
      const double *reduced = &packs_->reduced[static_cast<std::size_t>(q * modes * dim)];
      const double weight = entry[dim * dim * lanes];
      volume += weight;
      for (int k = 0; k < modes * dim; ++k) {
        double G = 0;
        for (int j = 0; j < dim; ++j) {
          G += reduced[k / dim * dim + j] * entry[(dim * j + k % dim) * lanes];
        }
        squares += G * G * weight;
      }
    }
    rest_energy_ += materials_.of_cell(cell).rest_energy_density() * volume;
    stiffness_ += materials_.stiffness_of(cell) * squares;
  }
}

PetscErrorCode ElasticTerm::add_energy(const double *u, EnergySums *sums) const {
  double energies[2] = {0, 0};
  PetscFunctionBeginUser;
  materials_.for_each_run(0, packs_->packs(), [&](const MaterialRuns::Run &run) {
    kernels_.energy(*run.material, *packs_, run.first, run.count, u, energies);
  });
  sums->energy += energies[0];
  sums->strain_energy += energies[0];
  sums->scale += energies[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElasticTerm::add_energy_changes(const double *u, std::size_t, int directions,
                                               const double *const *d, int points,
                                               const double *coefficients, double *changes) const {
  std::vector<PlanePoint> plane;
  PetscFunctionBeginUser;
  for (const double *c = coefficients; c < coefficients + directions * points; c += directions) {
    plane.emplace_back(c[0], directions > 1 ? c[1] : 0);
  }
  std::vector<double> sums(lanes * plane.size(), 0);
  materials_.for_each_run(0, packs_->packs(), [&](const MaterialRuns::Run &run) {
    kernels_.energy_changes(*run.material, *packs_, run.first, run.count, u, directions, d, plane,
                            sums.data());
  });
  for (std::size_t k = 0; k < sums.size(); ++k) changes[k / lanes] += sums[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElasticTerm::add_gradient(const double *u, double *gradient) const {
  PetscFunctionBeginUser;
  materials_.for_each_run(0, packs_->packs(), [&](const MaterialRuns::Run &run) {
    kernels_.forces(*run.material, *packs_, run.first, run.count, u, gradient);
  });
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ElasticTerm::hold_pressures(const double *u, const double *d) {
  held_pressures_.resize(static_cast<std::size_t>(lanes * packs_->packs()));
  materials_.for_each_run(0, packs_->packs(), [&](const MaterialRuns::Run &run) {
    kernels_.pressures(*run.material, *packs_, run.first, run.count, u, d,
                       held_pressures_.data() + lanes * run.first);
  });
}

void ElasticTerm::hessians(PetscInt first, PetscInt count, const double *u, double *K) const {
  materials_.for_each_run(first, count, [&](const MaterialRuns::Run &run) {
    double *of_run = K + packs_->entries() * lanes * (run.first - first);
    if (held_pressures_.empty()) {
      kernels_.hessians(*run.material, *packs_, run.first, run.count, u, of_run);
    } else {
      kernels_.hessians_at_pressures(*run.material, *packs_, run.first, run.count, u,
                                     held_pressures_.data() + lanes * run.first, of_run);
    }
  });
}

SplitResult ElasticTerm::split(PetscInt first, PetscInt count, const double *u, const double *K,
                               double *N, int *negative) const {
  const auto packs = static_cast<int>(count);
  if (space_ == FilterSpace::element) return split_packed(packs_->rows(), packs, K, N, negative);

  const int dim = packs_->reference->dimension, points = packs_->reference->points;
  static thread_local std::vector<double> tangents, negative_parts;
  static thread_local std::vector<int> counts;
  const std::size_t matrices = static_cast<std::size_t>(packs * points) * lanes;
  tangents.resize(matrices * static_cast<std::size_t>(packs_->tangent_entries()));
  negative_parts.resize(tangents.size());
  counts.resize(matrices);
  materials_.for_each_run(first, count, [&](const MaterialRuns::Run &run) {
    kernels_.tangents(
        *run.material, *packs_, run.first, run.count, u,
        tangents.data() + packs_->tangent_entries() * points * lanes * (run.first - first));
  });
  SplitResult result = split_packed(dim * dim, packs * points, tangents.data(),
                                    negative_parts.data(), counts.data());
  kernels_.contract(*packs_, first, count, negative_parts.data(), N);
  // Counts of points are summed to counts of elements; -1 at a point, not finite, is one of all.
  result.indefinite = 0;
  for (int e = 0; e < packs * lanes; ++e) {
    const int *count_at = &counts[static_cast<std::size_t>(e / lanes * points * lanes + e % lanes)];
    negative[e] = 0;
    for (int q = 0; q < points; ++q) {
      const int found = count_at[q * lanes];
      negative[e] = found < 0 || negative[e] < 0 ? -1 : negative[e] + found;
    }
    result.indefinite += negative[e] > 0;
  }
  if (result.first_bad >= 0) result.first_bad = result.first_bad / (points * lanes) * lanes;
  return result;
}

/// One element at a time: the plain path, for output and for what has no batched kernel.
template <class Visit>
void ElasticTerm::for_each_element(const double *u, Visit visit) const {
  const int nodes = packs_->reference->nodes;
  double positions[3 * ReferenceElement::most_nodes],
      displacements[3 * ReferenceElement::most_nodes];
  for (PetscInt cell = 0; cell < packs_->elements; ++cell) {
    const PetscInt *node = &mesh_.cells[static_cast<std::size_t>(nodes * cell)];
    for (int a = 0; a < nodes; ++a) {
      std::copy_n(&mesh_.coordinates[static_cast<std::size_t>(3 * node[a])], 3, positions + 3 * a);
      std::copy_n(u + 3 * node[a], 3, displacements + 3 * a);
    }
    visit(cell, node, IsoparametricElement(*packs_->reference, positions), displacements);
  }
}

std::unique_ptr<Term> ElasticTerm::spreading(Spreading kind) const {
  const auto make = [kind](double stiffness) {
    return kind == Spreading::harmonic ? make_material_model(HarmonicSpreading(stiffness))
                                       : make_material_model(RigidSpreading(stiffness));
  };
  return std::make_unique<ElasticTerm>(mesh_, packs_, materials_.by_stiffness(make),
                                       FilterSpace::element);
}

PetscErrorCode ElasticTerm::add_hessian(const double *u, StencilSink &sink) const {
  const int dim = packs_->reference->dimension, points = packs_->reference->points;
  const int n = dim * packs_->reference->nodes, tangent_rows = dim * dim;
  std::vector<double> H(static_cast<std::size_t>(n * n)), N(H.size());
  std::vector<PetscInt> dofs(static_cast<std::size_t>(n));
  PetscErrorCode error = PETSC_SUCCESS;
  PetscFunctionBeginUser;
  for_each_element(u, [&](PetscInt cell, const PetscInt *node, const IsoparametricElement &element,
                          const double *displacements) {
    if (error) return;
    int negative = 0;
    std::fill(H.begin(), H.end(), 0);
    std::fill(N.begin(), N.end(), 0);
    const MaterialModel &material = materials_.of_cell(cell);
    ElementEnergy(element, material, pressure_, displacements).add_hessian(H.data());
    for (int q = 0; space_ == FilterSpace::deformation && q < points; ++q) {
      Tangent<double> A;
      material.tangent(element.displacement_gradient(q, displacements), A);
      double part[81], negative_part[81];
      int found = 0;
      in_plane_part(dim, A, part);
      static_cast<void>(trefoil::split(tangent_rows, 1, part, negative_part, &found));
      element.add_hessian(q, from_in_plane_part(dim, negative_part), N.data());
      negative = found < 0 || negative < 0 ? -1 : negative + found;
    }
    for (int k = 0; k < n; ++k) dofs[static_cast<std::size_t>(k)] = 3 * node[k / dim] + k % dim;
    const Stencil stencil{.n = n, .dofs = dofs.data(), .cell = cell};
    error = space_ == FilterSpace::element ? sink.add(stencil, H.data())
                                           : sink.add_split(stencil, H.data(), N.data(), negative);
  });
  PetscCall(error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ElasticTerm::describe_cells(const double *u, double *determinant,
                                 double *energy_density) const {
  for_each_element(u, [&](PetscInt cell, const PetscInt *, const IsoparametricElement &element,
                          const double *displacements) {
    const ElementEnergy state(element, materials_.of_cell(cell), pressure_, displacements);
    double volume = 0;
    for (int q = 0; q < packs_->reference->points; ++q) volume += element.weight(q);
    determinant[cell] = state.least_jacobian();
    energy_density[cell] = state.energy() / volume;
  });
}

}  // namespace trefoil
