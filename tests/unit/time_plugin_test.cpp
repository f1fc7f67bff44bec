// What steps in time ask of the plugin: a factorisation whose failure is an answer, a stop test on
// the direction, a last step, solves that go on from each other, and other matrices than the
// Hessian's. Needs petsc_main.cpp.

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

int ranks() {
  int count = 0;
  MPI_Comm_size(PETSC_COMM_WORLD, &count);
  return count;
}

double largest_gap(const std::vector<double> &a, const std::vector<double> &b) {
  double gap = 0;
  for (std::size_t i = 0; i < a.size(); ++i) gap = std::max(gap, std::abs(a[i] - b[i]));
  return gap;
}

void use_cholesky(Host &host, const std::string &package) {
  host.option("pc_type", "cholesky");
  host.option("pc_factor_mat_solver_type", package);
}

/// CHOLMOD raises an error where MUMPS counts pivots: the same iterations come of it.
TEST(TimePluginTest, AFactorisationThatFailsAsksForAnotherWeight) {
  if (ranks() > 1) GTEST_SKIP() << "CHOLMOD runs on one rank";
  Host hosts[2] = {Host("mumps_"), Host("cholmod_")};
  for (Host &host : hosts) {
    host.option("snes_trefoil_filter", "on_demand");
    use_cholesky(host, &host == hosts ? "mumps" : "cholmod");
    if (&host != hosts) {
      host.option("mat_cholmod_factor", "SUPERNODAL");
      host.option("mat_cholmod_print", "0");
    }
    PetscBool retries = PETSC_FALSE;
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    ASSERT_EQ(TrefoilSNESRetriesFactors(host.snes, &retries), PETSC_SUCCESS);
    EXPECT_TRUE(retries);
    ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
    EXPECT_GT(host.reason, 0);
    int refused = 0;
    for (const auto &entry : host.history()) {
      EXPECT_EQ(entry.at("weight"), entry.at("refused") > 0 ? 0.5 : 0.);
      refused += entry.at("refused").get<int>();
    }
    EXPECT_GT(refused, 0);
    EXPECT_LT(refused, static_cast<int>(host.history().size()));
    EXPECT_EQ(host.chain.calls.size(), host.history().size() + static_cast<std::size_t>(refused));
    expect_descent(host);
  }
  ASSERT_EQ(hosts[0].history().size(), hosts[1].history().size());
  for (std::size_t k = 0; k < hosts[0].history().size(); ++k) {
    EXPECT_EQ(hosts[0].history()[k].at("refused"), hosts[1].history()[k].at("refused")) << k;
  }
  EXPECT_LT(largest_gap(hosts[0].solution, hosts[1].solution), 1e-9);
}

/// A rule that knows no other weight ends as before.
TEST(TimePluginTest, WithoutAnotherWeightTheFailureEndsTheSolve) {
  if (ranks() > 1) GTEST_SKIP() << "CHOLMOD runs on one rank";
  Host host;
  host.option("snes_trefoil_filter", "newton");
  use_cholesky(host, "cholmod");
  host.option("mat_cholmod_factor", "SUPERNODAL");
  host.option("mat_cholmod_print", "0");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  PetscBool retries = PETSC_TRUE;
  ASSERT_EQ(TrefoilSNESRetriesFactors(host.snes, &retries), PETSC_SUCCESS);
  EXPECT_FALSE(retries);
  const QuietErrors quiet;
  EXPECT_EQ(host.solve(concave_start(host.chain)), PETSC_ERR_MAT_CH_ZRPVT);
}

/// The last direction that was computed, from the states before and after the last full step.
TEST(TimePluginTest, TheDirectionIsSmallEnough) {
  double gradients[2] = {0, 0};
  for (const bool takes_last : {false, true}) {
    Host host;
    host.option("snes_trefoil_filter", "clamp");
    host.option("snes_trefoil_energy_tolerance", "0");
    host.option("snes_trefoil_direction_tolerance", "1e-3");
    host.option("snes_trefoil_take_last", takes_last ? "true" : "false");
    host.with_energy_scale = false;
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
    EXPECT_EQ(host.reason, SNES_CONVERGED_SNORM_RELATIVE);
    EXPECT_NE(host.record.at("result").at("reason").get<std::string>().find("direction"),
              std::string::npos);
    gradients[takes_last] = host.gradient_norm();
    const auto &last = host.history()[host.history().size() - (takes_last ? 2 : 1)];
    EXPECT_EQ(last.at("step"), takes_last ? 1. : 0.);
    EXPECT_EQ(host.record.at("result").at("iterations"),
              host.history().size() - (takes_last ? 1 : 0));
    expect_descent(host);
    // The state is within the tolerance of the minimum.
    Host exact;
    exact.option("snes_trefoil_energy_tolerance", "1e-24");
    ASSERT_EQ(exact.set_up(), PETSC_SUCCESS);
    ASSERT_EQ(exact.solve(convex_start(exact.chain)), PETSC_SUCCESS);
    EXPECT_LT(largest_gap(host.solution, exact.solution), takes_last ? 1e-5 : 1.1e-3);
  }
  EXPECT_LT(gradients[1], 1e-2 * gradients[0]);
}

/// Directions of an absolute filter are shorter than Newton's: they say nothing of the distance.
TEST(TimePluginTest, AFilterThatShortensIsNotBelieved) {
  Host host;
  host.option("snes_trefoil_filter", "absolute");
  host.option("snes_trefoil_energy_tolerance", "0");
  host.option("snes_trefoil_direction_tolerance", "1e3");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.history().size(), 1u);
  for (std::size_t k = 0; k + 1 < host.history().size(); ++k) {
    EXPECT_GT(host.history()[k].at("indefinite"), 0);
  }
  EXPECT_EQ(host.history().back().at("indefinite"), 0) << "Newton's own";
}

TEST(TimePluginTest, ASolveMayGoOnWithTheLastWeight) {
  for (const bool goes_on : {false, true}) {
    Host host;
    host.option("snes_trefoil_filter", "adaptive");
    host.option("snes_trefoil_continue", goes_on ? "true" : "false");
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
    EXPECT_EQ(host.history().front().at("weight"), 1);
    ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
    EXPECT_EQ(host.history().front().at("weight"), goes_on ? 0.5 : 1.);
  }
}

PetscErrorCode twice_identity(SNES, Mat P, void *calls) {
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  ++*static_cast<int *>(calls);
  PetscCall(MatGetOwnershipRange(P, &begin, &end));
  for (PetscInt i = begin; i < end; ++i) PetscCall(MatSetValue(P, i, i, 2, INSERT_VALUES));
  PetscCall(MatAssemblyBegin(P, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(P, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

TEST(TimePluginTest, OtherMatricesThanTheHessian) {
  Host newton;
  newton.chain.vertices = 6;
  newton.option("snes_trefoil_energy_tolerance", "1e-20");
  ASSERT_EQ(newton.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(newton.solve(convex_start(newton.chain)), PETSC_SUCCESS);
  for (const char *proxy : {"identity", "mass"}) {
    Host host;
    int calls = 0;
    host.chain.vertices = 6;
    host.option("snes_trefoil_proxy", proxy);
    host.option("snes_trefoil_energy_tolerance", "1e-16");
    host.option("snes_max_it", "5000");
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    ASSERT_EQ(TrefoilSNESSetMassProxy(host.snes, twice_identity, &calls), PETSC_SUCCESS);
    ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
    EXPECT_GT(host.reason, 0) << host.record.at("result").at("reason");
    EXPECT_LT(largest_gap(host.solution, newton.solution), 1e-4);
    EXPECT_GT(host.history().size(), 10 * newton.history().size());
    EXPECT_EQ(host.chain.calls.size(), 0u) << "no Hessian is made";
    EXPECT_EQ(calls, std::string(proxy) == "mass" ? 1 : 0);
    for (const auto &entry : host.history()) {
      EXPECT_EQ(entry.at("weight"), 0);
      EXPECT_TRUE(entry.at("rho").is_null());
    }
    EXPECT_TRUE(host.record.at("result").at("minimum").is_null());
    expect_descent(host);
    // The first direction is that of P.
    std::vector<double> expected(host.linear_solves.front().matrix.size(), 0);
    for (std::size_t i = 0; i < expected.size();
         i += static_cast<std::size_t>(host.chain.vertices) + 1) {
      expected[i] = std::string(proxy) == "mass" ? 2 : 1;
    }
    EXPECT_EQ(host.linear_solves.front().matrix, expected);
  }
}

TEST(TimePluginTest, AMassMustBeThere) {
  Host host;
  host.option("snes_trefoil_proxy", "mass");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const QuietErrors quiet;
  EXPECT_EQ(host.solve(convex_start(host.chain)), PETSC_ERR_USER_INPUT);
}

}  // namespace
}  // namespace trefoil::test
