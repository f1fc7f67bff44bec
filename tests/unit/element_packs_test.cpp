// The batched kernels of triangles and tetrahedra of order 1 and 2 against the plain element, on
// straight, bent, inverted and flat elements, for every instruction set that this machine has; the
// plain element against finite differences and closed forms.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "assembly/block_sums.hpp"
#include "element/element_packs.hpp"
#include "element/isoparametric_element.hpp"
#include "material/stable_neo_hookean.hpp"
#include "simd/instruction_set.hpp"
#include "tet4_support.hpp"

namespace trefoil {
namespace {

struct Kind {
  int dimension, nodes;
};
constexpr Kind kinds[] = {{2, 3}, {2, 6}, {3, 4}, {3, 10}};

constexpr int edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/// Unconnected elements; every other one is bent, and displacements stretch and invert them.
struct Heap {
  static constexpr int count = 1003;  // not a multiple of eight
  const ReferenceElement &reference;
  std::vector<PetscInt> cells;
  std::vector<double> coordinates, u;

  Heap(const Kind &kind, unsigned seed) : reference(reference_element(kind.dimension, kind.nodes)) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int e = 0; e < count; ++e) {
      double position[30] = {};
      do {
        for (int a = 0; a < kind.nodes; ++a)
          for (int i = 0; i < kind.dimension; ++i) {
            const int edge = a - kind.dimension - 1;
            position[3 * a + i] =
                edge < 0
                    ? uniform(random)
                    : 0.5 * (position[3 * edges[edge][0] + i] + position[3 * edges[edge][1] + i]) +
                          (e % 2 ? 0.02 * uniform(random) : 0);
          }
      } while (IsoparametricElement(reference, position).least_jacobian() < 0.05);
      const double pull = e % 3 == 0 ? 2 : e % 3 == 1 ? 0.1 : 1e-9;
      for (int k = 0; k < 3 * kind.nodes; ++k) {
        if (k % 3 == 0) cells.push_back(kind.nodes * e + k / 3);
        coordinates.push_back(position[k]);
        u.push_back(k % 3 < kind.dimension ? pull * uniform(random) : 0);
      }
    }
  }
  [[nodiscard]] IsoparametricElement element(int e) const {
    return {reference, &coordinates[static_cast<std::size_t>(3 * reference.nodes * e)]};
  }
  [[nodiscard]] const double *displacements(int e) const {
    return &u[static_cast<std::size_t>(3 * reference.nodes * e)];
  }
};

const StableNeoHookean material({1.0, 0.4}, StableNeoHookean::Lame::physical);

double energy(const IsoparametricElement &element, const double *u) {
  double sum = 0;
  for (int q = 0; q < element.reference().points; ++q)
    sum += element.weight(q) *
           material.energy_density(Deformation(element.displacement_gradient(q, u)));
  return sum;
}
std::vector<double> force(const IsoparametricElement &element, const double *u) {
  std::vector<double> sum(static_cast<std::size_t>(3 * element.reference().nodes), 0);
  for (int q = 0; q < element.reference().points; ++q)
    element.add_force(q, material.stress(Deformation(element.displacement_gradient(q, u))),
                      sum.data());
  return sum;
}
std::vector<double> hessian(const IsoparametricElement &element, const double *u) {
  const auto rows =
      static_cast<std::size_t>(element.reference().dimension * element.reference().nodes);
  std::vector<double> H(rows * rows, 0);
  for (int q = 0; q < element.reference().points; ++q) {
    Tangent<double> A;
    material.tangent(Deformation(element.displacement_gradient(q, u)), A);
    element.add_hessian(q, A, H.data());
  }
  return H;
}

class ElementTest : public testing::TestWithParam<Kind> {};

TEST_P(ElementTest, ShapeFunctionsInterpolateAndAddUpToOne) {
  const auto [dimension, nodes] = GetParam();
  for (int a = 0; a < nodes; ++a) {
    double position[3] = {}, values[10], gradients[10][3];
    for (int i = 0; i < dimension; ++i) {
      const int edge = a - dimension - 1;
      const auto corner = [&](int c) { return c == i + 1 ? 1.0 : 0.0; };
      position[i] = edge < 0 ? corner(a) : 0.5 * (corner(edges[edge][0]) + corner(edges[edge][1]));
    }
    shape_functions(dimension, nodes, position, values, gradients);
    for (int b = 0; b < nodes; ++b) EXPECT_NEAR(values[b], a == b, 1e-15) << a << ' ' << b;
  }
  const double inside[3] = {0.2, 0.3, dimension == 3 ? 0.1 : 0};
  double values[10], gradients[10][3], sum = 0, slope = 0;
  shape_functions(dimension, nodes, inside, values, gradients);
  for (int a = 0; a < nodes; ++a) sum += values[a], slope += gradients[a][1];
  EXPECT_NEAR(sum, 1, 1e-15);
  EXPECT_NEAR(slope, 0, 1e-15);
}

/// The stiffness of linear elasticity on straight cells is a polynomial of degree 2 (order - 1).
TEST_P(ElementTest, QuadratureIsExactForTheStiffnessOfStraightElements) {
  const auto [dimension, nodes] = GetParam();
  const ReferenceElement &reference = reference_element(dimension, nodes);
  const int degree = nodes == dimension + 1 ? 0 : 2;
  double volume = 0;
  for (int powers = 0; powers < 27; ++powers) {
    const int p[3] = {powers % 3, powers / 3 % 3, powers / 9};
    if (p[0] + p[1] + p[2] > degree || (dimension == 2 && p[2] > 0)) continue;
    // The integral of x^p y^q z^r over the unit simplex is p! q! r! / (p + q + r + dim)!.
    const auto factorial = [](int k) { return std::tgamma(k + 1.0); };
    const double exact = factorial(p[0]) * factorial(p[1]) * factorial(p[2]) /
                         factorial(p[0] + p[1] + p[2] + dimension);
    double sum = 0;
    for (int q = 0; q < reference.points; ++q) {
      double product = reference.volume / reference.points;
      for (int i = 0; i < dimension; ++i) product *= std::pow(reference.position[q][i], p[i]);
      sum += product;
    }
    EXPECT_NEAR(sum, exact, 1e-16) << powers;
    volume += powers == 0 ? sum : 0;
  }
  EXPECT_NEAR(volume, reference.volume, 1e-16);
}

TEST_P(ElementTest, ForceAndHessianAreDerivatives) {
  const Heap heap(GetParam(), 5);
  const int nodes = GetParam().nodes, dim = GetParam().dimension, rows = dim * nodes;
  for (int e : {0, 1, 3, 4}) {
    const IsoparametricElement element = heap.element(e);
    std::vector<double> u(heap.displacements(e), heap.displacements(e) + 3 * nodes);
    const std::vector<double> f = force(element, u.data()), H = hessian(element, u.data());
    double stiffness = 0, largest = 0;
    for (double entry : H) stiffness = std::max(stiffness, std::abs(entry));
    for (double entry : f) largest = std::max(largest, std::abs(entry));
    const double h = 1e-5;
    for (int r = 0; r < rows; ++r) {
      const auto at = static_cast<std::size_t>(3 * (r / dim) + r % dim);
      const double middle = u[at];
      u[at] = middle + h;
      const double above = energy(element, u.data());
      const std::vector<double> f_above = force(element, u.data());
      u[at] = middle - h;
      const double below = energy(element, u.data());
      const std::vector<double> f_below = force(element, u.data());
      u[at] = middle;
      EXPECT_NEAR((above - below) / (2 * h), f[at], 1e-7 * (largest + stiffness));
      for (int c = 0; c < rows; ++c) {
        const auto column = static_cast<std::size_t>(3 * (c / dim) + c % dim);
        EXPECT_NEAR((f_above[column] - f_below[column]) / (2 * h),
                    H[static_cast<std::size_t>(rows * r + c)], 1e-6 * stiffness);
      }
    }
  }
}

TEST(ElementTest, LinearTetrahedronIsTet4) {
  const Heap heap({3, 4}, 9);
  for (int e = 0; e < 50; ++e) {
    double corner[4][3], H[144];
    std::copy_n(&heap.coordinates[static_cast<std::size_t>(12 * e)], 12, &corner[0][0]);
    const Tet4 tet = Tet4::at_rest(corner);
    Tangent<double> A;
    material.tangent(Deformation(tet.displacement_gradient(heap.displacements(e))), A);
    tet.hessian(A, H);
    const std::vector<double> mine = hessian(heap.element(e), heap.displacements(e));
    double size = 0;
    for (double entry : H) size = std::max(size, std::abs(entry));
    for (std::size_t k = 0; k < 144; ++k) EXPECT_NEAR(mine[k], H[k], 1e-13 * size);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, ElementTest, testing::ValuesIn(kinds), [](const auto &each) {
  return std::string(reference_element(each.param.dimension, each.param.nodes).name);
});

using Case = std::tuple<Kind, InstructionSet>;

class ElementPacksTest : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    if (!processor_has(std::get<1>(GetParam()))) GTEST_SKIP() << "not on this processor";
  }
  const Kind kind_ = std::get<0>(GetParam());
  const Heap heap_{kind_, 3};
  const ElementPacks packs_ = pack_elements(heap_.reference, heap_.cells, heap_.coordinates);
  const ElementKernels kernels_ =
      element_kernels(*packs_.reference, ElementPressure::pointwise, std::get<1>(GetParam()));
  const std::unique_ptr<MaterialModel> model_ =
      make_material_model(material, std::get<1>(GetParam()));

  /// Reduced matrices, expanded: each element into its own square of numbers.
  [[nodiscard]] std::vector<double> expanded(const std::vector<double> &K,
                                             const int *chosen = nullptr) const {
    const int rows = kind_.dimension * kind_.nodes;
    const int nodes = kind_.nodes;
    BlockSums sums;
    const auto place = [&](PetscInt row, PetscInt column, BlockPlace *result) {
      const PetscInt first =
          rows * rows * (row / nodes) + kind_.dimension * (rows * (row % nodes) + column % nodes);
      *result = {4 * first + 2, rows};
      return static_cast<PetscErrorCode>(0);
    };
    EXPECT_EQ(make_block_sums(packs_, place, &sums), 0);
    std::vector<double> H(static_cast<std::size_t>(rows * rows * Heap::count), 0);
    double *arrays[3] = {nullptr, nullptr, H.data()};
    add_blocks_kernel(heap_.reference, std::get<1>(GetParam()))(
        sums, kernels_.expand, 0, packs_.packs(), K.data(), chosen, arrays);
    return H;
  }
};

TEST_P(ElementPacksTest, EqualThePlainElement) {
  double sums[2] = {0, 0}, sum = 0;
  kernels_.energy(*model_, packs_, 0, packs_.packs(), heap_.u.data(), sums);
  std::vector<double> forces(heap_.u.size(), 0);
  kernels_.forces(*model_, packs_, 0, packs_.packs(), heap_.u.data(), forces.data());
  std::vector<double> K(static_cast<std::size_t>(packs_.packs() * packs_.entries() * lanes));
  kernels_.hessians(*model_, packs_, 0, packs_.packs(), heap_.u.data(), K.data());
  const std::vector<double> H = expanded(K);
  const auto size = H.size() / Heap::count;
  for (int e = 0; e < Heap::count; ++e) {
    const IsoparametricElement element = heap_.element(e);
    const double *u = heap_.displacements(e);
    sum += energy(element, u);
    const std::vector<double> f = force(element, u), plain = hessian(element, u);
    double stiffness = 0, steepest = 1;
    for (double entry : plain) stiffness = std::max(stiffness, std::abs(entry));
    for (int a = 0; a < kind_.nodes; ++a)
      for (int i = 0; i < 3; ++i)
        steepest = std::max(steepest, std::abs(element.gradient(0, a)[i]));
    // F = I + sum u_a g_a' loses digits where its terms are larger than itself: so do both paths.
    const double tolerance = 1e-14 * stiffness * steepest;
    for (std::size_t k = 0; k < f.size(); ++k)
      EXPECT_NEAR(forces[f.size() * static_cast<std::size_t>(e) + k], f[k], 2 * tolerance) << e;
    for (std::size_t k = 0; k < size; ++k)
      EXPECT_NEAR(H[size * static_cast<std::size_t>(e) + k], plain[k], 2 * tolerance) << e;
  }
  EXPECT_NEAR(sums[0] / sum, 1, 1e-12);
  EXPECT_NEAR(sums[1] / sum, 1, 1e-12) << "psi is nowhere negative";
}

/// Energies at points of a line and of a plane, in one pass.
TEST_P(ElementPacksTest, ChangesAreDifferencesOfEnergies) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<double> d[2];
  for (std::vector<double> &each : d) {
    for (std::size_t k = 0; k < heap_.u.size(); ++k) {
      each.push_back(static_cast<int>(k % 3) < kind_.dimension ? 0.2 * uniform(random) : 0);
    }
  }
  const double *directions[2] = {d[0].data(), d[1].data()};
  const std::vector<PlanePoint> points{{0.5, -1}, {0.25, 0.75}, {0, 0}};
  const auto energy_at = [&](double a, double b) {
    std::vector<double> moved = heap_.u;
    for (std::size_t k = 0; k < moved.size(); ++k) moved[k] += a * d[0][k] + b * d[1][k];
    double sums[2] = {0, 0};
    kernels_.energy(*model_, packs_, 0, packs_.packs(), moved.data(), sums);
    return sums[0];
  };
  for (const int dimensions : {1, 2}) {
    std::vector<double> sums(3 * lanes, 1);
    kernels_.energy_changes(*model_, packs_, 0, packs_.packs(), heap_.u.data(), dimensions,
                            directions, points, sums.data());
    for (int p = 0; p < 3; ++p) {
      const PlanePoint &point = points[static_cast<std::size_t>(p)];
      const double b = dimensions == 2 ? point.b() : 0;
      const double expected = energy_at(point.a(), b) - energy_at(0, 0);
      const double change = std::accumulate(&sums[lanes * p], &sums[lanes * p] + lanes, 0.0);
      EXPECT_NEAR(change, lanes + expected, 1e-12 * energy_at(0, 0)) << dimensions << ' ' << p;
    }
  }
}

TEST_P(ElementPacksTest, ReducedMatricesHaveTheEigenvaluesOfTheElement) {
  // The trace and the Frobenius norm show what an orthonormal basis keeps.
  std::vector<double> K(static_cast<std::size_t>(packs_.packs() * packs_.entries() * lanes));
  kernels_.hessians(*model_, packs_, 0, packs_.packs(), heap_.u.data(), K.data());
  for (int e = 0; e < 40; ++e) {
    const std::vector<double> plain = hessian(heap_.element(e), heap_.displacements(e));
    const auto rows = static_cast<std::size_t>(kind_.dimension * kind_.nodes);
    double trace = 0, squares = 0, reduced_trace = 0, reduced_squares = 0;
    for (std::size_t k = 0; k < rows * rows; ++k) {
      squares += plain[k] * plain[k];
      trace += k % (rows + 1) == 0 ? plain[k] : 0;
    }
    int entry = 0;
    for (int r = 0; r < packs_.rows(); ++r)
      for (int c = 0; c <= r; ++c, ++entry) {
        const double value =
            K[static_cast<std::size_t>((e / 8 * packs_.entries() + entry) * 8 + e % 8)];
        reduced_trace += r == c ? value : 0;
        reduced_squares += (r == c ? 1 : 2) * value * value;
      }
    EXPECT_NEAR(reduced_trace, trace, 1e-12 * std::sqrt(squares));
    EXPECT_NEAR(reduced_squares / squares, 1, 1e-12);
  }
}

TEST_P(ElementPacksTest, AddsOnlyWhatIsChosen) {
  std::vector<double> K(static_cast<std::size_t>(packs_.packs() * packs_.entries() * lanes), 0);
  for (std::size_t k = 0; k < K.size(); ++k) K[k] = 1 + static_cast<double>(k % 7);
  std::vector<int> chosen(static_cast<std::size_t>(packs_.packs() * lanes), 0);
  chosen[3] = 1;
  chosen[9] = -1;  // not finite
  chosen[Heap::count - 1] = 2;
  chosen.back() = 1;  // a copy that fills the last pack
  const std::vector<double> all = expanded(K), some = expanded(K, chosen.data());
  const auto size = all.size() / Heap::count;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const std::size_t e = k / size;
    EXPECT_EQ(some[k], e == 3 || e == Heap::count - 1 ? all[k] : 0) << e;
  }
}

std::string name_of(const testing::TestParamInfo<Case> &each) {
  const char *sets[] = {"baseline", "avx2", "avx512"};
  return std::string(
             reference_element(std::get<0>(each.param).dimension, std::get<0>(each.param).nodes)
                 .name) +
         "_" + sets[static_cast<int>(std::get<1>(each.param))];
}

INSTANTIATE_TEST_SUITE_P(Kinds, ElementPacksTest,
                         testing::Combine(testing::ValuesIn(kinds),
                                          testing::Values(InstructionSet::baseline,
                                                          InstructionSet::avx2,
                                                          InstructionSet::avx512)),
                         name_of);

}  // namespace
}  // namespace trefoil
