// H + 2 w N formed at once, and products with H without a matrix, against H and N as matrices.
// Needs petsc_main.cpp.

#include "body.hpp"
#include "mesh/quadratic.hpp"

namespace trefoil::test {
namespace {

struct Case {
  const char *name, *mesh;
  PetscInt resolution;
  int order;
  Holding holding;
  FilterSpace space;

  friend std::ostream &operator<<(std::ostream &stream, const Case &each) {
    return stream << each.name;
  }
};

const std::vector<Case> cases{
    {"tet4", "box", 4, 1, bottom, FilterSpace::element},
    {"tet4_components", "box", 3, 1, bottom_and_sides, FilterSpace::element},
    {"tet4_deformation", "box", 3, 1, nothing, FilterSpace::deformation},
    {"tet10", "box", 2, 2, bottom, FilterSpace::element},
    {"tri3", "square", 6, 1, nothing, FilterSpace::element},
    {"tri6_deformation", "square", 4, 2, nothing, FilterSpace::deformation}};

class HessianProductTest : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    CellList mesh = generate_mesh(GetParam().mesh, GetParam().resolution, 0);
    if (GetParam().order == 2) promote_to_quadratic(mesh);
    ASSERT_EQ(body_.set_up(PETSC_COMM_WORLD, mesh, GetParam().holding, crumpled, GetParam().space),
              PETSC_SUCCESS);
    ASSERT_EQ(body_.vector(crumpled, &x_), PETSC_SUCCESS);
    ASSERT_EQ(body_.discretization.create_matrix(&H_), PETSC_SUCCESS);
    ASSERT_EQ(body_.discretization.create_matrix(&at_once_), PETSC_SUCCESS);
    ASSERT_EQ(body_.functional->hessian(x_, H_, &N_.object, &apart_), PETSC_SUCCESS);
    ASSERT_TRUE(N_.object);
    ASSERT_TRUE(body_.functional->hessian_has_product());
    ASSERT_EQ(body_.functional->filtered_hessian(x_, at_once_, &together_, weight), PETSC_SUCCESS);
  }

  static constexpr double weight = 0.7;
  Body body_;
  OwnedVec x_;
  OwnedMat H_, N_, at_once_;
  TrefoilSplitStatistics apart_{}, together_{};
};

INSTANTIATE_TEST_SUITE_P(Cases, HessianProductTest, testing::ValuesIn(cases),
                         [](const auto &each) { return std::string(each.param.name); });

TEST_P(HessianProductTest, OneMatrixIsTheSumOfTwo) {
  PetscReal size = 0, error = 0, of_negative = 0;
  ASSERT_EQ(MatNorm(N_, NORM_FROBENIUS, &of_negative), PETSC_SUCCESS);
  ASSERT_EQ(MatAXPY(H_, 2 * weight, N_, SAME_NONZERO_PATTERN), PETSC_SUCCESS);
  ASSERT_EQ(MatNorm(H_, NORM_FROBENIUS, &size), PETSC_SUCCESS);
  ASSERT_EQ(MatAXPY(H_, -1, at_once_, SAME_NONZERO_PATTERN), PETSC_SUCCESS);
  ASSERT_EQ(MatNorm(H_, NORM_FROBENIUS, &error), PETSC_SUCCESS);
  EXPECT_GT(of_negative, 1e-3 * size);
  EXPECT_LT(error, 1e-13 * size);
  EXPECT_EQ(apart_.elements, together_.elements);
  EXPECT_EQ(apart_.indefinite, together_.indefinite);
}

TEST_P(HessianProductTest, ProductsAreThoseOfTheUnfilteredMatrix) {
  OwnedVec p, product, expected, elsewhere;
  PetscReal size = 0, error = 0;
  TrefoilSplitStatistics ignored{};
  ASSERT_EQ(body_.vector([](const double *at, int i) { return noise(at, i + 3); }, &p),
            PETSC_SUCCESS);
  for (Vec *each : {&product, &expected, &elsewhere})
    ASSERT_EQ(VecDuplicate(p, each), PETSC_SUCCESS);
  ASSERT_EQ(MatMult(H_, p, expected), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(expected, NORM_2, &size), PETSC_SUCCESS);
  ASSERT_EQ(body_.functional->multiply_by_hessian(p, product), PETSC_SUCCESS);
  ASSERT_EQ(VecAXPY(product, -1, expected), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(product, NORM_2, &error), PETSC_SUCCESS);
  EXPECT_LT(error, 1e-13 * size);

  // An unfiltered Hessian elsewhere changes nothing.
  ASSERT_EQ(VecSet(elsewhere, 0), PETSC_SUCCESS);
  ASSERT_EQ(body_.functional->hessian(elsewhere, H_, nullptr, &ignored), PETSC_SUCCESS);
  ASSERT_EQ(body_.functional->multiply_by_hessian(p, product), PETSC_SUCCESS);
  ASSERT_EQ(VecAXPY(product, -1, expected), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(product, NORM_2, &error), PETSC_SUCCESS);
  EXPECT_LT(error, 1e-13 * size);
}

}  // namespace
}  // namespace trefoil::test
