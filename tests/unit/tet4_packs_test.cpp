// The batched kernels against the plain element, on random, inverted, flat and extreme elements,
// for every instruction set that this machine has.

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <random>
#include <string>

#include "simd/instruction_set.hpp"
#include "tet4_heap.hpp"

namespace trefoil {
namespace {

using namespace tet4_heap;

class Tet4PacksTest : public testing::TestWithParam<InstructionSet> {
 protected:
  void SetUp() override {
    if (!processor_has(GetParam())) GTEST_SKIP() << "not on this processor";
  }

  static void add_blocks(const BlockSums &sums, PetscInt first, PetscInt count, const double *K,
                         const int *chosen, double *const arrays[3]) {
    const ReferenceElement &tet4 = reference_element(3, 4);
    add_blocks_kernel(tet4, GetParam())(
        sums, element_kernels(tet4, ElementPressure::pointwise, GetParam()).expand, first, count, K,
        chosen, arrays);
  }
};

TEST_P(Tet4PacksTest, EqualThePlainElement) {
  for (double poisson : {0.3, 0.495, 0.4999}) {
    const StableNeoHookean material({1e6, poisson}, StableNeoHookean::Lame::physical);
    const auto model = make_material_model(material, GetParam());
    const Heap heap(static_cast<unsigned>(1e4 * poisson), 20003);  // not a multiple of eight
    const Plain plain(heap, material);
    const Batched batched(heap, *model, GetParam());
    double energy = 0;
    for (double each : plain.energy) energy += each;
    EXPECT_NEAR(batched.energy / energy, 1, 1e-12);
    EXPECT_NEAR(batched.scale / energy, 1, 1e-12) << "psi is nowhere negative";
    const Differences differences(heap, plain, batched);
    std::printf("nu %.4f: forces differ by %.1e, Hessians by %.1e, negative parts by %.1e\n",
                poisson, differences.force, differences.hessian, differences.negative);
    EXPECT_LT(differences.force, 1e-13);
    EXPECT_LT(differences.hessian, 1e-13);
    EXPECT_LT(differences.negative, 1e-13);
  }
}

TEST_P(Tet4PacksTest, AddsOnlyWhatIsChosen) {
  const Heap heap(7, 19);  // two full packs and a part
  const ElementPacks tets = heap.packs();
  ASSERT_EQ(tets.packs(), 3);
  std::vector<double> K(static_cast<std::size_t>(3 * reduced_entries * lanes), 1.0);
  std::vector<int> chosen(static_cast<std::size_t>(3 * lanes), 0);
  chosen[5] = 2;
  chosen[10] = -1;  // not finite: not chosen
  for (std::size_t entry = 0; entry < reduced_entries; ++entry) {
    K[(reduced_entries + entry) * lanes + 2] = std::numeric_limits<double>::quiet_NaN();
  }
  chosen[18] = 1;
  chosen[20] = 1;  // behind the last element: a copy that fills the pack
  BlockSums sums;
  // Of each element only the block of its first vertex exists.
  const auto place = [](PetscInt row, PetscInt column, BlockPlace *result) {
    *result = row % 4 == 0 && column == row ? BlockPlace{4 * 9 * (row / 4), 3} : BlockPlace{};
    return static_cast<PetscErrorCode>(0);
  };
  ASSERT_EQ(make_block_sums(tets, place, &sums), 0);
  std::vector<double> result(9 * 20, 0);
  double *arrays[4] = {result.data(), nullptr, nullptr, nullptr};
  add_blocks(sums, 0, 3, K.data(), chosen.data(), arrays);
  for (std::size_t k = 0; k < result.size(); ++k) {
    const bool wanted = k / 9 == 5 || k / 9 == 18;
    EXPECT_EQ(result[k], wanted ? 9 * 0.25 : 0) << k;  // nine reduced entries, times two halves
  }
}

TEST_P(Tet4PacksTest, SumsOfNeighboursAreThoseOfThePlainElements) {
  // A fan: all elements share vertices 0 and 1, so that long sums occur, in several tiles.
  const StableNeoHookean material({1, 0.4}, StableNeoHookean::Lame::physical);
  const Heap shapes(11, 3 * 8 * tile_packs(4) + 5);
  const ElementPacks alone = shapes.packs();
  const auto elements = static_cast<std::size_t>(alone.elements);
  const std::size_t vertices = elements + 3;
  ElementPacks fan = alone;
  for (std::size_t e = 0; e < elements; ++e) {
    PetscInt *vertex = &fan.nodes[4 * lanes * (e / lanes) + e % lanes];
    const auto next = static_cast<PetscInt>(e);
    const PetscInt corners[4] = {0, 1, next + 2, next + 3};
    for (std::size_t a = 0; a < 4; ++a) vertex[lanes * a] = corners[a];
  }
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<double> K(static_cast<std::size_t>(alone.packs()) * reduced_entries * lanes);
  for (double &k : K) k = uniform(random);
  std::vector<double> single(144 * elements, 0);
  double *arrays[4] = {single.data(), nullptr, nullptr, nullptr};
  BlockSums single_sums, fan_sums;
  ASSERT_EQ(make_single_sums(alone, &single_sums), 0);
  add_blocks(single_sums, 0, alone.packs(), K.data(), nullptr, arrays);

  // A dense matrix: most blocks regular, those of every fifth vertex number by number, and without
  // this vertex's second component.
  const std::size_t n = 3 * vertices;
  std::vector<double> expected(n * n, 0), dense(n * n, 0);
  const auto is_partly_held = [](std::size_t v) { return v % 5 == 0; };
  const auto is_held = [&](std::size_t dof) { return is_partly_held(dof / 3) && dof % 3 == 1; };
  const auto place = [&](PetscInt row, PetscInt column, BlockPlace *result) {
    const auto v = static_cast<std::size_t>(row), w = static_cast<std::size_t>(column);
    const auto code_of = [&](std::size_t i, std::size_t j) {
      return static_cast<std::int32_t>(4 * ((3 * v + i) * n + 3 * w + j) + 2);
    };
    *result = {code_of(0, 0), static_cast<std::int32_t>(n)};
    if (is_partly_held(v) || is_partly_held(w)) {
      *result = {static_cast<std::int32_t>(4 * fan_sums.numbers.size()), 0};
      for (std::size_t k = 0; k < 9; ++k) {
        const bool held = is_held(3 * v + k / 3) || is_held(3 * w + k % 3);
        fan_sums.numbers.push_back(held ? -1 : code_of(k / 3, k % 3));
      }
    }
    return static_cast<PetscErrorCode>(0);
  };
  ASSERT_EQ(make_block_sums(fan, place, &fan_sums), 0);
  double *dense_arrays[4] = {nullptr, nullptr, dense.data(), nullptr};
  const PetscInt half = tile_packs(4);
  add_blocks(fan_sums, 0, half, K.data(), nullptr, dense_arrays);
  add_blocks(fan_sums, half, fan.packs() - half,
             K.data() + static_cast<std::ptrdiff_t>(half) * reduced_entries * lanes, nullptr,
             dense_arrays);
  for (std::size_t e = 0; e < elements; ++e) {
    const std::size_t corners[4] = {0, 1, e + 2, e + 3};
    for (std::size_t i = 0; i < 12; ++i) {
      for (std::size_t j = 0; j < 12; ++j) {
        const std::size_t row = 3 * corners[i / 3] + i % 3, column = 3 * corners[j / 3] + j % 3;
        if (is_held(row) || is_held(column)) continue;
        expected[row * n + column] += single[144 * e + 12 * i + j];
      }
    }
  }
  EXPECT_LT(difference(dense.data(), expected.data(), n * n, largest(expected.data(), n * n)),
            1e-14);
}

/// Nothing is lost on a million elements of all sorts, by the chosen instruction set.
TEST(Tet4MillionTest, FastEqualsPlain) {
  constexpr PetscInt heap_size = 20000;
  Differences worst;
  long indefinite = 0, fallbacks = 0, elements = 0;
  double energy = 0, energy_difference = 0;
  for (unsigned seed = 0; elements < 1000000; ++seed, elements += heap_size) {
    const double poisson = seed % 3 == 0 ? 0.3 : seed % 3 == 1 ? 0.495 : 0.4999;
    const StableNeoHookean material({1e6, poisson}, StableNeoHookean::Lame::physical);
    const Heap heap(1000 + seed, heap_size);
    const Plain plain(heap, material);
    const Batched batched(heap, *make_material_model(material), chosen_instruction_set());
    const Differences here(heap, plain, batched);
    worst.include(here);
    energy = 0;
    for (double each : plain.energy) energy += each;
    energy_difference = std::max(energy_difference, std::abs(batched.energy / energy - 1));
    indefinite += batched.indefinite;
    fallbacks += batched.fallbacks;
  }
  std::printf(
      "%ld elements, %ld indefinite, %ld by LAPACK after all; largest differences, relative "
      "to the stiffness: force %.1e, H %.1e, N %.1e, over the cancellation at rest %.1e; energy of "
      "a heap %.1e\n",
      elements, indefinite, fallbacks, worst.force, worst.hessian, worst.negative,
      worst.of_rounding, energy_difference);
  EXPECT_GT(indefinite, elements / 4);
  EXPECT_LT(fallbacks, elements / 100);
  EXPECT_LT(energy_difference, 1e-12);
  EXPECT_LT(worst.force, 1e-13);
  // The rest gradients, and with them F, are known to eps times the cancellation in the rest shape:
  // so is H, relative to the stiffness and the amplification. Measured in that, 6e-15 at most.
  EXPECT_LT(worst.of_rounding, 2e-14);
  // Without it slivers stand out, whose determinant cancels up to 500 times. Against the truth, in
  // 128 bits, neither path is better on them: both are off by up to 1.1e-13 and 9.2e-14.
  EXPECT_LT(worst.hessian, 5e-13);
  EXPECT_LT(worst.negative, 5e-13);
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
