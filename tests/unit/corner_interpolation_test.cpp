// Linear displacements under quadratic ones: what they reproduce, and how they are numbered. Needs
// petsc_main.cpp.

#include "assembly/corner_interpolation.hpp"

#include "body.hpp"
#include "mesh/quadratic.hpp"

namespace trefoil::test {
namespace {

struct Quadratic {
  Body body;
  CornerInterpolation interpolation;

  PetscErrorCode make(const char *mesh, const Holding &holding) {
    PetscFunctionBeginUser;
    CellList cells = generate_mesh(mesh, 3, 0);
    promote_to_quadratic(cells);
    PetscCall(body.set_up(PETSC_COMM_WORLD, cells, holding, at_rest));
    PetscCall(interpolation.set_up(body.discretization));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  /// Largest difference of a field and of what is made of it at the corners.
  [[nodiscard]] double error(const Field &field) const {
    OwnedVec exact, corners, made;
    PetscReal size = -1;
    EXPECT_EQ(body.vector(field, &exact), PETSC_SUCCESS);
    EXPECT_EQ(MatCreateVecs(interpolation.matrix(), &corners, &made), PETSC_SUCCESS);
    EXPECT_EQ(VecISCopy(exact, interpolation.corners(), SCATTER_REVERSE, corners), PETSC_SUCCESS);
    EXPECT_EQ(MatMult(interpolation.matrix(), corners, made), PETSC_SUCCESS);
    EXPECT_EQ(VecAXPY(made, -1, exact), PETSC_SUCCESS);
    EXPECT_EQ(VecNorm(made, NORM_INFINITY, &size), PETSC_SUCCESS);
    return size;
  }
};

double affine(const double *p, int i) {
  return 0.1 * (i + 1) + 0.3 * p[i] - 0.2 * p[(i + 1) % 3] + 0.7 * p[(i + 2) % 3];
}
double leaning(const double *p, int i) {
  return i == 0 ? 0 : (i + 1) * p[2];
}

TEST(CornerInterpolationTest, ReproducesLinearFields) {
  Quadratic free;
  ASSERT_EQ(free.make("box", nothing), PETSC_SUCCESS);
  EXPECT_LT(free.error(affine), 1e-14);
  EXPECT_GT(free.error([](const double *p, int) { return p[0] * p[0]; }), 1e-3);
}

TEST(CornerInterpolationTest, LeavesHeldComponentsAlone) {
  Quadratic held;
  ASSERT_EQ(held.make("box", bottom_and_sides), PETSC_SUCCESS);
  EXPECT_LT(held.error(leaning), 1e-14);
}

TEST(CornerInterpolationTest, HasAnUnknownForEachOfTheCorners) {
  for (const Holding &holding : {Holding(nothing), Holding(bottom), Holding(bottom_and_sides)}) {
    Quadratic mesh;
    ASSERT_EQ(mesh.make("box", holding), PETSC_SUCCESS);
    PetscInt rows = 0, columns = 0, row_block = 0, column_block = 0, corners = 0;
    ASSERT_EQ(MatGetSize(mesh.interpolation.matrix(), &rows, &columns), PETSC_SUCCESS);
    ASSERT_EQ(MatGetBlockSizes(mesh.interpolation.matrix(), &row_block, &column_block),
              PETSC_SUCCESS);
    EXPECT_EQ(rows, mesh.body.discretization.total_dofs());
    EXPECT_EQ(row_block, mesh.body.discretization.block_size());
    EXPECT_EQ(column_block, row_block);
    for (PetscInt z = 0; z <= 3; ++z)
      for (PetscInt y = 0; y <= 3; ++y)
        for (PetscInt x = 0; x <= 3; ++x) {
          const double p[3] = {x / 3.0, y / 3.0, z / 3.0};
          for (int i = 0; i < 3; ++i) corners += !holding(p, i);
        }
    EXPECT_EQ(columns, corners);
  }
}

TEST(CornerInterpolationTest, WorksInThePlane) {
  Quadratic square;
  ASSERT_EQ(square.make("square", nothing), PETSC_SUCCESS);
  EXPECT_LT(square.error([](const double *p, int i) { return i == 2 ? 0 : affine(p, i); }), 1e-14);
}

TEST(CornerInterpolationTest, TakesModesToTheCorners) {
  Quadratic mesh;
  OwnedMat fine, coarse;
  MatNullSpace space = nullptr;
  const Vec *modes = nullptr;
  PetscInt count = 0;
  ASSERT_EQ(mesh.make("box", nothing), PETSC_SUCCESS);
  ASSERT_EQ(mesh.body.discretization.create_matrix(&fine), PETSC_SUCCESS);
  ASSERT_EQ(MatPtAP(fine, mesh.interpolation.matrix(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &coarse),
            PETSC_SUCCESS);
  ASSERT_EQ(mesh.interpolation.attach_modes(fine, coarse), PETSC_SUCCESS);
  ASSERT_EQ(MatGetNearNullSpace(coarse, &space), PETSC_SUCCESS);
  ASSERT_EQ(MatNullSpaceGetVecs(space, nullptr, &count, &modes), PETSC_SUCCESS);
  ASSERT_EQ(count, 6);
  // Each of the fine modes is a sum of the coarse ones, interpolated.
  OwnedVec rotation, corners;
  ASSERT_EQ(
      mesh.body.vector([](const double *p, int i) { return i == 0   ? -p[1]
                                                           : i == 1 ? p[0]
                                                                    : 0; },
                       &rotation),
      PETSC_SUCCESS);
  ASSERT_EQ(MatCreateVecs(coarse, &corners, nullptr), PETSC_SUCCESS);
  ASSERT_EQ(VecISCopy(rotation, mesh.interpolation.corners(), SCATTER_REVERSE, corners),
            PETSC_SUCCESS);
  PetscReal before = 0, after = 0;
  ASSERT_EQ(VecNorm(corners, NORM_2, &before), PETSC_SUCCESS);
  for (PetscInt m = 0; m < count; ++m) {
    PetscScalar share = 0;
    ASSERT_EQ(VecDot(corners, modes[m], &share), PETSC_SUCCESS);
    ASSERT_EQ(VecAXPY(corners, -share, modes[m]), PETSC_SUCCESS);
  }
  ASSERT_EQ(VecNorm(corners, NORM_2, &after), PETSC_SUCCESS);
  EXPECT_LT(after, 1e-12 * before);
}

}  // namespace
}  // namespace trefoil::test
