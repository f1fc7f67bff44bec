// Quadratic elements whose volumetric part of psi is taken at their mean of J: the plain element
// against finite differences and closed forms, the batched kernels against the plain element.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "assembly/block_sums.hpp"
#include "element/element_energy.hpp"
#include "material_cases.hpp"
#include "simd/instruction_set.hpp"
#include "trefoil/material_registry.hpp"

namespace trefoil {
namespace {

constexpr int edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
constexpr int count = 203;  // not a multiple of eight

/// Unconnected quadratic elements; every other one is bent.
struct Heap {
  const ReferenceElement &reference;
  std::vector<PetscInt> cells;
  std::vector<double> coordinates, u;
  std::mt19937 random{7};

  /// @param pull size of the displacements, for the elements in turn
  Heap(int dimension, const std::vector<double> &pull)
      : reference(reference_element(dimension, dimension == 2 ? 6 : 10)) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int e = 0; e < count; ++e) {
      double position[30] = {};
      do {
        for (int k = 0; k < 3 * reference.nodes; ++k) {
          const int i = k % 3, edge = k / 3 - dimension - 1;
          if (i >= dimension) continue;
          position[k] =
              edge < 0
                  ? uniform(random)
                  : 0.5 * (position[3 * edges[edge][0] + i] + position[3 * edges[edge][1] + i]) +
                        (e % 2 ? 0.02 * uniform(random) : 0);
        }
      } while (IsoparametricElement(reference, position).least_jacobian() < 0.1);
      const double size = pull[static_cast<std::size_t>(e) % pull.size()];
      for (int k = 0; k < 3 * reference.nodes; ++k) {
        if (k % 3 == 0) cells.push_back(reference.nodes * e + k / 3);
        coordinates.push_back(position[k]);
        u.push_back(k % 3 < dimension ? size * uniform(random) : 0);
      }
    }
  }
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(3 * reference.nodes); }
  [[nodiscard]] IsoparametricElement element(int e) const {
    return {reference, &coordinates[size() * static_cast<std::size_t>(e)]};
  }
  [[nodiscard]] const double *displacements(int e) const {
    return &u[size() * static_cast<std::size_t>(e)];
  }
  /// Takes all but a share of an element's extent along the last axis.
  void flatten(int e, double share) {
    const auto first = size() * static_cast<std::size_t>(e), last = first + size();
    const auto axis = static_cast<std::size_t>(reference.dimension - 1);
    for (std::size_t v = first + axis; v < last; v += 3) u[v] += (share - 1) * coordinates[v];
  }
  /// Moves all elements by the same affine map, x -> (I + G) x.
  void move(const Matrix3<double> &G) {
    for (std::size_t v = 0; v < u.size(); v += 3) {
      for (std::size_t i = 0; i < 3; ++i) {
        u[v + i] = 0;
        for (std::size_t j = 0; j < 3; ++j) {
          u[v + i] += G(static_cast<int>(i), static_cast<int>(j)) * coordinates[v + j];
        }
      }
    }
  }
};

struct State {
  double energy;
  std::vector<double> force, hessian;
};

State state_of(const IsoparametricElement &element, const MaterialModel &material,
               ElementPressure pressure, const double *u) {
  const auto nodes = static_cast<std::size_t>(element.reference().nodes);
  const auto rows = nodes * static_cast<std::size_t>(element.reference().dimension);
  const ElementEnergy energy(element, material, pressure, u);
  State state{energy.energy(), std::vector<double>(3 * nodes, 0),
              std::vector<double>(rows * rows, 0)};
  energy.add_force(state.force.data());
  energy.add_hessian(state.hessian.data());
  return state;
}

double largest(const std::vector<double> &numbers) {
  double result = 0;
  for (const double number : numbers) result = std::max(result, std::abs(number));
  return result;
}

/// Force and Hessian by central differences.
void expect_derivatives(const IsoparametricElement &element, const MaterialModel &material,
                        std::vector<double> u) {
  const auto at = [&] { return state_of(element, material, ElementPressure::constant, u.data()); };
  const int dim = element.reference().dimension, rows = dim * element.reference().nodes;
  const State middle = at();
  const double stiffness = largest(middle.hessian), h = 1e-5;
  for (int r = 0; r < rows; ++r) {
    const auto dof = static_cast<std::size_t>(3 * (r / dim) + r % dim);
    const double before = u[dof];
    u[dof] = before + h;
    const State above = at();
    u[dof] = before - h;
    const State below = at();
    u[dof] = before;
    EXPECT_NEAR((above.energy - below.energy) / (2 * h), middle.force[dof], 1e-7 * stiffness);
    for (int c = 0; c < rows; ++c) {
      const auto other = static_cast<std::size_t>(3 * (c / dim) + c % dim);
      EXPECT_NEAR((above.force[other] - below.force[other]) / (2 * h),
                  middle.hessian[static_cast<std::size_t>(rows * r + c)], 1e-6 * stiffness);
    }
  }
}

/// Materials of the registry that split their volume off, nearly incompressible.
std::vector<std::string> splitting_materials() {
  std::vector<std::string> names;
  for (const std::string &name : material_names()) {
    if (make_material(name, {{1, 0.49}})->splits_volume()) names.push_back(name);
  }
  return names;
}

using Case = std::tuple<int, std::string>;

class ElementPressureTest : public testing::TestWithParam<Case> {
 protected:
  const int dim_ = std::get<0>(GetParam());
  const std::unique_ptr<MaterialModel> material_ =
      make_material(std::get<1>(GetParam()), {{1, 0.49}});
};

/// Over elements that are nearly undeformed, bent, far deformed, inverted, and nearly flat.
TEST_P(ElementPressureTest, ForceAndHessianAreDerivatives) {
  Heap heap(dim_, {1e-6, 0.03, 0.1, 0.5, 0.002});
  for (int e = 4; e < count; e += 5) heap.flatten(e, 1e-3);
  // Energies that end at J = 0, or have a kink, are not tried there.
  const std::string &name = std::get<1>(GetParam());
  const double least = name == "stable_neo_hookean" || name == "mooney_rivlin" ? -1e9 : 0.5;
  int tried = 0;
  bool any_inverted = false;
  for (int e = 0; e < 30; ++e) {
    const std::vector<double> u(heap.displacements(e), heap.displacements(e) + heap.size());
    const double jacobian =
        ElementEnergy(heap.element(e), *material_, ElementPressure::constant, u.data())
            .least_jacobian();
    if (jacobian < least) continue;
    ++tried;
    any_inverted = any_inverted || jacobian < 0;
    expect_derivatives(heap.element(e), *material_, u);
  }
  EXPECT_GT(tried, 5);
  EXPECT_EQ(any_inverted, least < 0);
}

/// Where J is the same at all points, so is its mean: energies and forces are those of pointwise J.
TEST_P(ElementPressureTest, HomogeneousDeformationsAreTheSame) {
  Heap heap(dim_, {0});
  Matrix3<double> G;
  const double entries[9] = {0.3, 0.2, 0.1, -0.1, -0.1, 0.15, 0.05, 0.1, 0.1};
  for (int i = 0; i < dim_; ++i) {
    for (int j = 0; j < dim_; ++j) G(i, j) = entries[3 * i + j];
  }
  heap.move(G);
  for (int e = 0; e < count; ++e) {
    const IsoparametricElement element = heap.element(e);
    const State one =
        state_of(element, *material_, ElementPressure::pointwise, heap.displacements(e));
    const State mean =
        state_of(element, *material_, ElementPressure::constant, heap.displacements(e));
    EXPECT_NEAR(mean.energy, one.energy, 1e-12 * std::abs(one.energy));
    for (std::size_t k = 0; k < one.force.size(); ++k) {
      EXPECT_NEAR(mean.force[k], one.force[k], 1e-12 * largest(one.hessian));
    }
  }
}

/// At rest the two Hessians differ by the variation of div u within the element.
TEST_P(ElementPressureTest, IsSofterAtRestAndNoLess) {
  const Heap heap(dim_, {0});
  for (int e = 0; e < 20; ++e) {
    const IsoparametricElement element = heap.element(e);
    std::vector<double> u(heap.size(), 0);
    const State one = state_of(element, *material_, ElementPressure::pointwise, u.data());
    const State mean = state_of(element, *material_, ElementPressure::constant, u.data());
    const auto rows = static_cast<std::size_t>(dim_ * heap.reference.nodes);
    double trace = 0, trace_of_mean = 0;
    for (std::size_t r = 0; r < rows; ++r) {
      trace += one.hessian[r * (rows + 1)];
      trace_of_mean += mean.hessian[r * (rows + 1)];
    }
    EXPECT_GT(trace_of_mean, 0);
    EXPECT_LT(trace_of_mean, 0.8 * trace);
  }
}

TEST_P(ElementPressureTest, TurningTheElementTurnsItsForces) {
  const Heap heap(dim_, {0.05});
  const double c = std::cos(0.7), s = std::sin(0.7);
  const auto turned = [&](const double *v) {
    return std::array<double, 3>{c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]};
  };
  for (int e = 0; e < 20; ++e) {
    const IsoparametricElement element = heap.element(e);
    const double *x = &heap.coordinates[heap.size() * static_cast<std::size_t>(e)];
    std::vector<double> u(heap.displacements(e), heap.displacements(e) + heap.size()), moved(u);
    for (std::size_t v = 0; v < u.size(); v += 3) {
      const double position[3] = {x[v] + u[v], x[v + 1] + u[v + 1], x[v + 2] + u[v + 2]};
      for (std::size_t i = 0; i < 3; ++i) moved[v + i] = turned(position)[i] - x[v + i];
    }
    const State before = state_of(element, *material_, ElementPressure::constant, u.data());
    const State after = state_of(element, *material_, ElementPressure::constant, moved.data());
    if (!std::isfinite(before.energy)) continue;
    EXPECT_NEAR(after.energy, before.energy, 1e-11 * largest(before.hessian));
    for (std::size_t v = 0; v < u.size(); v += 3) {
      const auto force = turned(&before.force[v]);
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(after.force[v + i], force[i], 1e-11 * largest(before.hessian));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, ElementPressureTest,
                         testing::Combine(testing::Values(2, 3),
                                          testing::ValuesIn(splitting_materials())),
                         [](const auto &each) {
                           return (std::get<0>(each.param) == 2 ? "tri6_" : "tet10_") +
                                  std::get<1>(each.param);
                         });

class PressurePacksTest : public testing::TestWithParam<std::tuple<int, InstructionSet>> {
 protected:
  void SetUp() override {
    if (!processor_has(isa_)) GTEST_SKIP() << "not on this processor";
  }
  const int dim_ = std::get<0>(GetParam());
  const InstructionSet isa_ = std::get<1>(GetParam());
  const Heap heap_{dim_, {1, 0.05, 1e-9}};  // of which the first inverts many
  const ElementPacks packs_ = pack_elements(heap_.reference, heap_.cells, heap_.coordinates);
  const ElementKernels kernels_ = element_kernels(heap_.reference, ElementPressure::constant, isa_);
  const std::unique_ptr<MaterialModel> model_ =
      make_material("stable_neo_hookean", {{1, 0.49}}, isa_);

  /// Reduced matrices, expanded: each element into its own square of numbers.
  [[nodiscard]] std::vector<double> expanded(const std::vector<double> &K) const {
    const int nodes = heap_.reference.nodes, rows = dim_ * nodes;
    BlockSums sums;
    const auto place = [&](PetscInt row, PetscInt column, BlockPlace *result) {
      const PetscInt first =
          rows * rows * (row / nodes) + dim_ * (rows * (row % nodes) + column % nodes);
      *result = {4 * first + 2, rows};
      return static_cast<PetscErrorCode>(0);
    };
    EXPECT_EQ(make_block_sums(packs_, place, &sums), 0);
    std::vector<double> H(static_cast<std::size_t>(rows * rows * count), 0);
    double *arrays[3] = {nullptr, nullptr, H.data()};
    add_blocks_kernel(heap_.reference, isa_)(sums, kernels_.expand, 0, packs_.packs(), K.data(),
                                             nullptr, arrays);
    return H;
  }
};

/// Pressures that are unknowns of their own: at u those of u, linear in the step, and all of the
/// Hessian that they are in.
TEST_P(PressurePacksTest, PressuresOfTheirOwn) {
  constexpr double h = 1e-5;
  const PetscInt packs = packs_.packs();
  const std::vector<double> &u = heap_.u, none(u.size(), 0);
  std::vector<double> d(u.size()), ahead(u), behind(u);
  std::mt19937 random{11};
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (std::size_t k = 0; k < u.size(); ++k) {
    d[k] = static_cast<int>(k % 3) < dim_ ? uniform(random) : 0;
    ahead[k] += h * d[k], behind[k] -= h * d[k];
  }
  const auto pressures = [&](const std::vector<double> &at, const std::vector<double> &step) {
    std::vector<double> p(static_cast<std::size_t>(packs * lanes));
    kernels_.pressures(*model_, packs_, 0, packs, at.data(), step.data(), p.data());
    return p;
  };
  const auto at_u = pressures(u, none), stepped = pressures(u, d), high = pressures(ahead, none),
             low = pressures(behind, none);
  for (std::size_t e = 0; e < static_cast<std::size_t>(count); ++e) {
    const double slope = (high[e] - low[e]) / (2 * h);
    EXPECT_NEAR(stepped[e] - at_u[e], slope, 1e-6 * (1 + std::abs(slope))) << e;
  }
  std::vector<double> K(static_cast<std::size_t>(packs * packs_.entries() * lanes));
  std::vector<double> same(K.size()), other(K.size()), forces(u.size(), 0);
  kernels_.hessians(*model_, packs_, 0, packs, u.data(), K.data());
  kernels_.hessians_at_pressures(*model_, packs_, 0, packs, u.data(), at_u.data(), same.data());
  EXPECT_EQ(K, same);
  kernels_.hessians_at_pressures(*model_, packs_, 0, packs, u.data(), stepped.data(), other.data());
  EXPECT_NE(K, other);
}

TEST_P(PressurePacksTest, EqualThePlainElement) {
  double sums[2] = {0, 0}, sum = 0;
  kernels_.energy(*model_, packs_, 0, packs_.packs(), heap_.u.data(), sums);
  std::vector<double> forces(heap_.u.size(), 0);
  kernels_.forces(*model_, packs_, 0, packs_.packs(), heap_.u.data(), forces.data());
  std::vector<double> K(static_cast<std::size_t>(packs_.packs() * packs_.entries() * lanes));
  kernels_.hessians(*model_, packs_, 0, packs_.packs(), heap_.u.data(), K.data());
  const std::vector<double> H = expanded(K);
  const std::size_t entries = H.size() / count;
  for (int e = 0; e < count; ++e) {
    const State plain =
        state_of(heap_.element(e), *model_, ElementPressure::constant, heap_.displacements(e));
    const auto first = static_cast<std::size_t>(e);
    const double tolerance = 1e-12 * largest(plain.hessian);
    sum += plain.energy;
    for (std::size_t k = 0; k < plain.force.size(); ++k) {
      EXPECT_NEAR(forces[plain.force.size() * first + k], plain.force[k], tolerance) << e;
    }
    for (std::size_t k = 0; k < entries; ++k) {
      EXPECT_NEAR(H[entries * first + k], plain.hessian[k], tolerance) << e;
    }
  }
  EXPECT_NEAR(sums[0] / sum, 1, 1e-12);
}

/// Along a line and in a plane, where the mean of J is known as a polynomial.
TEST_P(PressurePacksTest, ChangesAreDifferencesOfEnergies) {
  std::vector<double> d[2];
  for (std::size_t k = 0; k < heap_.u.size(); ++k) {
    const bool in_space = static_cast<int>(k % 3) < dim_;
    d[0].push_back(in_space ? 0.2 * std::sin(static_cast<double>(k)) : 0);
    d[1].push_back(in_space ? 0.1 * std::cos(static_cast<double>(3 * k)) : 0);
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
    std::vector<double> sums(points.size() * lanes, 1);
    kernels_.energy_changes(*model_, packs_, 0, packs_.packs(), heap_.u.data(), dimensions,
                            directions, points, sums.data());
    for (std::size_t p = 0; p < points.size(); ++p) {
      const double b = dimensions == 2 ? points[p].b() : 0;
      const double expected = energy_at(points[p].a(), b) - energy_at(0, 0);
      const double change = std::accumulate(&sums[lanes * p], &sums[lanes * p] + lanes, 0.0);
      EXPECT_NEAR(change, lanes + expected, 1e-12 * energy_at(0, 0)) << dimensions << ' ' << p;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, PressurePacksTest,
                         testing::Combine(testing::Values(2, 3),
                                          testing::Values(InstructionSet::baseline,
                                                          InstructionSet::avx2,
                                                          InstructionSet::avx512)));

}  // namespace
}  // namespace trefoil
