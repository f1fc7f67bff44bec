// Linear solvers that end early, or with nothing: no end of a solve may rest on what they leave.
// Runs on any number of ranks; needs petsc_main.cpp.

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

using Options = std::vector<std::pair<std::string, std::string>>;

/// A host with conjugate gradients in the place of factors.
class KrylovHost : public Host {
 public:
  explicit KrylovHost(const Options &options) {
    option("ksp_type", "cg");
    option("pc_type", "jacobi");
    for (const auto &[name, value] : options) option(name, value);
    EXPECT_EQ(set_up(), PETSC_SUCCESS);
    EXPECT_EQ(solve(convex_start(chain)), PETSC_SUCCESS);
  }
  [[nodiscard]] std::string why() const { return record.at("result").at("reason"); }
  [[nodiscard]] double energy() const { return history().back().at("energy"); }
};

/// Where a host ends that solves its linear systems exactly.
double exact_energy() {
  return KrylovHost(Options{{"ksp_rtol", "1e-10"}}).energy();
}

TEST(FirstGuessTest, IsNoDirectionThoughAnAbsoluteToleranceIsMetByIt) {
  const double exact = exact_energy();
  const KrylovHost host(Options{{"ksp_atol", "1e30"}});
  EXPECT_GT(host.reason, 0);
  EXPECT_EQ(host.why().find("direction is zero"), std::string::npos) << host.why();
  const double scale = host.record.at("result").at("energy_scale");
  EXPECT_LT(host.energy() - exact, 1e-7 * scale);
  PetscReal absolute = 0;
  KSP ksp = nullptr;
  ASSERT_EQ(SNESGetKSP(host.snes, &ksp), PETSC_SUCCESS);
  ASSERT_EQ(KSPGetTolerances(ksp, nullptr, &absolute, nullptr, nullptr), PETSC_SUCCESS);
  EXPECT_EQ(absolute, 1e30);
}

TEST(LastSolveTest, SaysWhereItIsNotExactEnough) {
  const std::string doubt = "the energy error is not known: the last linear solve left ";
  for (const Options &options :
       {Options{{"ksp_type", "preonly"}, {"snes_max_it", "2000"}},
        Options{
            {"ksp_max_it", "2"}, {"ksp_rtol", "0.1"}, {"snes_max_linear_solve_fail", "1000"}}}) {
    const KrylovHost host(options);
    ASSERT_GT(host.reason, 0) << host.why();
    EXPECT_NE(host.why().find(doubt), std::string::npos) << host.why();
    EXPECT_GT(host.record.at("result").at("linear_residual"), 0.01);
  }
  for (const Options &options :
       {Options{{"ksp_rtol", "0.1"}}, Options{{"ksp_type", "preonly"}, {"pc_type", "lu"}}}) {
    const KrylovHost host(options);
    ASSERT_GT(host.reason, 0) << host.why();
    EXPECT_EQ(host.why().find(doubt), std::string::npos) << host.why();
    EXPECT_LT(host.record.at("result").at("linear_residual"), 0.01);
  }
}

TEST(NoDirectionTest, IsAFailureOfTheLinearSolver) {
  const KrylovHost host(Options{{"ksp_type", "richardson"},
                                {"ksp_richardson_scale", "0"},
                                {"ksp_norm_type", "none"},
                                {"ksp_max_it", "3"}});
  EXPECT_EQ(host.reason, SNES_DIVERGED_LINEAR_SOLVE);
  EXPECT_NE(host.why().find("no direction where the gradient is not zero (CONVERGED_ITS)"),
            std::string::npos)
      << host.why();
  EXPECT_EQ(host.solution, convex_start(host.chain));
}

}  // namespace
}  // namespace trefoil::test
