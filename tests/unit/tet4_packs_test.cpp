// The batched kernels against the plain element, on random, inverted, flat and extreme elements,
// for every instruction set that this machine has.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "element/tet4.hpp"
#include "element/tet4_packs.hpp"
#include "filter/filter.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/mesh.hpp"

namespace trefoil {
namespace {

constexpr PetscInt element_count = 250003;  // not a multiple of eight

/// A heap of unconnected tetrahedra, badly shaped ones among them, and displacements that stretch,
/// flatten and invert them, over twelve orders of magnitude in length.
struct Heap {
  Mesh mesh;
  std::vector<double> u;

  explicit Heap(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (PetscInt e = 0; e < element_count; ++e) {
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
        mesh.cells.push_back(4 * e + a);
        for (int i = 0; i < 3; ++i) {
          mesh.coordinates.push_back(corner[a][i]);
          // Every seventh is pressed flat: all corners end at z = 0.
          u.push_back(e % 7 == 0 && i == 2 ? -corner[a][i] : pull * length * uniform(random));
        }
      }
    }
  }
};

/// The plain element's values, in the kernels' form.
struct Plain {
  std::vector<double> density, forces, hessians;  ///< hessians: 12 x 12 each

  Plain(const Heap &heap, const StableNeoHookean &material) {
    forces.resize(heap.u.size());
    for (std::size_t e = 0; e < static_cast<std::size_t>(element_count); ++e) {
      double corner[4][3], H[144];
      std::copy_n(&heap.mesh.coordinates[12 * e], 12, &corner[0][0]);
      const Tet4 tet = Tet4::at_rest(corner);
      const Matrix3<double> F = tet.deformation_gradient(&heap.u[12 * e]);
      density.push_back(material.energy_density(F) * tet.volume);
      tet.add_force(material.stress(F), &forces[12 * e]);
      Tangent<double> tangent;
      material.tangent(F, tangent);
      tet.hessian(tangent, H);
      hessians.insert(hessians.end(), H, H + 144);
    }
  }
};

class Tet4PacksTest : public testing::TestWithParam<InstructionSet> {
 protected:
  void SetUp() override {
    if (!processor_has(GetParam())) GTEST_SKIP() << "not on this processor";
  }

  static Tet4Kernels kernels() { return tet4_kernels(GetParam()); }
  static AddBlocks add_blocks() { return add_blocks_kernel(GetParam()); }
};

/// Largest difference of `count` numbers, relative to the largest of the reference.
double relative_difference(const double *a, const double *reference, std::size_t count) {
  double difference = 0, largest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    difference = std::max(difference, std::abs(a[i] - reference[i]));
    largest = std::max(largest, std::abs(reference[i]));
  }
  return difference / largest;
}

TEST_P(Tet4PacksTest, EqualThePlainElement) {
  for (double poisson : {0.3, 0.495, 0.4999}) {
    const StableNeoHookean material({1e6, poisson}, StableNeoHookean::Lame::physical);
    const auto model = make_material_model(material, GetParam());
    const Heap heap(static_cast<unsigned>(1e4 * poisson));
    const Plain plain(heap, material);
    const Tet4Packs tets = pack_tetrahedra(heap.mesh);

    double sums[2] = {0, 0}, energy = 0;
    kernels().energy(*model, tets, 0, tets.packs(), heap.u.data(), 0, sums);
    for (double density : plain.density) energy += density;
    EXPECT_NEAR(sums[0] / energy, 1, 1e-12);
    EXPECT_NEAR(sums[1] / energy, 1, 1e-12) << "psi is nowhere negative";

    std::vector<double> forces(heap.u.size());
    kernels().forces(*model, tets, 0, tets.packs(), heap.u.data(), forces.data());

    std::vector<double> K(static_cast<std::size_t>(tets.packs()) * reduced_entries * lanes);
    kernels().reduced_hessians(*model, tets, 0, tets.packs(), heap.u.data(), K.data());
    // Each element into 144 numbers of its own: row by row, blocks 12 apart.
    BlockPlaces places;
    places.stride.assign(static_cast<std::size_t>(16 * element_count), 12);
    for (std::int32_t e = 0; e < element_count; ++e) {
      for (std::int32_t a = 0; a < 4; ++a) {
        for (std::int32_t b = 0; b < 4; ++b) {
          places.code.push_back(4 * (144 * e + 36 * a + 3 * b) + 1);
        }
      }
    }
    std::vector<double> hessians(plain.hessians.size(), 0);
    double *arrays[4] = {nullptr, hessians.data(), nullptr, nullptr};
    add_blocks()(tets, 0, tets.packs(), K.data(), nullptr, places, arrays);

    double worst_force = 0, worst_hessian = 0;
    for (std::size_t e = 0; e < static_cast<std::size_t>(element_count); ++e) {
      double corner[4][3], stiffness = 0, reach = 0, steepest = 0, force_difference = 0;
      std::copy_n(&heap.mesh.coordinates[12 * e], 12, &corner[0][0]);
      const Tet4 tet = Tet4::at_rest(corner);
      for (std::size_t k = 0; k < 144; ++k) {
        stiffness = std::max(stiffness, std::abs(plain.hessians[144 * e + k]));
      }
      for (std::size_t k = 0; k < 12; ++k) {
        reach = std::max(
            {reach, std::abs(heap.u[12 * e + k]), std::abs(heap.mesh.coordinates[12 * e + k])});
        steepest = std::max(steepest, std::abs(tet.gradients[k / 3][k % 3]));
        force_difference =
            std::max(force_difference, std::abs(forces[12 * e + k] - plain.forces[12 * e + k]));
      }
      // F = I + sum u_a g_a' loses digits where its terms are larger than itself: so do both paths.
      const double amplification = 1 + reach * steepest;
      worst_force = std::max(worst_force, force_difference / (stiffness * reach * amplification));
      worst_hessian = std::max(
          worst_hessian,
          relative_difference(&hessians[144 * e], &plain.hessians[144 * e], 144) / amplification);
    }
    std::printf("nu %.4f: forces differ by %.1e, Hessians by %.1e\n", poisson, worst_force,
                worst_hessian);
    EXPECT_LT(worst_force, 1e-13);
    EXPECT_LT(worst_hessian, 1e-13);
  }
}

TEST_P(Tet4PacksTest, AddsOnlyWhatIsChosen) {
  const StableNeoHookean material({1, 0.4}, StableNeoHookean::Lame::physical);
  Heap heap(7);
  heap.mesh.cells.resize(4 * 19);  // two full packs and a part
  const Tet4Packs tets = pack_tetrahedra(heap.mesh);
  ASSERT_EQ(tets.packs(), 3);
  std::vector<double> K(static_cast<std::size_t>(3 * reduced_entries * lanes), 1.0);
  std::vector<int> chosen(static_cast<std::size_t>(3 * lanes), 0);
  chosen[5] = 2;
  chosen[10] = -1;  // not finite: not chosen
  chosen[18] = 1;
  chosen[20] = 1;  // behind the last element: a copy that fills the pack
  BlockPlaces places;
  places.stride.assign(heap.mesh.coordinates.size() * 2, 3);
  for (std::int32_t e = 0; e < 19; ++e) {
    for (int block = 0; block < 16; ++block) places.code.push_back(4 * 9 * e);
  }
  std::vector<double> sums(9 * 20, 0);
  double *arrays[4] = {sums.data(), nullptr, nullptr, nullptr};
  add_blocks()(tets, 0, 3, K.data(), chosen.data(), places, arrays);
  for (std::size_t e = 0; e < 20; ++e) {
    const double size =
        std::abs(*std::max_element(sums.begin() + static_cast<std::ptrdiff_t>(9 * e),
                                   sums.begin() + static_cast<std::ptrdiff_t>(9 * e + 9),
                                   [](double a, double b) { return std::abs(a) < std::abs(b); }));
    // A rigid translation costs nothing, so all blocks of an element together are zero; chosen
    // elements leave rounding or exact zeros, so look at one block's place only.
    EXPECT_LT(size, 1e-12) << e;
  }
  // Without the cancellation: only block (0, 0) of each element.
  for (std::size_t k = 0; k < places.code.size(); ++k) {
    if (k % 16 != 0) places.code[k] = 4 * 9 * 19 + 0;
  }
  std::fill(sums.begin(), sums.end(), 0);
  add_blocks()(tets, 0, 3, K.data(), chosen.data(), places, arrays);
  for (std::size_t e = 0; e < 19; ++e) {
    const bool wanted = e == 5 || e == 18;
    EXPECT_EQ(sums[9 * e], wanted ? 9 * 0.25 : 0) << e;
  }
}

std::string name_of(const testing::TestParamInfo<InstructionSet> &set) {
  switch (set.param) {
    case InstructionSet::avx512:
      return "avx512";
    case InstructionSet::avx2:
      return "avx2";
    default:
      return "baseline";
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, Tet4PacksTest,
                         testing::Values(InstructionSet::baseline, InstructionSet::avx2,
                                         InstructionSet::avx512),
                         name_of);

}  // namespace
}  // namespace trefoil
