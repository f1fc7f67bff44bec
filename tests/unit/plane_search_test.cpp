// Search `subspace`: minima, descent, what it costs, and when it begins. Needs petsc_main.cpp.

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

/// The callback for many energies at once, as a host would write it for the chain.
PetscErrorCode chain_energy_changes(SNES, Vec x, PetscInt directions, const Vec d[],
                                    PetscInt points, const PetscReal coefficients[],
                                    PetscReal changes[], void *ctx) {
  auto &chain = *static_cast<Chain *>(ctx);
  std::vector<double> at, direction[2];
  PetscFunctionBeginUser;
  PetscCall(whole(x, &at));
  for (PetscInt k = 0; k < directions; ++k) PetscCall(whole(d[k], &direction[k]));
  for (PetscInt p = 0; p < points; ++p) {
    std::vector<double> moved = at;
    for (PetscInt k = 0; k < directions; ++k)
      for (std::size_t i = 0; i < moved.size(); ++i)
        moved[i] += coefficients[directions * p + k] * direction[k][i];
    changes[p] = chain.energy(moved) - chain.energy(at);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A chain pulled far from where it starts.
struct Pulled : Host {
  explicit Pulled(const char *search, const char *prefix = nullptr)
      : Host(std::string(prefix ? prefix : search) + "_") {
    option("snes_trefoil_search", search);
    option("snes_trefoil_energy_tolerance", "1e-14");
    chain.place = 1.6;
    option("snes_trefoil_filter", "absolute");  // slow enough to tell searches apart
  }
  PetscErrorCode run(bool with_callback = true) {
    PetscFunctionBeginUser;
    PetscCall(set_up());
    if (with_callback) PetscCall(TrefoilSNESSetEnergyChanges(snes, chain_energy_changes, &chain));
    PetscCall(solve(concave_start(chain)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  [[nodiscard]] int result(const char *key) const { return record.at("result").at(key); }
  [[nodiscard]] double energy() const { return record.at("result").at("energy"); }
};

/// A plane that the search has asked for the energies of. Whole on every rank.
struct AskedPlane {
  std::vector<double> x, direction[2];
  int directions = 0;
};

struct Recorder {
  Chain *chain;
  std::vector<AskedPlane> planes;
};

PetscErrorCode record_planes(SNES snes, Vec x, PetscInt directions, const Vec d[], PetscInt points,
                             const PetscReal coefficients[], PetscReal changes[], void *ctx) {
  auto &recorder = *static_cast<Recorder *>(ctx);
  AskedPlane plane;
  PetscFunctionBeginUser;
  PetscCall(
      chain_energy_changes(snes, x, directions, d, points, coefficients, changes, recorder.chain));
  PetscCall(whole(x, &plane.x));
  for (PetscInt k = 0; k < directions; ++k) PetscCall(whole(d[k], &plane.direction[k]));
  plane.directions = static_cast<int>(directions);
  recorder.planes.push_back(std::move(plane));
  PetscFunctionReturn(PETSC_SUCCESS);
}

double dot(const std::vector<double> &a, const std::vector<double> &b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// a + s b.
std::vector<double> along(std::vector<double> a, double s, const std::vector<double> &b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += s * b[i];
  return a;
}

/// A u of a dense matrix.
std::vector<double> times(const std::vector<double> &A, const std::vector<double> &u) {
  std::vector<double> result;
  for (std::size_t i = 0; i < u.size(); ++i)
    result.push_back(dot({A.begin() + static_cast<std::ptrdiff_t>(i * u.size()),
                          A.begin() + static_cast<std::ptrdiff_t>((i + 1) * u.size())},
                         u));
  return result;
}

TEST(PlaneSearchTest, ThePlaneIsThatOfTheDirectionAndThePreviousStep) {
  Pulled host("subspace");
  host.option("snes_trefoil_trust_start", "true");
  host.option("snes_trefoil_corrections", "0");  // one plane and one matrix an iteration
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  Recorder recorder{&host.chain, {}};
  ASSERT_EQ(TrefoilSNESSetEnergyChanges(host.snes, record_planes, &recorder), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  const std::vector<AskedPlane> &planes = recorder.planes;
  ASSERT_GE(planes.size(), 4u);
  EXPECT_EQ(planes[0].directions, 1);  // no step before
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const auto &[x, direction, directions] = planes[k];
    const std::vector<double> g = host.chain.gradient(x), &H = host.linear_solves[k].matrix;
    // d = -H^-1 g.
    const double size = std::sqrt(dot(g, g));
    for (const double residual : along(times(H, direction[0]), 1, g))
      EXPECT_NEAR(residual, 0, 1e-10 * size) << k;
    if (k == 0) continue;
    ASSERT_EQ(directions, 2) << k;
    const std::vector<double> &p = direction[1], previous = along(x, -1, planes[k - 1].x);
    const double parallel = dot(p, previous) / std::sqrt(dot(p, p) * dot(previous, previous));
    EXPECT_NEAR(parallel, 1, 1e-12) << k;
    EXPECT_NEAR(dot(p, times(H, p)) / dot(direction[0], times(H, direction[0])), 1, 1e-8) << k;
  }
}

TEST(PlaneSearchTest, TheStepIsNoWorseThanThePlanesPoints) {
  Pulled host("subspace");
  host.option("snes_trefoil_trust_start", "true");
  host.option("snes_trefoil_corrections", "0");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  Recorder recorder{&host.chain, {}};
  ASSERT_EQ(TrefoilSNESSetEnergyChanges(host.snes, record_planes, &recorder), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  // The chain's energy is a polynomial of degree four in the plane, so the search knows it: at its
  // minimum the gradient is at right angles to the plane.
  const std::vector<AskedPlane> &planes = recorder.planes;
  int compared = 0;
  for (std::size_t k = 0; k + 1 < planes.size(); ++k) {
    const std::vector<double> &next = planes[k + 1].x;
    const std::vector<double> before = host.chain.gradient(planes[k].x),
                              after = host.chain.gradient(next);
    EXPECT_LE(host.chain.energy(next),
              host.chain.energy(along(planes[k].x, 1, planes[k].direction[0])) + 1e-12)
        << k;
    const std::vector<double> step = along(next, -1, planes[k].x);
    EXPECT_LT(std::abs(dot(after, step)), 1e-5 * std::abs(dot(before, step))) << k;
    ++compared;
  }
  EXPECT_GE(compared, 3);
}

/// Without the callback the fit is of degree two and misses the plane's minimum, so that the
/// gradient has a part along the previous step.
TEST(PlaneSearchTest, RhoIsThatOfTheStepTaken) {
  for (const bool with_callback : {true, false}) {
    Pulled host("subspace", "rho");
    host.option("snes_trefoil_trust_start", "true");
    host.option("snes_trefoil_corrections", "0");
    ASSERT_EQ(host.run(with_callback), PETSC_SUCCESS);
    int compared = 0;
    for (std::size_t k = 0; k + 1 < host.chain.calls.size(); ++k) {
      const JacobianCall &call = host.chain.calls[k];
      const std::vector<double> &next = host.chain.calls[k + 1].x, step = along(next, -1, call.x);
      const double predicted =
          -dot(host.chain.gradient(call.x), step) - 0.5 * dot(step, times(call.hessian, step));
      const double energy = host.chain.energy(call.x);
      if (std::abs(predicted) < 1e-6 * energy) continue;  // rounding of the energies would decide
      const double rho = (energy - host.chain.energy(next)) / predicted;
      EXPECT_NEAR(host.history()[k].at("rho"), rho, 1e-8 * std::max(1.0, std::abs(rho))) << k;
      ++compared;
    }
    EXPECT_GE(compared, 3);
  }
}

TEST(PlaneSearchTest, FindsTheSameMinimumWithFewerJacobians) {
  Pulled armijo("armijo"), subspace("subspace");
  subspace.option("snes_trefoil_trust_start", "true");
  ASSERT_EQ(armijo.run(), PETSC_SUCCESS);
  ASSERT_EQ(subspace.run(), PETSC_SUCCESS);
  EXPECT_GT(subspace.reason, 0);
  EXPECT_NEAR(subspace.energy(), armijo.energy(), 1e-12 * std::abs(armijo.energy()));
  EXPECT_LT(subspace.gradient_norm(), 1e-6);
  EXPECT_LT(subspace.result("iterations"), armijo.result("iterations"));
  expect_descent(subspace);
}

TEST(PlaneSearchTest, CountsItsCorrectionsAndSolves) {
  Pulled host("subspace");
  host.option("snes_trefoil_trust_start", "true");
  host.option("snes_trefoil_corrections", "2");
  host.option("snes_trefoil_correction_gain", "0");
  ASSERT_EQ(host.run(), PETSC_SUCCESS);
  int corrections = 0;
  for (const auto &entry : host.history()) {
    corrections += entry.at("corrections").get<int>();
    EXPECT_LE(entry.at("corrections"), 2);
  }
  EXPECT_GT(corrections, 0);
  EXPECT_EQ(static_cast<std::size_t>(host.result("iterations")), host.chain.calls.size());
  EXPECT_EQ(static_cast<std::size_t>(host.result("linear_solves")), host.linear_solves.size());
  EXPECT_GE(host.result("linear_solves"), host.result("iterations") + corrections);
  // The factors of a correction are those of its iteration: the matrix is the same.
  for (std::size_t k = 1; k < host.linear_solves.size(); ++k) {
    if (k % 3 != 0 && k < static_cast<std::size_t>(3 * (host.result("iterations") - 1))) {
      EXPECT_EQ(host.linear_solves[k].matrix, host.linear_solves[k - 1].matrix) << k;
    }
  }
}

TEST(PlaneSearchTest, CorrectionsThatGainLittleAreTheLast) {
  for (const auto &[gain, most] : {std::pair{"0", 3}, {"1e6", 1}}) {
    Pulled host("subspace", "gain");
    host.option("snes_trefoil_trust_start", "true");
    host.option("snes_trefoil_corrections", "3");
    host.option("snes_trefoil_correction_gain", gain);
    ASSERT_EQ(host.run(), PETSC_SUCCESS);
    EXPECT_GT(host.reason, 0);
    int found = 0;
    for (const auto &entry : host.history())
      found = std::max(found, entry.at("corrections").get<int>());
    EXPECT_EQ(found, most) << gain;
  }
}

TEST(PlaneSearchTest, WithoutCorrectionsSolvesOnceAnIteration) {
  Pulled host("subspace");
  host.option("snes_trefoil_trust_start", "true");
  host.option("snes_trefoil_corrections", "0");
  ASSERT_EQ(host.run(), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_EQ(host.result("linear_solves"), host.result("iterations"));
}

// A constant that takes the last ten digits of every energy costs no iterations: near the minimum
// the plane's own model, of slopes and products, says where to go.
TEST(PlaneSearchTest, DrownedEnergiesAreNotSampled) {
  Pulled plain("subspace", "plain"), drowned("subspace", "drowned");
  for (Pulled *host : {&plain, &drowned}) {
    host->option("snes_trefoil_verify_minimum", "false");
    host->option("snes_trefoil_decrement_tolerance", "1e-22");
  }
  drowned.chain.constant = 1e6;
  ASSERT_EQ(plain.run(), PETSC_SUCCESS);
  ASSERT_EQ(drowned.run(), PETSC_SUCCESS);
  EXPECT_GT(drowned.reason, 0) << drowned.record.at("result").at("reason");
  for (std::size_t i = 0; i < plain.solution.size(); ++i)
    EXPECT_NEAR(plain.solution[i], drowned.solution[i], 1e-8);
  EXPECT_LE(drowned.result("iterations"), plain.result("iterations") + 3);
}

TEST(PlaneSearchTest, BacktracksUntilTheModelIsTrusted) {
  Pulled armijo("armijo"), careful("subspace");
  for (Pulled *host : {&armijo, &careful}) host->option("snes_trefoil_rho_tolerance", "0");
  ASSERT_EQ(armijo.run(), PETSC_SUCCESS);
  ASSERT_EQ(careful.run(), PETSC_SUCCESS);
  // |rho - 1| < 0 never holds: the same solve.
  EXPECT_EQ(careful.solution, armijo.solution);
  EXPECT_EQ(careful.result("linear_solves"), armijo.result("linear_solves"));
}

TEST(PlaneSearchTest, DoesWithTheObjectiveAlone) {
  Pulled with("subspace", "with"), without("subspace", "without");
  for (Pulled *host : {&with, &without}) host->option("snes_trefoil_trust_start", "true");
  ASSERT_EQ(with.run(), PETSC_SUCCESS);
  ASSERT_EQ(without.run(false), PETSC_SUCCESS);
  EXPECT_GT(without.reason, 0);
  EXPECT_NEAR(without.energy(), with.energy(), 1e-12 * std::abs(with.energy()));
  expect_descent(without);
}

TEST(PlaneSearchTest, InfiniteSamplesLeaveTheDirectionAsItIs) {
  Pulled armijo("armijo"), subspace("subspace");
  for (Pulled *host : {&armijo, &subspace}) {
    host->option("snes_trefoil_trust_start", "true");
    host->option("snes_trefoil_corrections", "0");
  }
  const auto infinite = [](SNES, Vec, PetscInt, const Vec *, PetscInt points, const PetscReal *,
                           PetscReal *changes, void *) {
    std::fill_n(changes, points, std::numeric_limits<double>::infinity());
    return static_cast<PetscErrorCode>(PETSC_SUCCESS);
  };
  ASSERT_EQ(armijo.run(), PETSC_SUCCESS);
  ASSERT_EQ(subspace.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(TrefoilSNESSetEnergyChanges(subspace.snes, infinite, nullptr), PETSC_SUCCESS);
  ASSERT_EQ(subspace.solve(concave_start(subspace.chain)), PETSC_SUCCESS);
  EXPECT_EQ(subspace.solution, armijo.solution);
}

TEST(PlaneSearchTest, ASecondSolveKnowsNothingOfTheFirst) {
  Pulled host("subspace");
  host.option("snes_trefoil_trust_start", "true");
  ASSERT_EQ(host.run(), PETSC_SUCCESS);
  const std::vector<double> solution = host.solution;
  const int solves = host.result("linear_solves");
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_EQ(host.solution, solution);
  EXPECT_EQ(host.result("linear_solves"), solves);
}

struct OnDemand {
  const char *filter, *factors;
};
class RejectionTest : public testing::TestWithParam<OnDemand> {};

// From a concave start Newton's matrix is indefinite: the rule answers with another weight.
TEST_P(RejectionTest, AnIndefiniteJacobianIsReplaced) {
  Host host;
  host.option("snes_trefoil_filter", GetParam().filter);
  host.option("snes_trefoil_energy_tolerance", "1e-14");
  host.option("pc_type", "cholesky");
  host.option("pc_factor_mat_solver_type", GetParam().factors);
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_LT(host.gradient_norm(), 1e-6);
  EXPECT_EQ(host.chain.indefinite(host.solution), 0);
  expect_descent(host);
  const auto &result = host.record.at("result");
  if (GetParam().filter == std::string("on_demand")) {
    EXPECT_EQ(result.at("linear_solves"),
              result.at("iterations"));  // factors that fail solve nothing
    EXPECT_GT(result.at("factorisations"), result.at("iterations"));
    EXPECT_EQ(host.history()[0].at("refused"), 1);
    EXPECT_EQ(host.history()[0].at("weight"), 0.5);
    // Near the minimum nothing is indefinite: Newton's own matrix, and it converges as Newton does.
    EXPECT_EQ(host.history().back().at("weight"), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Rules, RejectionTest,
                         testing::Values(OnDemand{"on_demand", "mumps"},
                                         OnDemand{"three_state", "mumps"},
                                         OnDemand{"multiplicative", "mumps"}),
                         [](const auto &each) {
                           return each.param.filter + std::string("_") + each.param.factors;
                         });

}  // namespace
}  // namespace trefoil::test
