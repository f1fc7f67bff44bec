// Contact as a term of a scene's energy, on any number of ranks: the gradient against differences
// of energies, H against differences of gradients, in a matrix whose pattern follows; sums that do
// not depend on ranks; the longest step. Needs petsc_main.cpp.

#include "term/contact_term.hpp"
#include "body.hpp"
#include "mesh/boundary.hpp"

namespace trefoil::test {
namespace {

/// Two cubes of side 1, one above the other, `gap` between them.
CellList two_boxes(double gap) {
  CellList both = generate_mesh("box", 2, 0);
  const CellList one = both;
  const auto vertices = static_cast<PetscInt>(one.coordinates.size() / 3);
  for (std::size_t k = 0; k < one.coordinates.size(); k += 3) {
    both.coordinates.push_back(one.coordinates[k] * 0.9 + 0.07);
    both.coordinates.push_back(one.coordinates[k + 1] * 0.9 + 0.03);
    both.coordinates.push_back(one.coordinates[k + 2] + 1 + gap);
  }
  for (const PetscInt node : one.cells) both.cells.push_back(node + vertices);
  return both;
}

constexpr double gap = 0.05, dhat = 0.1;

double slightly_bent(const double *p, int i) {
  return 0.01 * noise(p, i);
}

/// A body, or two, with contact.
struct ContactBody {
  Body body;
  ContactTerm *contact = nullptr;

  PetscErrorCode set_up(MPI_Comm comm, const CellList &whole, double friction, bool on_plane) {
    PetscFunctionBeginUser;
    PetscCall(body.set_up(comm, whole, nothing));
    auto surface = std::make_unique<ContactSurface>();
    const std::vector<double> stiffness(static_cast<std::size_t>(body.mesh.local_cells()), 3);
    PetscCall(surface->set_up(body.mesh, body.discretization.global_dofs(), stiffness, {}));
    ContactParameters parameters{.distance = dhat,
                                 .limits = {.touching = 1e-12, .far = dhat},
                                 .slip_velocity = 0.01,
                                 .friction = {}};
    if (friction > 0) parameters.friction = [friction](int, int) { return friction; };
    std::vector<HalfSpaceObstacle> planes;
    if (on_plane) {
      planes.push_back({"floor",
                        {{0, 0, 1}, -0.03},
                        [](double time) {
                          return contact::Vector3{0.1 * time, 0, 0};
                        },
                        friction});
    }
    auto term = std::make_unique<ContactTerm>(std::move(surface), std::move(parameters),
                                              std::move(planes), std::vector<ObstacleMotion>{});
    contact = term.get();
    body.functional->add_term(std::move(term));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};

class ContactTermTest : public testing::TestWithParam<double> {
 protected:
  void SetUp() override {
    ASSERT_EQ(two_.set_up(PETSC_COMM_WORLD, two_boxes(gap), GetParam(), true), PETSC_SUCCESS);
    ASSERT_EQ(two_.body.vector(slightly_bent, &x_), PETSC_SUCCESS);
    // A step is under way: friction has its forces from rest, and what has slipped is bent.
    ASSERT_EQ(two_.body.vector(at_rest, &rest_), PETSC_SUCCESS);
    ASSERT_EQ(two_.body.functional->accept_step(rest_), PETSC_SUCCESS);
    ASSERT_EQ(two_.body.functional->set_time(0.5), PETSC_SUCCESS);
  }
  double energy_at(Vec x) {
    EnergySums sums;
    EXPECT_EQ(two_.body.functional->energy(x, &sums), PETSC_SUCCESS);
    return sums.energy;
  }

  ContactBody two_;
  OwnedVec x_, rest_;
};

/// A direction that is the same on any number of ranks.
double direction(const double *p, int i) {
  return noise(p, i + 3);
}

TEST_P(ContactTermTest, GradientIsThatOfTheEnergy) {
  OwnedVec d, g, moved;
  ASSERT_EQ(two_.body.vector(direction, &d), PETSC_SUCCESS);
  ASSERT_EQ(VecDuplicate(x_, &g), PETSC_SUCCESS);
  ASSERT_EQ(VecDuplicate(x_, &moved), PETSC_SUCCESS);
  ASSERT_EQ(two_.body.functional->gradient(x_, g), PETSC_SUCCESS);
  PetscReal slope = 0;
  ASSERT_EQ(VecDot(g, d, &slope), PETSC_SUCCESS);
  const double h = 1e-6;
  ASSERT_EQ(VecWAXPY(moved, h, d, x_), PETSC_SUCCESS);
  const double after = energy_at(moved);
  ASSERT_EQ(VecWAXPY(moved, -h, d, x_), PETSC_SUCCESS);
  EXPECT_NEAR((after - energy_at(moved)) / (2 * h), slope, 1e-6 * std::abs(slope));
}

TEST_P(ContactTermTest, HessianIsThatOfTheGradient) {
  OwnedVec d, g, other, product, moved;
  OwnedMat H;
  TrefoilSplitStatistics statistics{};
  ASSERT_EQ(two_.body.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(two_.body.vector(direction, &d), PETSC_SUCCESS);
  for (Vec *v : {&g, &other, &product, &moved}) {
    ASSERT_EQ(VecDuplicate(x_, v), PETSC_SUCCESS);
  }
  ASSERT_EQ(two_.body.functional->hessian(x_, H, nullptr, &statistics), PETSC_SUCCESS);
  ASSERT_EQ(MatMult(H, d, product), PETSC_SUCCESS);
  const double h = 1e-7;
  ASSERT_EQ(VecWAXPY(moved, h, d, x_), PETSC_SUCCESS);
  ASSERT_EQ(two_.body.functional->gradient(moved, g), PETSC_SUCCESS);
  ASSERT_EQ(VecWAXPY(moved, -h, d, x_), PETSC_SUCCESS);
  ASSERT_EQ(two_.body.functional->gradient(moved, other), PETSC_SUCCESS);
  ASSERT_EQ(VecAXPY(g, -1, other), PETSC_SUCCESS);
  ASSERT_EQ(VecScale(g, 1 / (2 * h)), PETSC_SUCCESS);
  PetscReal size = 0, error = 0;
  ASSERT_EQ(VecNorm(product, NORM_INFINITY, &size), PETSC_SUCCESS);
  ASSERT_EQ(VecAXPY(g, -1, product), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(g, NORM_INFINITY, &error), PETSC_SUCCESS);
  EXPECT_LT(error, 1e-5 * size);
}

/// The same sums on any number of ranks: those of one, which each rank computes by itself.
TEST_P(ContactTermTest, RanksAgree) {
  ContactBody alone;
  OwnedVec x, rest, g, of_alone;
  EnergySums sums;
  ASSERT_EQ(alone.set_up(PETSC_COMM_SELF, two_boxes(gap), GetParam(), true), PETSC_SUCCESS);
  ASSERT_EQ(alone.body.vector(slightly_bent, &x), PETSC_SUCCESS);
  ASSERT_EQ(alone.body.vector(at_rest, &rest), PETSC_SUCCESS);
  ASSERT_EQ(alone.body.functional->accept_step(rest), PETSC_SUCCESS);
  ASSERT_EQ(alone.body.functional->set_time(0.5), PETSC_SUCCESS);
  ASSERT_EQ(alone.body.functional->energy(x, &sums), PETSC_SUCCESS);
  EXPECT_NEAR(energy_at(x_), sums.energy, 1e-11 * sums.energy);

  PetscReal norm = 0, norm_alone = 0;
  ASSERT_EQ(VecDuplicate(x_, &g), PETSC_SUCCESS);
  ASSERT_EQ(VecDuplicate(x, &of_alone), PETSC_SUCCESS);
  ASSERT_EQ(two_.body.functional->gradient(x_, g), PETSC_SUCCESS);
  ASSERT_EQ(alone.body.functional->gradient(x, of_alone), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(g, NORM_2, &norm), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(of_alone, NORM_2, &norm_alone), PETSC_SUCCESS);
  EXPECT_NEAR(norm, norm_alone, 1e-11 * norm_alone);

  ContactReport report, report_alone;
  std::vector<double> u(two_.body.mesh.coordinates.size(), 0);
  std::vector<double> u_alone(alone.body.mesh.coordinates.size(), 0);
  ASSERT_EQ(two_.contact->report(u.data(), &report), PETSC_SUCCESS);
  ASSERT_EQ(alone.contact->report(u_alone.data(), &report_alone), PETSC_SUCCESS);
  EXPECT_EQ(report.pairs, report_alone.pairs);
  EXPECT_GT(report.pairs, 50);
  EXPECT_NEAR(report.gap, 0.03, 1e-12);  // to the floor
}

/// Down by more than the floor is away: stopped at nine tenths of the way there.
TEST_P(ContactTermTest, StepsEndBeforeTheWall) {
  OwnedVec d;
  double largest = 0;
  ASSERT_EQ(two_.body.vector([](const double *, int i) { return i == 2 ? -0.3 : 0; }, &d),
            PETSC_SUCCESS);
  ASSERT_EQ(two_.body.functional->largest_step(rest_, d, 1, &largest), PETSC_SUCCESS);
  EXPECT_NEAR(largest, 0.9 * 0.03 / 0.3, 1e-9);
  // The upper box alone, into the lower one.
  ASSERT_EQ(
      two_.body.vector([](const double *p, int i) { return i == 2 && p[2] > 1.01 ? -0.2 : 0; }, &d),
      PETSC_SUCCESS);
  ASSERT_EQ(two_.body.functional->largest_step(rest_, d, 1, &largest), PETSC_SUCCESS);
  EXPECT_GT(largest, 0.8 * gap / 0.2);
  EXPECT_LT(largest, gap / 0.2);
}

/// A contact that comes, goes and comes again: the same H as in a matrix made anew.
TEST_P(ContactTermTest, PatternFollows) {
  OwnedMat H;
  OwnedVec far, product, d;
  TrefoilSplitStatistics statistics{};
  const auto apart = [](const double *p, int i) {
    return slightly_bent(p, i) + (i == 2 && p[2] > 1.01 ? 0.5 : 0);
  };
  ASSERT_EQ(two_.body.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(two_.body.vector(apart, &far), PETSC_SUCCESS);
  ASSERT_EQ(two_.body.vector(direction, &d), PETSC_SUCCESS);
  ASSERT_EQ(VecDuplicate(d, &product), PETSC_SUCCESS);
  double curvature[3] = {};
  const Vec states[3] = {x_, far, x_};
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(two_.body.functional->hessian(states[k], H, nullptr, &statistics), PETSC_SUCCESS);
    ASSERT_EQ(MatMult(H, d, product), PETSC_SUCCESS);
    ASSERT_EQ(VecDot(product, d, &curvature[k]), PETSC_SUCCESS);
  }
  EXPECT_EQ(curvature[0], curvature[2]);
  EXPECT_GT(curvature[0], curvature[1] * 1.01);
}

TEST_P(ContactTermTest, AStateThatIntersectsIsFound) {
  PetscInt64 count = 0;
  std::string first;
  std::vector<double> u(two_.body.mesh.coordinates.size(), 0);
  ASSERT_EQ(two_.contact->find_intersections(u.data(), &count, &first), PETSC_SUCCESS);
  EXPECT_EQ(count, 0) << first;
  for (std::size_t k = 2; k < u.size(); k += 3) {
    if (two_.body.mesh.coordinates[k] > 1.01) u[k] = -0.1;
  }
  ASSERT_EQ(two_.contact->find_intersections(u.data(), &count, &first), PETSC_SUCCESS);
  EXPECT_GT(count, 0);
  EXPECT_NE(first.find("edge ("), std::string::npos) << first;
}

/// Displaces all vertices by a length along an axis.
PetscErrorCode move_along(int axis, double length, Body *body, Vec *x) {
  PetscFunctionBeginUser;
  PetscCall(body->vector([=](const double *, int i) { return i == axis ? length : 0; }, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The sum of the vertices' gradients along an axis.
double pull_along(Body &body, int axis, Vec x) {
  OwnedVec g, one;
  PetscReal sum = 0;
  EXPECT_EQ(move_along(axis, 1, &body, &one), PETSC_SUCCESS);
  EXPECT_EQ(VecDuplicate(x, &g), PETSC_SUCCESS);
  EXPECT_EQ(body.functional->gradient(x, g), PETSC_SUCCESS);
  EXPECT_EQ(VecDot(g, one, &sum), PETSC_SUCCESS);
  return sum;
}

/// Within a step bodies meet a floor that glides away: it takes them along.
TEST_P(ContactTermTest, FrictionThatBeginsWithinAStepKnowsHowObstaclesMove) {
  OwnedVec lifted;
  ASSERT_EQ(move_along(2, 0.2, &two_.body, &lifted), PETSC_SUCCESS);
  std::vector<double> u(two_.body.mesh.coordinates.size(), 0);
  ASSERT_EQ(two_.body.functional->accept_step(lifted), PETSC_SUCCESS);
  ASSERT_EQ(two_.body.functional->set_time(1), PETSC_SUCCESS);
  ASSERT_EQ(two_.contact->lag_friction(u.data()), PETSC_SUCCESS);
  const double normal = pull_along(two_.body, 2, rest_);
  EXPECT_LT(normal, -1e-3);
  EXPECT_NEAR(pull_along(two_.body, 0, rest_), GetParam() * normal, 1e-9 * std::abs(normal));
}

/// Pressed deeper within a step, on a gliding floor: friction has still the forces of its begin.
TEST_P(ContactTermTest, ReportsWhatLagsOfFriction) {
  OwnedVec lowered;
  ASSERT_EQ(move_along(2, -0.01, &two_.body, &lowered), PETSC_SUCCESS);
  const std::vector<double> u(two_.body.mesh.coordinates.size(), 0);
  ContactReport report;
  const double begin = -pull_along(two_.body, 2, rest_);
  const double end = -pull_along(two_.body, 2, lowered);
  EXPECT_GT(end, 1.1 * begin);
  EXPECT_NEAR(-pull_along(two_.body, 0, lowered), GetParam() * begin, 1e-9 * begin);
  ASSERT_EQ(two_.body.functional->accept_step(lowered), PETSC_SUCCESS);
  ASSERT_EQ(two_.contact->report(u.data(), &report), PETSC_SUCCESS);
  EXPECT_NEAR(report.friction_force, GetParam() * end, 1e-9 * end);
  EXPECT_NEAR(report.friction_change, GetParam() * (end - begin), 1e-9 * end);
}

INSTANTIATE_TEST_SUITE_P(Friction, ContactTermTest, testing::Values(0, 0.4));

}  // namespace
}  // namespace trefoil::test
