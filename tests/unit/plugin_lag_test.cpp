// Hosts that let the SNES keep a Jacobian for several iterations (-snes_lag_jacobian). Runs on any
// number of ranks; needs petsc_main.cpp.

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

TEST(LaggedJacobianTest, EveryIterationHasItsNumberAndCounts) {
  Host host;
  host.option("snes_lag_jacobian", "2");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_EQ(host.chain.indefinite(host.solution), 0);
  const auto &history = host.history();
  ASSERT_GT(history.size(), 3u);
  EXPECT_EQ(host.chain.calls.size(), (history.size() + 1) / 2);
  EXPECT_EQ(host.record.at("result").at("iterations"), history.size());
  EXPECT_EQ(host.record.at("result").at("linear_solves"), history.size());
  for (std::size_t k = 0; k < history.size(); ++k) {
    EXPECT_EQ(history[k].at("k"), k);
    EXPECT_EQ(history[k].at("linear_solves"), k + 1);
    if (k % 2 == 1) {
      EXPECT_EQ(history[k].at("weight"), history[k - 1].at("weight"));
    }
  }
  expect_descent(host);
}

TEST(LaggedJacobianTest, AWeightOutlivesItsSolve) {
  Host host;
  host.option("snes_trefoil_filter", "constant");
  host.option("snes_trefoil_weight", "0.75");
  host.option("snes_lag_jacobian", "-2");  // once, and never again
  host.option("snes_lag_jacobian_persists", "true");
  host.option("snes_max_it", "3");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  for (int solve = 0; solve < 2; ++solve) {
    ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
    EXPECT_EQ(host.chain.calls.size(), solve == 0 ? 1u : 0u);
    for (const auto &entry : host.history()) EXPECT_EQ(entry.at("weight"), 0.75);
  }
}

/// An indefinite Jacobian is made again with another weight, also when the SNES would keep it.
TEST(LaggedJacobianTest, ARejectedJacobianIsReplaced) {
  Host host;
  host.option("snes_trefoil_filter", "on_demand");
  host.option("snes_lag_jacobian", "-2");
  host.option("pc_type", "cholesky");
  host.option("pc_factor_mat_solver_type", "mumps");
  host.option("snes_max_it", "6");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_EQ(host.history().at(0).at("weight"), 0.5);
  EXPECT_LT(host.history().back().at("energy"), host.history().front().at("energy"));
  PetscInt lag = 0;
  ASSERT_EQ(SNESGetLagJacobian(host.snes, &lag), PETSC_SUCCESS);
  EXPECT_EQ(lag, -1);  // what PETSc makes of it after the first one
  expect_descent(host);
}

}  // namespace
}  // namespace trefoil::test
