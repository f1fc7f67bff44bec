// Energy, gradient, H and N of a mesh: derivatives of each other, and the same on every number of
// ranks. Needs petsc_main.cpp.

#include "body.hpp"
#include "matrix3_support.hpp"

namespace trefoil::test {
namespace {

INSTANTIATE_TEST_SUITE_P(Scenes, SceneTest, testing::ValuesIn(scenes),
                         [](const auto &each) { return std::string(each.param.name); });

double energy_of(const Body &body, Vec x) {
  EnergySums sums;
  EXPECT_EQ(body.functional->energy(x, &sums), PETSC_SUCCESS);
  return sums.energy;
}

TEST_P(SceneTest, GradientAndHessianAreDerivatives) {
  ASSERT_EQ(body_.set_up(PETSC_COMM_WORLD, mesh(), GetParam().holding), PETSC_SUCCESS);
  OwnedVec x, direction, g, moved, product;
  OwnedMat H;
  ASSERT_EQ(body_.vector(crumpled, &x), PETSC_SUCCESS);
  ASSERT_EQ(body_.vector([](const double *p, int i) { return noise(p, i + 3); }, &direction),
            PETSC_SUCCESS);
  for (Vec *each : {&g, &moved, &product}) ASSERT_EQ(VecDuplicate(x, each), PETSC_SUCCESS);
  PetscInt64 inverted = 0;
  ASSERT_EQ(body_.functional->count_inverted(x, &inverted), PETSC_SUCCESS);
  EXPECT_GT(inverted, 0);

  PetscScalar slope = 0;
  PetscReal gradient_norm = 0, direction_norm = 0;
  ASSERT_EQ(body_.functional->gradient(x, g), PETSC_SUCCESS);
  ASSERT_EQ(VecDot(g, direction, &slope), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(g, NORM_2, &gradient_norm), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(direction, NORM_2, &direction_norm), PETSC_SUCCESS);
  const double h = 1e-3;
  const double difference = derivative(h, [&](double s) {
    EXPECT_EQ(VecWAXPY(moved, s, direction, x), PETSC_SUCCESS);
    return energy_of(body_, moved);
  });
  EXPECT_NEAR(difference, slope, 1e-8 * gradient_norm * direction_norm);

  TrefoilSplitStatistics statistics{};
  ASSERT_EQ(body_.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(body_.functional->hessian(x, H, nullptr, &statistics), PETSC_SUCCESS);
  ASSERT_EQ(MatMult(H, direction, product), PETSC_SUCCESS);
  PetscReal size = 0, error = 0;
  ASSERT_EQ(VecNorm(product, NORM_2, &size), PETSC_SUCCESS);
  // The five-point formula of matrix3_support.hpp, of vectors.
  const std::pair<double, double> points[] = {{h, 8}, {-h, -8}, {2 * h, -1}, {-2 * h, 1}};
  for (const auto &[s, factor] : points) {
    ASSERT_EQ(VecWAXPY(moved, s, direction, x), PETSC_SUCCESS);
    ASSERT_EQ(body_.functional->gradient(moved, g), PETSC_SUCCESS);
    ASSERT_EQ(VecAXPY(product, -factor / (12 * h), g), PETSC_SUCCESS);
  }
  ASSERT_EQ(VecNorm(product, NORM_2, &error), PETSC_SUCCESS);
  EXPECT_LT(error, 1e-8 * size);
}

/// What must not depend on the number of ranks.
struct Invariants {
  double energy = 0, scale = 0, rest = 0, gradient = 0, hessian = 0, negative = 0;
  PetscInt64 indefinite = 0, inverted = 0;
};

PetscErrorCode invariants(MPI_Comm comm, const CellList &mesh, const Holding &holding,
                          Invariants *result) {
  Body body;
  OwnedVec x, g;
  OwnedMat H, N;
  EnergySums sums;
  TrefoilSplitStatistics statistics{};
  PetscFunctionBeginUser;
  PetscCall(body.set_up(comm, mesh, holding));
  PetscCall(body.vector(crumpled, &x));
  PetscCall(VecDuplicate(x, &g));
  PetscCall(body.functional->energy(x, &sums));
  PetscCall(body.functional->energy_at_rest(&result->rest));
  PetscCall(body.functional->gradient(x, g));
  PetscCall(body.discretization.create_matrix(&H));
  PetscCall(body.functional->hessian(x, H, &N, &statistics));
  PetscCall(body.functional->count_inverted(x, &result->inverted));
  result->energy = sums.energy;
  result->scale = sums.scale;
  PetscCall(VecNorm(g, NORM_2, &result->gradient));
  PetscCall(MatNorm(H, NORM_FROBENIUS, &result->hessian));
  PetscCall(MatNorm(N, NORM_FROBENIUS, &result->negative));
  PetscCallMPI(
      MPI_Allreduce(&statistics.indefinite, &result->indefinite, 1, MPIU_INT64, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST_P(SceneTest, ParallelIsSerial) {
  Invariants parallel, serial;
  ASSERT_EQ(invariants(PETSC_COMM_WORLD, mesh(), GetParam().holding, &parallel), PETSC_SUCCESS);
  ASSERT_EQ(invariants(PETSC_COMM_SELF, mesh(), GetParam().holding, &serial), PETSC_SUCCESS);
  EXPECT_NEAR(parallel.energy / serial.energy, 1, 1e-12);
  EXPECT_NEAR(parallel.scale / serial.scale, 1, 1e-12);
  EXPECT_NEAR(parallel.rest / serial.rest, 1, 1e-12);
  EXPECT_NEAR(parallel.gradient / serial.gradient, 1, 1e-12);
  EXPECT_NEAR(parallel.hessian / serial.hessian, 1, 1e-12);
  EXPECT_NEAR(parallel.negative / serial.negative, 1, 1e-12);
  EXPECT_EQ(parallel.indefinite, serial.indefinite);
  EXPECT_EQ(parallel.inverted, serial.inverted);
}

TEST(AssemblyTest, NegativePartIsNotMadeAtRest) {
  Body body;
  OwnedVec rest;
  OwnedMat H, N;
  TrefoilSplitStatistics statistics{};
  ASSERT_EQ(body.set_up(PETSC_COMM_WORLD, generate_mesh("box", 3, 0), bottom, at_rest),
            PETSC_SUCCESS);
  ASSERT_EQ(body.vector(at_rest, &rest), PETSC_SUCCESS);
  ASSERT_EQ(body.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(body.functional->hessian(rest, H, &N, &statistics), PETSC_SUCCESS);
  EXPECT_EQ(N.object, nullptr);
  EXPECT_EQ(statistics.indefinite, 0);
  EnergySums sums;
  double energy_at_rest = 0;
  ASSERT_EQ(body.functional->energy(rest, &sums), PETSC_SUCCESS);
  ASSERT_EQ(body.functional->energy_at_rest(&energy_at_rest), PETSC_SUCCESS);
  EXPECT_EQ(sums.energy, 0);
  EXPECT_EQ(sums.scale, 0);
  // psi(I) = mu^2 / (2 lambda), of a volume of one.
  const StableNeoHookean material = soft_material();
  EXPECT_NEAR(energy_at_rest, material.mu() * material.mu() / (2 * material.lambda()), 1e-13);
}

TEST(AssemblyTest, CellsAreDescribedOneByOne) {
  Body body;
  OwnedVec x;
  EnergyFunctional::CellReport report;
  ASSERT_EQ(body.set_up(PETSC_COMM_WORLD, generate_mesh("box", 3, 0), bottom), PETSC_SUCCESS);
  ASSERT_EQ(body.vector(crumpled, &x), PETSC_SUCCESS);
  ASSERT_EQ(body.functional->describe_cells(x, &report), PETSC_SUCCESS);
  const auto cells = static_cast<std::size_t>(body.mesh.local_cells());
  ASSERT_EQ(report.determinant.size(), cells);
  ASSERT_EQ(report.negative_eigenvalues.size(), cells);
  double sums[3] = {0, 0, 0};
  for (std::size_t c = 0; c < cells; ++c) {
    sums[0] += report.determinant[c] / 162;  // equal volumes: 27 cubes of six
    sums[1] += report.energy_density[c] / 162;
    sums[2] += report.determinant[c] <= 0;
    if (report.determinant[c] <= 0) {
      EXPECT_GT(report.negative_eigenvalues[c], 0) << c;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  PetscInt64 inverted = 0;
  ASSERT_EQ(body.functional->count_inverted(x, &inverted), PETSC_SUCCESS);
  EXPECT_EQ(sums[2], inverted);
  EXPECT_NEAR(sums[1], energy_of(body, x), 1e-12);
}

}  // namespace
}  // namespace trefoil::test
