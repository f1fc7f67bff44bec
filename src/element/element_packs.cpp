#include "element/element_packs.hpp"

#include <algorithm>
#include <cmath>

#include "element/isoparametric_element.hpp"
#include "mesh/mesh.hpp"
#include "simd/instruction_set.hpp"

namespace trefoil {
namespace {

/// Reduced gradients on the reference cell, see ElementPacks.
std::vector<double> reduced_gradients(const ReferenceElement &reference) {
  const double s = 1 / std::sqrt(static_cast<double>(reference.nodes)), c = s * s / (1 - s);
  std::vector<double> reduced;
  for (int q = 0; q < reference.points; ++q) {
    const auto &g = reference.gradients[q];
    for (int k = 0; k + 1 < reference.nodes; ++k) {
      for (int j = 0; j < reference.dimension; ++j) {
        double sum = 0;
        for (int a = 1; a < reference.nodes; ++a) sum += g[a][j];
        reduced.push_back(g[k + 1][j] + s * g[0][j] - c * sum);
      }
    }
  }
  return reduced;
}

}  // namespace

ElementPacks pack_elements(const Mesh &mesh) {
  ElementPacks packed;
  packed.reference = &reference_element(mesh.dimension(), mesh.nodes_per_cell());
  const ReferenceElement &reference = *packed.reference;
  packed.elements = mesh.local_cells();
  packed.reduced = reduced_gradients(reference);
  const auto packs = static_cast<std::size_t>(packed.packs());
  const auto nodes = static_cast<std::size_t>(reference.nodes);
  const auto points = static_cast<std::size_t>(reference.points);
  const auto dim = static_cast<std::size_t>(reference.dimension);
  const std::size_t numbers = dim * dim + 1;
  packed.nodes.resize(packs * nodes * lanes);
  packed.jacobians.resize(packs * points * numbers * lanes);
  for (std::size_t e = 0; e < packs * lanes; ++e) {
    const std::size_t pack = e / lanes, lane = e % lanes;
    const std::size_t source = std::min(e, static_cast<std::size_t>(packed.elements) - 1);
    const PetscInt *node = &mesh.cells[nodes * source];
    double position[3 * ReferenceElement::most_nodes];
    for (std::size_t a = 0; a < nodes; ++a) {
      packed.nodes[(nodes * pack + a) * lanes + lane] = node[a];
      std::copy_n(&mesh.coordinates[3 * static_cast<std::size_t>(node[a])], 3, position + 3 * a);
    }
    const IsoparametricElement element(reference, position);
    for (std::size_t q = 0; q < points; ++q) {
      double *entry = &packed.jacobians[(points * pack + q) * numbers * lanes + lane];
      const Matrix3<double> &inverse = element.inverse_jacobian(static_cast<int>(q));
      for (std::size_t k = 0; k < dim * dim; ++k, entry += lanes) {
        *entry = inverse(static_cast<int>(k / dim), static_cast<int>(k % dim));
      }
      *entry = source == e ? element.weight(static_cast<int>(q)) : 0;
    }
  }
  return packed;
}

ElementKernels element_kernels(const ReferenceElement &reference, InstructionSet instructions) {
  return for_instruction_set(instructions, [&]<InstructionSet isa>() {
    return make_element_kernels<isa>(reference.dimension, reference.nodes);
  });
}

}  // namespace trefoil
