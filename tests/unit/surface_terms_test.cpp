// Pressures that follow the body and springs on facets, on every element: derivatives against
// finite differences, and the swept volume in closed form. Needs petsc_main.cpp.

#include <gtest/gtest.h>

#include <cmath>

#include "mesh/generate.hpp"
#include "mesh/quadratic.hpp"
#include "term/foundation_term.hpp"
#include "term/pressure_term.hpp"

namespace trefoil {
namespace {

struct Element {
  const char *mesh;
  int order;
};

/// Adds the matrices of stencils to a dense one.
class DenseSink final : public StencilSink {
 public:
  explicit DenseSink(std::size_t size) : size_(size), matrix(size * size, 0) {}
  PetscErrorCode add(const Stencil &stencil, const double *H) override {
    for (int r = 0; r < stencil.n; ++r) {
      for (int c = 0; c < stencil.n; ++c) {
        matrix[size_ * static_cast<std::size_t>(stencil.dofs[r]) +
               static_cast<std::size_t>(stencil.dofs[c])] += H[stencil.n * r + c];
      }
    }
    return PETSC_SUCCESS;
  }
  PetscErrorCode add_split(const Stencil &stencil, const double *H, const double *, int) override {
    return add(stencil, H);
  }

 private:
  std::size_t size_;

 public:
  std::vector<double> matrix;
};

class SurfaceTermsTest : public testing::TestWithParam<Element> {
 protected:
  void SetUp() override {
    CellList whole = generate_mesh(GetParam().mesh, 2, 0);
    if (GetParam().order == 2) promote_to_quadratic(whole);
    ASSERT_EQ(distribute_mesh(PETSC_COMM_SELF, whole, "metis", 0, &mesh_), PETSC_SUCCESS);
    ASSERT_EQ(boundary_facets(
                  mesh_, [](const Facet &) { return true; }, &facets_),
              PETSC_SUCCESS);
    // A few facets have a rim.
    some_.assign(facets_.begin(), facets_.begin() + 3);
    u_.assign(mesh_.coordinates.size(), 0);
    for (std::size_t k = 0; k < u_.size(); ++k) {
      if (static_cast<int>(k % 3) < mesh_.dimension()) u_[k] = 0.3 * std::sin(7. * double(k));
    }
  }

  void expect_derivatives(const Term &term) {
    constexpr double h = 1e-4;
    std::vector<double> gradient(u_.size(), 0);
    DenseSink sink(u_.size());
    ASSERT_EQ(term.add_gradient(u_.data(), gradient.data()), PETSC_SUCCESS);
    ASSERT_EQ(term.add_hessian(u_.data(), sink), PETSC_SUCCESS);
    for (std::size_t k = 0; k < u_.size(); ++k) {
      if (static_cast<int>(k % 3) >= mesh_.dimension()) continue;
      EnergySums up, down;
      std::vector<double> force_up(u_.size(), 0), force_down(u_.size(), 0), moved = u_;
      moved[k] += h;
      ASSERT_EQ(term.add_energy(moved.data(), &up), PETSC_SUCCESS);
      ASSERT_EQ(term.add_gradient(moved.data(), force_up.data()), PETSC_SUCCESS);
      moved[k] -= 2 * h;
      ASSERT_EQ(term.add_energy(moved.data(), &down), PETSC_SUCCESS);
      ASSERT_EQ(term.add_gradient(moved.data(), force_down.data()), PETSC_SUCCESS);
      EXPECT_NEAR((up.energy - down.energy) / (2 * h), gradient[k], 1e-9);
      for (std::size_t j = 0; j < u_.size(); ++j) {
        EXPECT_NEAR((force_up[j] - force_down[j]) / (2 * h), sink.matrix[u_.size() * j + k], 1e-9);
      }
    }
  }
  [[nodiscard]] static PressureTerm::PressureAt pressure(double value) {
    return [value](double time, double *p) {
      *p = value * time;
      return PETSC_SUCCESS;
    };
  }

  Mesh mesh_;
  std::vector<Facet> facets_, some_;
  std::vector<double> u_;
};

TEST_P(SurfaceTermsTest, DerivativesOfPressures) {
  PressureTerm term(mesh_, some_, pressure(1.7));
  ASSERT_EQ(term.set_time(1), PETSC_SUCCESS);
  expect_derivatives(term);
}

TEST_P(SurfaceTermsTest, DerivativesOfSprings) {
  for (const auto along : {FoundationTerm::Along::normal, FoundationTerm::Along::all_directions}) {
    FoundationTerm term(mesh_, some_, along,
                        [](const auto &at, double time) { return time * (1 + at[0]); });
    ASSERT_EQ(term.set_time(2), PETSC_SUCCESS);
    expect_derivatives(term);
  }
}

/// Blown up to twice its size, turned and shifted: the potential of a whole surface is the pressure
/// times the change of the volume, and its force is that on the surface.
TEST_P(SurfaceTermsTest, AWholeSurfaceSweepsTheVolumeBetween) {
  PressureTerm term(mesh_, facets_, pressure(3));
  ASSERT_EQ(term.set_time(0.5), PETSC_SUCCESS);
  for (std::size_t v = 0; v < mesh_.owned.size(); ++v) {
    const double *p = &mesh_.coordinates[3 * v];
    const double x[3] = {-2 * p[1] + 5, 2 * p[0] - 3, mesh_.dimension() == 3 ? 2 * p[2] + 1 : 0};
    for (std::size_t i = 0; i < 3; ++i) u_[3 * v + i] = x[i] - p[i];
  }
  EnergySums sums;
  std::vector<double> gradient(u_.size(), 0);
  ASSERT_EQ(term.add_energy(u_.data(), &sums), PETSC_SUCCESS);
  EXPECT_NEAR(sums.energy, 1.5 * (std::pow(2, mesh_.dimension()) - 1), 1e-12);
  ASSERT_EQ(term.add_gradient(u_.data(), gradient.data()), PETSC_SUCCESS);
  term.add_surface_force(u_.data(), gradient.data());
  for (const double rest : gradient) EXPECT_NEAR(rest, 0, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Elements, SurfaceTermsTest,
                         testing::Values(Element{"square", 1}, Element{"square", 2},
                                         Element{"box", 1}, Element{"box", 2}));

}  // namespace
}  // namespace trefoil
