#pragma once

// Tetrahedra of all sorts, for the tests that compare the batched kernels with the plain element.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "assembly/block_sums.hpp"
#include "filter/filter.hpp"
#include "filter/reduced_filter.hpp"
#include "material/stable_neo_hookean.hpp"
#include "tet4_support.hpp"

namespace trefoil::tet4_heap {

/// A heap of unconnected tetrahedra, badly shaped ones among them, and displacements that stretch,
/// flatten and invert them, over twelve orders of magnitude in length.
struct Heap {
  std::vector<PetscInt> cells;
  std::vector<double> coordinates, u;

  [[nodiscard]] std::size_t elements() const { return cells.size() / 4; }
  /// With the corners in the order of their vertices' numbers.
  [[nodiscard]] Tet4 element(std::size_t e) const {
    double corner[4][3];
    std::copy_n(&coordinates[12 * e], 12, &corner[0][0]);
    return Tet4::at_rest(corner);
  }

  [[nodiscard]] ElementPacks packs() const {
    return pack_elements(reference_element(3, 4), cells, coordinates);
  }

  Heap(unsigned seed, PetscInt elements) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (PetscInt e = 0; e < elements; ++e) {
      const double length = std::pow(10.0, 6 * uniform(random));
      const double flatness = e % 5 == 0 ? 1e-4 : 1;
      const double pull = e % 3 == 0 ? 3 : e % 3 == 1 ? 0.1 : 1e-9;
      double corner[4][3], volume = 0;
      do {
        for (auto &p : corner) {
          for (int i = 0; i < 3; ++i) p[i] = length * uniform(random) * (i == 2 ? flatness : 1);
        }
        volume = Tet4::at_rest(corner).volume;
      } while (std::abs(volume) < 1e-3 * flatness * length * length * length);
      if (volume < 0) std::swap(corner[0], corner[1]);
      for (int a = 0; a < 4; ++a) {
        cells.push_back(4 * e + (a == 3 ? 3 : (a + e) % 3));  // an even permutation
        for (int i = 0; i < 3; ++i) {
          coordinates.push_back(corner[a][i]);
          // Every seventh is pressed flat: all corners end at z = 0.
          u.push_back(e % 7 == 0 && i == 2 ? -corner[a][i] : pull * length * uniform(random));
        }
      }
    }
  }
};

/// The plain element's values, element by element; matrices are 12 x 12.
struct Plain {
  std::vector<double> energy, forces, hessians, negatives;

  Plain(const Heap &heap, const StableNeoHookean &material) {
    forces.resize(heap.u.size());
    for (std::size_t e = 0; e < heap.elements(); ++e) {
      double H[144];
      const Tet4 tet = heap.element(e);
      const Deformation<double> deformation(tet.displacement_gradient(&heap.u[12 * e]));
      energy.push_back(material.energy_density(deformation) * tet.volume);
      tet.add_force(material.stress(deformation), &forces[12 * e]);
      Tangent<double> tangent;
      material.tangent(deformation, tangent);
      tet.hessian(tangent, H);
      hessians.insert(hessians.end(), H, H + 144);
    }
    negatives.resize(hessians.size());
    static_cast<void>(
        split(12, static_cast<int>(heap.elements()), hessians.data(), negatives.data(), nullptr));
  }
};

/// Places of blocks such that element e gets 144 numbers of its own from 144 e on, row by row, in
/// the order of its vertices' numbers.
inline PetscErrorCode make_single_sums(const ElementPacks &tets, BlockSums *sums) {
  const auto place = [](PetscInt row, PetscInt column, BlockPlace *result) {
    *result = {4 * (144 * (row / 4) + 36 * (row % 4) + 3 * (column % 4)), 12};
    return static_cast<PetscErrorCode>(0);
  };
  return make_block_sums(tets, place, sums);
}

/// Largest difference of `count` numbers, relative to `size`.
inline double difference(const double *a, const double *b, std::size_t count, double size) {
  double result = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(std::abs(a[i] - b[i]) <= result)) result = std::abs(a[i] - b[i]);  // also NaN
  }
  return std::isfinite(result) ? result / size : std::numeric_limits<double>::infinity();
}
inline double largest(const double *a, std::size_t count) {
  double result = 0;
  for (std::size_t i = 0; i < count; ++i) result = std::max(result, std::abs(a[i]));
  return result;
}

/// The same from the batched kernels: the reduced matrices expanded to 12 x 12.
struct Batched {
  double energy = 0, scale = 0;
  std::vector<double> forces, hessians, negatives;
  long indefinite = 0, fallbacks = 0;

  Batched(const Heap &heap, const MaterialModel &material, InstructionSet instructions) {
    const ElementPacks tets = heap.packs();
    const ElementKernels kernels =
        element_kernels(*tets.reference, ElementPressure::pointwise, instructions);
    const auto add_blocks = add_blocks_kernel(*tets.reference, instructions);
    double sums[2] = {0, 0};
    kernels.energy(material, tets, 0, tets.packs(), heap.u.data(), sums);
    energy = sums[0];
    scale = sums[1];
    forces.resize(heap.u.size());
    kernels.forces(material, tets, 0, tets.packs(), heap.u.data(), forces.data());

    std::vector<double> K(static_cast<std::size_t>(tets.packs()) * reduced_entries * lanes);
    std::vector<double> N(K.size());
    std::vector<int> negative(static_cast<std::size_t>(tets.packs()) * lanes);
    kernels.hessians(material, tets, 0, tets.packs(), heap.u.data(), K.data());
    ReducedSplitExperiment experiment;
    experiment.instructions = instructions;
    indefinite = split_reduced(static_cast<int>(tets.packs()), K.data(), N.data(), negative.data(),
                               experiment)
                     .indefinite;
    fallbacks = experiment.fallbacks;
    BlockSums places;
    static_cast<void>(make_single_sums(tets, &places));
    hessians.resize(144 * heap.elements(), 0);
    negatives.resize(144 * heap.elements(), 0);
    double *H_arrays[4] = {hessians.data()}, *N_arrays[4] = {negatives.data()};
    add_blocks(places, kernels.expand, 0, tets.packs(), K.data(), nullptr, H_arrays);
    add_blocks(places, kernels.expand, 0, tets.packs(), N.data(), negative.data(), N_arrays);
  }
};

/// How much larger the products in the determinant of the edges are than what is left of them: the
/// rest gradients and the volume are known to eps times this, whoever computes them.
inline double cancellation(const double *corner) {
  double products = 0, determinant = 0;
  for (int j = 0; j < 6; ++j) {
    double product = j < 3 ? 1 : -1;
    for (int i = 0; i < 3; ++i) {
      const int column = j < 3 ? (i + j) % 3 : (3 - i + j) % 3;
      product *= corner[3 * (column + 1) + i] - corner[i];
    }
    products += std::abs(product);
    determinant += product;
  }
  return products / std::abs(determinant);
}

/// The largest over all elements, relative to the element's stiffness.
struct Differences {
  double force = 0, hessian = 0, negative = 0;
  double of_rounding = 0;  ///< of all three, relative to the cancellation at rest as well

  Differences() = default;
  Differences(const Heap &heap, const Plain &plain, const Batched &batched) {
    for (std::size_t e = 0; e < heap.elements(); ++e) {
      const double *H = &plain.hessians[144 * e];
      const double stiffness = largest(H, 144);
      const double reach =
          std::max(largest(&heap.u[12 * e], 12), largest(&heap.coordinates[12 * e], 12));
      // F = I + sum u_a g_a' loses digits where its terms are larger than itself: so do both paths.
      const Tet4 tet = heap.element(e);
      const double amplification = 1 + reach * largest(&tet.gradients[0][0], 12);
      const double size = stiffness * amplification;
      Differences here;
      here.force = difference(&batched.forces[12 * e], &plain.forces[12 * e], 12, size * reach);
      here.hessian = difference(&batched.hessians[144 * e], H, 144, size);
      here.negative = difference(&batched.negatives[144 * e], &plain.negatives[144 * e], 144, size);
      here.of_rounding = std::max({here.force, here.hessian, here.negative}) /
                         cancellation(&heap.coordinates[12 * e]);
      include(here);
    }
  }
  void include(const Differences &other) {
    force = std::max(force, other.force);
    hessian = std::max(hessian, other.hessian);
    negative = std::max(negative, other.negative);
    of_rounding = std::max(of_rounding, other.of_rounding);
  }
};

}  // namespace trefoil::tet4_heap
