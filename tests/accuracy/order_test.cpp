// Manufactured solutions: observed orders of convergence on the unit square and cube. Needs
// petsc_main.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "body_problem.hpp"
#include "manufactured.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/generate.hpp"
#include "mesh/locality.hpp"
#include "mesh/quadratic.hpp"

namespace trefoil::accuracy {
namespace {

struct Case {
  const char *name, *mesh;
  int order;
  PetscInt coarse, fine;
};
const Case cases[] = {{"tri3", "square", 1, 16, 32},
                      {"tri6", "square", 2, 8, 16},
                      {"tet4", "box", 1, 8, 16},
                      {"tet10", "box", 2, 4, 8}};

class AccuracyOrderTest : public testing::TestWithParam<Case> {
 protected:
  static Problem::Errors errors_at(PetscInt resolution) {
    const StableNeoHookean material({1, 0.3}, StableNeoHookean::Lame::physical);
    CellList mesh = generate_mesh(GetParam().mesh, resolution, 0);
    Manufactured exact{mesh.dimension(), 0.08, 0.05};
    if (GetParam().order == 2) promote_to_quadratic(mesh);
    order_along_curve(mesh);
    const auto on_boundary = [&](const double *p) {
      for (int i = 0; i < mesh.dimension(); ++i)
        if (p[i] < 1e-9 || p[i] > 1 - 1e-9) return true;
      return false;
    };
    Problem problem;
    std::vector<double> u;
    EXPECT_EQ(problem.set_up(mesh, make_material_model(material),
                             [&](const double *p, int i) -> std::optional<double> {
                               if (!on_boundary(p)) return {};
                               return exact.displacement(p)[static_cast<std::size_t>(i)];
                             }),
              PETSC_SUCCESS);
    const auto model = make_material_model(material);
    problem.add_body_force([&](const double *p) { return exact.body_force(*model, p); });
    EXPECT_EQ(problem.solve(1e-15), PETSC_SUCCESS);
    EXPECT_EQ(problem.displacements(&u), PETSC_SUCCESS);
    return problem.errors(
        u, [&](const double *p) { return exact.displacement(p); },
        [&](const double *p) { return exact.gradient(p); });
  }
};

TEST_P(AccuracyOrderTest, ErrorsShrinkAsTheoryHasIt) {
  const Problem::Errors coarse = errors_at(GetParam().coarse), fine = errors_at(GetParam().fine);
  const double ratio =
      static_cast<double>(GetParam().fine) / static_cast<double>(GetParam().coarse);
  const double L2 = std::log(coarse.L2 / fine.L2) / std::log(ratio);
  const double H1 = std::log(coarse.H1 / fine.H1) / std::log(ratio);
  PetscPrintf(PETSC_COMM_WORLD, "%-6s L2 %.2e -> %.2e order %.2f, H1 %.2e -> %.2e order %.2f\n",
              GetParam().name, coarse.L2, fine.L2, L2, coarse.H1, fine.H1, H1);
  EXPECT_NEAR(L2, GetParam().order + 1, 0.2);
  EXPECT_NEAR(H1, GetParam().order, 0.15);
  EXPECT_LT(fine.H1, GetParam().order == 1 ? 0.2 : 0.03);  // and converge to the right thing
}

INSTANTIATE_TEST_SUITE_P(Elements, AccuracyOrderTest, testing::ValuesIn(cases),
                         [](const auto &each) { return std::string(each.param.name); });

}  // namespace
}  // namespace trefoil::accuracy
