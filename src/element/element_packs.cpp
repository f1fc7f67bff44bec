#include "element/element_packs.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "element/isoparametric_element.hpp"
#include "simd/instruction_set.hpp"

namespace trefoil {
namespace {

constexpr std::size_t most_nodes = ReferenceElement::most_nodes;
using NodeOrder = std::array<std::size_t, most_nodes>;

/// Number of the node on edge (i, j) in the reference element, where i == j the corner itself.
std::size_t node_between(int dimension, std::size_t i, std::size_t j) {
  constexpr std::size_t midpoint[4][4] = {{0, 0, 2, 3}, {0, 0, 1, 4}, {2, 1, 0, 5}, {3, 4, 5, 0}};
  return i == j ? i : static_cast<std::size_t>(dimension) + 1 + midpoint[i][j];
}

/// The nodes of the reference element in the order of ElementPacks, for corners in a given order.
NodeOrder packed_order(const ReferenceElement &reference,
                       const std::array<std::size_t, 4> &corner) {
  const auto corners = static_cast<std::size_t>(reference.dimension) + 1;
  NodeOrder order{};
  std::copy_n(corner.begin(), corners, order.begin());
  std::size_t next = corners;
  for (std::size_t i = 0; next < static_cast<std::size_t>(reference.nodes) && i < corners; ++i) {
    for (std::size_t j = i + 1; j < corners; ++j) {
      order[next++] = node_between(reference.dimension, corner[i], corner[j]);
    }
  }
  return order;
}

/// Reduced gradients on the reference cell, see ElementPacks.
std::vector<double> reduced_gradients(const ReferenceElement &reference) {
  const double s = 1 / std::sqrt(static_cast<double>(reference.nodes)), c = s * s / (1 - s);
  const NodeOrder order = packed_order(reference, {0, 1, 2, 3});
  std::vector<double> reduced;
  for (int q = 0; q < reference.points; ++q) {
    const auto &g = reference.gradients[q];
    for (std::size_t k = 0; k + 1 < static_cast<std::size_t>(reference.nodes); ++k) {
      for (int j = 0; j < reference.dimension; ++j) {
        double sum = 0;
        for (int a = 1; a < reference.nodes; ++a) sum += g[a][j];
        reduced.push_back(g[order[k + 1]][j] + s * g[0][j] - c * sum);
      }
    }
  }
  return reduced;
}

/// A cell with its corners in ascending order.
struct SortedCell {
  NodeOrder order{};                ///< its nodes as they stand in a pack
  double position[3 * most_nodes];  ///< of its nodes, in the order of the reference element
  bool mirrored = false;

  SortedCell(const ReferenceElement &reference, const PetscInt *cell, const double *coordinates) {
    const auto corners = static_cast<std::size_t>(reference.dimension) + 1;
    std::array<std::size_t, 4> corner{0, 1, 2, 3};
    for (std::size_t i = 0; i < corners; ++i) {  // insertion sort: each exchange mirrors
      for (std::size_t k = i; k > 0 && cell[corner[k]] < cell[corner[k - 1]]; --k) {
        std::swap(corner[k], corner[k - 1]);
        mirrored = !mirrored;
      }
    }
    order = packed_order(reference, corner);
    const NodeOrder place = packed_order(reference, {0, 1, 2, 3});
    for (std::size_t a = 0; a < static_cast<std::size_t>(reference.nodes); ++a) {
      std::copy_n(coordinates + 3 * cell[order[a]], 3, position + 3 * place[a]);
    }
  }
};

}  // namespace

ElementPacks pack_elements(const ReferenceElement &reference, std::span<const PetscInt> cells,
                           std::span<const double> coordinates) {
  ElementPacks packed;
  packed.reference = &reference;
  packed.elements = static_cast<PetscInt>(cells.size()) / reference.nodes;
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
    const PetscInt *node = &cells[nodes * source];
    const SortedCell cell(reference, node, coordinates.data());
    for (std::size_t a = 0; a < nodes; ++a) {
      packed.nodes[(nodes * pack + a) * lanes + lane] = node[cell.order[a]];
    }
    const IsoparametricElement element(reference, cell.position);
    const double orientation = source != e ? 0 : cell.mirrored ? -1 : 1;
    for (std::size_t q = 0; q < points; ++q) {
      double *entry = &packed.jacobians[(points * pack + q) * numbers * lanes + lane];
      const Matrix3<double> &inverse = element.inverse_jacobian(static_cast<int>(q));
      for (std::size_t k = 0; k < dim * dim; ++k, entry += lanes) {
        *entry = inverse(static_cast<int>(k / dim), static_cast<int>(k % dim));
      }
      *entry = orientation * element.weight(static_cast<int>(q));
    }
  }
  return packed;
}

ElementKernels element_kernels(const ReferenceElement &reference, ElementPressure pressure,
                               InstructionSet instructions) {
  return for_instruction_set(instructions, [&]<InstructionSet isa>() {
    return make_element_kernels<isa>(reference.dimension, reference.nodes, pressure);
  });
}

}  // namespace trefoil
