// Starting guesses: what they reproduce exactly, and that ranks agree. Needs petsc_main.cpp.

#include "body.hpp"
#include "solve/starting_guess.hpp"

namespace trefoil::test {
namespace {

/// Both ends of a box in z; its whole surface; and its bottom with the sides held in x alone.
bool ends(const double *p, int) {
  return p[2] < 1e-9 || p[2] > 1 - 1e-9;
}
bool surface(const double *p, int) {
  return ends(p, 0) || p[0] < 1e-9 || p[0] > 1 - 1e-9 || p[1] < 1e-9 || p[1] > 1 - 1e-9;
}

double affine(const double *p, int i) {
  return 0.1 * (i + 1) + 0.3 * p[i] - 0.2 * p[(i + 1) % 3] + 0.7 * p[(i + 2) % 3];
}
/// A rotation by `angle` about an axis through the box's middle, as a displacement.
double rotated(const double *p, int i, double angle) {
  const double x = p[0] - 0.5, y = p[1] - 0.5, c = std::cos(angle), s = std::sin(angle);
  return i == 0 ? c * x - s * y - x : i == 1 ? s * x + c * y - y : 0;
}

struct Guess {
  Body body;
  OwnedVec x;
  OwnedMat H;
  GuessCost cost;

  PetscErrorCode make(MPI_Comm comm, const Holding &holding, const Field &moved, PetscInt steps,
                      const char *mesh = "box", PetscInt resolution = 4, bool iterative = false) {
    Progress silent;
    PetscFunctionBeginUser;
    PetscCall(body.set_up(comm, generate_mesh(mesh, resolution, 0), holding, moved));
    PetscCall(body.discretization.create_vector(&x));
    PetscCall(body.discretization.create_matrix(&H));
    PetscCall(spread_displacements(*body.functional, body.discretization, H, steps, iterative,
                                   silent, x, &cost));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  /// Largest distance from a field, over the unknowns.
  [[nodiscard]] double distance(const Field &field) const {
    OwnedVec expected;
    PetscReal size = -1;
    EXPECT_EQ(body.vector(field, &expected), PETSC_SUCCESS);
    EXPECT_EQ(VecAXPY(expected, -1, x), PETSC_SUCCESS);
    EXPECT_EQ(VecNorm(expected, NORM_INFINITY, &size), PETSC_SUCCESS);
    return size;
  }
  /// Energy of the spreading of a kind.
  [[nodiscard]] double energy(Spreading kind) const {
    EnergySums sums;
    EXPECT_EQ(body.functional->spreading(kind)->energy(x, &sums), PETSC_SUCCESS);
    return sums.energy;
  }
};

TEST(GuessTest, AffineDisplacementsAreHarmonic) {
  Guess guess;
  ASSERT_EQ(guess.make(PETSC_COMM_WORLD, surface, affine, 0), PETSC_SUCCESS);
  EXPECT_LT(guess.distance(affine), 1e-12);
  EXPECT_EQ(guess.cost.linear_solves, 3);
}

TEST(GuessTest, ThePlaneHasTwoComponents) {
  const Holding rim = [](const double *p, int) {
    return p[0] < 1e-9 || p[0] > 1 - 1e-9 || p[1] < 1e-9 || p[1] > 1 - 1e-9;
  };
  Guess harmonic, rigid;
  ASSERT_EQ(harmonic.make(PETSC_COMM_WORLD, rim, affine, 0, "square"), PETSC_SUCCESS);
  EXPECT_LT(harmonic.distance(affine), 1e-12);
  EXPECT_EQ(harmonic.cost.linear_solves, 2);
  ASSERT_EQ(rigid.make(PETSC_COMM_WORLD, rim, affine, 3, "square"), PETSC_SUCCESS);
  EXPECT_EQ(rigid.cost.linear_solves, 2 * (1 + 3));
}

TEST(GuessTest, TheHarmonicExtensionHasNoForces) {
  Guess guess;
  OwnedVec g;
  PetscReal force = 0;
  ASSERT_EQ(guess.make(PETSC_COMM_WORLD, ends, crumpled, 0), PETSC_SUCCESS);
  ASSERT_EQ(VecDuplicate(guess.x, &g), PETSC_SUCCESS);
  ASSERT_EQ(guess.body.functional->spreading(Spreading::harmonic)->gradient(guess.x, g),
            PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(g, NORM_INFINITY, &force), PETSC_SUCCESS);
  EXPECT_LT(force, 1e-12);
}

TEST(GuessTest, ComponentsHeldAloneAreSpreadAlone) {
  Guess guess;
  ASSERT_EQ(guess.make(
                PETSC_COMM_WORLD, bottom_and_sides,
                [](const double *p, int i) { return i == 0 ? 0.25 * p[0] : 0; }, 3),
            PETSC_SUCCESS);
  ASSERT_EQ(guess.body.discretization.block_size(), 1);
  EXPECT_GT(guess.cost.linear_solves, 0);
  // The bottom is held in y and z, the sides are pulled apart in x.
  Guess harmonic;
  ASSERT_EQ(harmonic.make(
                PETSC_COMM_WORLD, bottom_and_sides,
                [](const double *p, int i) { return i == 0 ? 0.25 * p[0] : 0; }, 0),
            PETSC_SUCCESS);
  EXPECT_LT(harmonic.distance([](const double *p, int i) { return i == 0 ? 0.25 * p[0] : 0; }),
            1e-12);
}

TEST(GuessTest, RigidStepsFindARotation) {
  const Field turned = [](const double *p, int i) { return rotated(p, i, 2.0); };
  Guess guess;
  ASSERT_EQ(guess.make(PETSC_COMM_WORLD, surface, turned, 200), PETSC_SUCCESS);
  EXPECT_LT(guess.distance(turned), 1e-10);
}

TEST(GuessTest, ConjugateGradientsTakeFewIterationsAStep) {
  const Field twisted = [](const double *p, int i) { return rotated(p, i, 2 * p[2]); };
  Guess direct, iterative;
  ASSERT_EQ(direct.make(PETSC_COMM_WORLD, ends, twisted, 20, "box", 10), PETSC_SUCCESS);
  ASSERT_EQ(iterative.make(PETSC_COMM_WORLD, ends, twisted, 20, "box", 10, true), PETSC_SUCCESS);
  EXPECT_EQ(iterative.cost.linear_solves, direct.cost.linear_solves);
  EXPECT_LE(iterative.cost.linear_iterations, 4 * iterative.cost.linear_solves);
  const double least = direct.energy(Spreading::rigid);
  EXPECT_NEAR(iterative.energy(Spreading::rigid), least, 1e-3 * least);
}

TEST(GuessTest, EachRigidStepLowersTheEnergy) {
  const Field twisted = [](const double *p, int i) { return rotated(p, i, 2 * p[2]); };
  double last = std::numeric_limits<double>::infinity();
  for (PetscInt steps : {0, 1, 2, 5, 20, 60}) {
    Guess guess;
    ASSERT_EQ(guess.make(PETSC_COMM_WORLD, ends, twisted, steps), PETSC_SUCCESS);
    EXPECT_LT(guess.energy(Spreading::rigid), last) << steps;
    last = guess.energy(Spreading::rigid);
    EXPECT_EQ(guess.cost.linear_solves, 3 * (1 + steps));
  }
}

TEST(GuessTest, WhereNothingIsDisplacedNothingIsDone) {
  Guess guess;
  ASSERT_EQ(guess.make(PETSC_COMM_WORLD, bottom, at_rest, 20), PETSC_SUCCESS);
  EXPECT_EQ(guess.cost.linear_solves, 0);
  EXPECT_EQ(guess.distance(at_rest), 0);
}

TEST(GuessTest, ParallelIsSerial) {
  for (const Holding &holding : {Holding(ends), Holding(bottom_and_sides)}) {
    Guess parallel, serial;
    ASSERT_EQ(parallel.make(PETSC_COMM_WORLD, holding, crumpled, 5), PETSC_SUCCESS);
    ASSERT_EQ(serial.make(PETSC_COMM_SELF, holding, crumpled, 5), PETSC_SUCCESS);
    EnergySums one, other;
    ASSERT_EQ(parallel.body.functional->energy(parallel.x, &one), PETSC_SUCCESS);
    ASSERT_EQ(serial.body.functional->energy(serial.x, &other), PETSC_SUCCESS);
    EXPECT_NEAR(one.energy / other.energy, 1, 1e-10);
    PetscReal norms[2];
    ASSERT_EQ(VecNorm(parallel.x, NORM_2, &norms[0]), PETSC_SUCCESS);
    ASSERT_EQ(VecNorm(serial.x, NORM_2, &norms[1]), PETSC_SUCCESS);
    EXPECT_NEAR(norms[0] / norms[1], 1, 1e-10);
  }
}

TEST_P(SceneTest, EnergyChangesAreDifferencesOfEnergies) {
  ASSERT_EQ(body_.set_up(PETSC_COMM_WORLD, mesh(), GetParam().holding), PETSC_SUCCESS);
  OwnedVec x, d, p, moved;
  ASSERT_EQ(body_.vector(crumpled, &x), PETSC_SUCCESS);
  ASSERT_EQ(body_.vector([](const double *q, int i) { return noise(q, i + 3); }, &d),
            PETSC_SUCCESS);
  ASSERT_EQ(body_.vector([](const double *q, int i) { return 0.3 * noise(q, i + 7); }, &p),
            PETSC_SUCCESS);
  ASSERT_EQ(VecDuplicate(x, &moved), PETSC_SUCCESS);
  const std::vector<double> coefficients{0, 0, 1, 0, 0, 1, 0.3, -0.7, -2, 1.5};
  const Vec directions[2] = {d, p};
  std::vector<double> changes(5), line(5);
  ASSERT_EQ(
      body_.functional->energy_changes(x, 2, directions, 5, coefficients.data(), changes.data()),
      PETSC_SUCCESS);
  ASSERT_EQ(body_.functional->energy_changes(x, 1, directions, 5, coefficients.data(), line.data()),
            PETSC_SUCCESS);
  EnergySums start;
  ASSERT_EQ(body_.functional->energy(x, &start), PETSC_SUCCESS);
  for (std::size_t k = 0; k < 5; ++k) {
    EnergySums there;
    ASSERT_EQ(VecWAXPY(moved, coefficients[2 * k], d, x), PETSC_SUCCESS);
    ASSERT_EQ(VecAXPY(moved, coefficients[2 * k + 1], p), PETSC_SUCCESS);
    ASSERT_EQ(body_.functional->energy(moved, &there), PETSC_SUCCESS);
    const double size = std::abs(there.energy) + std::abs(start.energy);
    EXPECT_NEAR(changes[k], there.energy - start.energy, 1e-13 * size) << k;
    ASSERT_EQ(VecWAXPY(moved, coefficients[k], d, x), PETSC_SUCCESS);
    there = {};
    ASSERT_EQ(body_.functional->energy(moved, &there), PETSC_SUCCESS);
    EXPECT_NEAR(line[k], there.energy - start.energy,
                1e-13 * (std::abs(there.energy) + std::abs(start.energy)));
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, SceneTest, testing::ValuesIn(scenes),
                         [](const auto &each) { return std::string(each.param.name); });

}  // namespace
}  // namespace trefoil::test
