// What is minimised must be an energy: hosts without an objective, with one that is none, with one
// that is not the residual's, and with a right-hand side. Needs petsc_main.cpp.

#include <cmath>
#include <limits>

#include "element_host.hpp"
#include "plugin_fixture.hpp"
#include "search/energy_check.hpp"

namespace trefoil::test {
namespace {

/// The chain as a host that knows nothing of Trefoil gives it: residual and element blocks.
class Plain {
 public:
  enum class Objective { none, energy, norm, half_square, square };

  explicit Plain(Objective objective) : objective_(objective) {}
  Plain(const Plain &) = delete;
  Plain &operator=(const Plain &) = delete;
  ~Plain() {
    for (const std::string &name : options_)
      static_cast<void>(PetscOptionsClearValue(nullptr, name.c_str()));
    static_cast<void>(SNESDestroy(&snes_));
    static_cast<void>(MatDestroy(&H_));
    static_cast<void>(VecDestroy(&x_));
  }
  void option(const std::string &name, const std::string &value) {
    options_.push_back("-plain_" + name);
    EXPECT_EQ(PetscOptionsSetValue(nullptr, options_.back().c_str(), value.c_str()), 0);
  }

  PetscErrorCode solve(const std::vector<double> &start) {
    KSP ksp = nullptr;
    PC pc = nullptr;
    Vec b = nullptr;
    const char *text = nullptr;
    PetscFunctionBeginUser;
    PetscCall(TrefoilInitializePackage());
    PetscCall(chain_matrix(chain, &H_));
    PetscCall(MatCreateVecs(H_, &x_, nullptr));
    PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes_));
    PetscCall(SNESSetOptionsPrefix(snes_, "plain_"));
    PetscCall(SNESSetType(snes_, SNESTREFOIL));
    if (objective_ != Objective::none) PetscCall(SNESSetObjective(snes_, objective, this));
    PetscCall(SNESSetFunction(snes_, nullptr, residual, this));
    PetscCall(SNESSetJacobian(snes_, H_, H_, jacobian, this));
    PetscCall(SNESSetTolerances(snes_, 1e-12, 0, 0, 200, 100000));
    PetscCall(SNESGetKSP(snes_, &ksp));
    PetscCall(KSPSetType(ksp, KSPPREONLY));
    PetscCall(KSPGetPC(ksp, &pc));
    PetscCall(PCSetType(pc, PCLU));
    PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
    PetscCall(SNESSetFromOptions(snes_));
    PetscCall(fill(x_, start));
    if (load != 0) {
      PetscCall(VecDuplicate(x_, &b));
      PetscCall(VecSet(b, load));
    }
    PetscCall(SNESSolve(snes_, b, x_));
    PetscCall(VecDestroy(&b));
    PetscCall(whole(x_, &solution));
    PetscCall(SNESGetConvergedReason(snes_, &reason));
    PetscCall(TrefoilSNESGetRecord(snes_, &text));
    record = nlohmann::json::parse(text);
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  Chain chain;
  double sign = 1;  ///< of residual and Jacobian
  double load = 0;  ///< SNESSolve's right-hand side, in every unknown
  std::vector<double> solution;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  nlohmann::json record;

 private:
  [[nodiscard]] std::vector<double> gradient(const std::vector<double> &x) const {
    std::vector<double> g = chain.gradient(x);
    for (double &value : g) value *= sign;
    return g;
  }
  static PetscErrorCode objective(SNES snes, Vec x, PetscReal *value, void *ctx) {
    const auto &host = *static_cast<Plain *>(ctx);
    std::vector<double> values;
    Vec f = nullptr;
    PetscReal norm = 0;
    PetscFunctionBeginUser;
    PetscCall(whole(x, &values));
    if (host.objective_ == Objective::energy) {
      *value = host.chain.energy(values);
      PetscFunctionReturn(PETSC_SUCCESS);
    }
    PetscCall(VecDuplicate(x, &f));
    PetscCall(residual(snes, x, f, ctx));
    PetscCall(VecNorm(f, NORM_2, &norm));
    PetscCall(VecDestroy(&f));
    *value = host.objective_ == Objective::norm ? norm : norm * norm;
    if (host.objective_ == Objective::half_square) *value /= 2;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  static PetscErrorCode residual(SNES, Vec x, Vec f, void *ctx) {
    const auto &host = *static_cast<Plain *>(ctx);
    std::vector<double> values;
    PetscFunctionBeginUser;
    PetscCall(whole(x, &values));
    PetscCall(fill(f, host.gradient(values)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  static PetscErrorCode jacobian(SNES, Vec x, Mat, Mat H, void *ctx) {
    const auto &host = *static_cast<Plain *>(ctx);
    std::vector<double> values;
    PetscInt begin = 0, end = 0;
    PetscFunctionBeginUser;
    PetscCall(whole(x, &values));
    PetscCall(MatZeroEntries(H));
    PetscCall(MatGetOwnershipRange(H, &begin, &end));
    PetscCall(host.chain.each_element(values, begin, end, Chain::all_of, 1,
                                      [&](int rows, const PetscInt *index, const double *block) {
                                        std::vector<double> scaled(block, block + rows * rows);
                                        for (double &value : scaled) value *= host.sign;
                                        return MatSetValues(H, rows, index, rows, index,
                                                            scaled.data(), ADD_VALUES);
                                      }));
    PetscCall(MatAssemblyBegin(H, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(H, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  Objective objective_;
  std::vector<std::string> options_;
  SNES snes_ = nullptr;
  Mat H_ = nullptr;
  Vec x_ = nullptr;
};

using Objective = Plain::Objective;

double distance(const std::vector<double> &a, const std::vector<double> &b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

// The energy that was gained since the start is a million times what a step still changes.
TEST(NoObjectiveTest, TheSearchKeepsTheDigitsOfItsIntegral) {
  Plain without(Objective::none), with(Objective::energy);
  const std::vector<double> start = concave_start(without.chain);
  for (Plain *host : {&without, &with}) {
    ASSERT_EQ(host->solve(start), PETSC_SUCCESS);
    EXPECT_EQ(host->reason, SNES_CONVERGED_FNORM_ABS);
  }
  EXPECT_LT(distance(without.solution, with.solution), 1e-10);
  EXPECT_EQ(without.record.at("result").at("iterations"),
            with.record.at("result").at("iterations"));
  // rho is a ratio, not noise, to the end.
  const auto &history = without.record.at("history");
  EXPECT_NEAR(history[history.size() - 2].at("rho").get<double>(), 1, 1e-3);
}

class NormTest : public testing::TestWithParam<Objective> {};
INSTANTIATE_TEST_SUITE_P(Norms, NormTest,
                         testing::Values(Objective::norm, Objective::half_square,
                                         Objective::square));

TEST_P(NormTest, ThatIsTheObjectiveIsIgnoredAndSaid) {
  Plain host(GetParam()), energy(Objective::none);
  const std::vector<double> start = concave_start(host.chain);
  ASSERT_EQ(host.solve(start), PETSC_SUCCESS);
  ASSERT_EQ(energy.solve(start), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_LT(distance(host.solution, energy.solution), 1e-10);
  const auto &notes = host.record.at("solver").at("notes");
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].get<std::string>().find("norm of the residual"), std::string::npos);
  EXPECT_TRUE(energy.record.at("solver").at("notes").empty());
}

// f = |x - 1|^2 / 2 is half the square of its gradient's norm, and an energy.
TEST(NormTest, AnEnergyOfThatValueIsNone) {
  ElementHost host;
  host.option("snes_linesearch_damping", "0.5");
  host.energy_offset = 0.5;  // of each unknown
  const PetscScalar one[] = {1, 0, 0, 1};
  ASSERT_EQ(host.solve(8, 1,
                       [&](Mat H) {
                         PetscFunctionBeginUser;
                         PetscCall(MatZeroEntries(H));
                         for (PetscInt e = rank_of_world(); e < 4; e += size_of_world()) {
                           const PetscInt index[] = {2 * e, 2 * e + 1};
                           PetscCall(MatSetValues(H, 2, index, 2, index, one, ADD_VALUES));
                         }
                         PetscCall(finish_assembly(H));
                         PetscFunctionReturn(PETSC_SUCCESS);
                       }),
            0);
  EXPECT_TRUE(host.record.at("solver").at("notes").empty());
}

TEST(RightHandSideTest, IsTakenIntoTheEnergy) {
  Plain with(Objective::energy), without(Objective::none);
  for (Plain *host : {&with, &without}) {
    host->load = 2;
    ASSERT_EQ(host->solve(concave_start(host->chain)), PETSC_SUCCESS);
    EXPECT_GT(host->reason, 0);
  }
  EXPECT_LT(distance(with.solution, without.solution), 1e-9);
  double work = 0;
  for (const double x : with.solution) work += 2 * x;
  EXPECT_NEAR(with.record.at("result").at("energy"), with.chain.energy(with.solution) - work, 1e-9);
}

TEST(SignTest, MinusTheGradientIsRefused) {
  Plain host(Objective::energy);
  host.sign = -1;
  const CaughtError error;
  EXPECT_NE(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
  EXPECT_NE(error.sentence.find("SNESSetFunction() wants plus the gradient"), std::string::npos)
      << error.sentence;
}

// Without an energy to compare it may be a step that is too long as well, which a host that steps
// in time can answer by a shorter one.
TEST(SignTest, WithoutAnObjectiveTheSolveDiverges) {
  Plain host(Objective::none);
  host.sign = -1;
  ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
  EXPECT_EQ(host.reason, SNES_DIVERGED_LINE_SEARCH);
  const auto &notes = host.record.at("solver").at("notes");
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0], host.record.at("result").at("reason"));
  EXPECT_NE(notes[0].get<std::string>().find("SNESSetFunction() wants plus the gradient"),
            std::string::npos);
}

/// A solve's history of decrements and gradients' norms, the last being the iteration under way.
SolveRecord record_of_descent(const std::vector<double> &norms) {
  SolveRecord record;
  for (const double norm : norms) {
    IterationRecord iteration;
    iteration.gradient_norm = norm;
    iteration.decrement = norm * norm;
    record.history.push_back(iteration);
  }
  record.current = record.history.back();
  record.history.pop_back();
  return record;
}

// Where linear solves are rough a saddle is left slowly, and its residual grows all the way.
TEST(SignTest, ASaddleThatIsLeftIsNoEndlessDescent) {
  std::vector<double> norms;
  for (double norm = 100; norm > 1e-5; norm /= 4) norms.push_back(norm);
  for (double norm = 1e-5; norm < 50; norm *= 1.4) norms.push_back(norm);
  EXPECT_EQ(find_endless_descent(record_of_descent(norms)), "");
  for (double norm = 50; norm < 1e10; norm *= 1.4) norms.push_back(norm);
  EXPECT_NE(find_endless_descent(record_of_descent(norms)), "");
}

// Steps far too long for a stiff energy, whose shorter ones rounding drowns: the one difference
// quotient that can be told says nothing of the slope.
TEST(SignTest, RoundingIsNotTakenForAForeignObjective) {
  Plain host(Objective::energy);
  host.chain.energy_unit = 1e5;
  const std::vector<double> start = convex_start(host.chain);
  double slope = 0;
  for (const double g : host.chain.gradient(start)) slope += g * g;
  const double noise = 1e3 * 8 * PETSC_MACHINE_EPSILON;  // of the size of the energy
  host.chain.constant = 1e-2 * slope / noise / host.chain.energy_unit;
  host.option("snes_trefoil_proxy", "identity");
  host.option("snes_linesearch_max_it", "3");
  const CaughtError error;
  EXPECT_EQ(host.solve(start), PETSC_SUCCESS) << error.sentence;
  EXPECT_EQ(host.reason, SNES_DIVERGED_LINE_SEARCH) << host.record.at("result").at("reason");
}

/// sum of sqrt(1 + x_i^2): Hessians that are but a diagonal, and Newton steps from 2 that go to -8.
struct Loose {
  bool spoil = false;  ///< the residual, not the energy, beyond -1

  static double energy_of(double x) { return std::sqrt(1 + x * x); }
  static PetscErrorCode energy(SNES, Vec x, PetscReal *value, void *) {
    std::vector<double> v;
    PetscFunctionBeginUser;
    PetscCall(whole(x, &v));
    *value = 0;
    for (const double each : v) *value += energy_of(each);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  static PetscErrorCode residual(SNES, Vec x, Vec f, void *ctx) {
    std::vector<double> v;
    PetscFunctionBeginUser;
    PetscCall(whole(x, &v));
    for (double &each : v) {
      if (each < -1 && static_cast<Loose *>(ctx)->spoil)
        each = std::numeric_limits<double>::quiet_NaN();
      each /= energy_of(each);
    }
    PetscCall(fill(f, v));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  static PetscErrorCode jacobian(SNES, Vec x, Mat, Mat H, void *) {
    std::vector<double> v;
    PetscInt begin = 0, end = 0;
    PetscFunctionBeginUser;
    PetscCall(whole(x, &v));
    PetscCall(MatZeroEntries(H));
    PetscCall(MatGetOwnershipRange(H, &begin, &end));
    for (PetscInt i = begin; i + 1 < end; i += 2) {
      const PetscInt index[] = {i, i + 1};
      const double one = std::pow(energy_of(v[static_cast<std::size_t>(i)]), -3),
                   other = std::pow(energy_of(v[static_cast<std::size_t>(i + 1)]), -3);
      const PetscScalar block[] = {one, 0, 0, other};
      PetscCall(MatSetValues(H, 2, index, 2, index, block, ADD_VALUES));
    }
    PetscCall(finish_assembly(H));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  /// From 2 in every unknown; the record.
  PetscErrorCode solve(bool with_objective, nlohmann::json *record, double *farthest) {
    SNES snes = nullptr;
    Mat H = nullptr;
    Vec x = nullptr;
    PC pc = nullptr;
    KSP ksp = nullptr;
    const char *text = nullptr;
    PetscFunctionBeginUser;
    PetscCall(TrefoilInitializePackage());
    PetscCall(MatCreateAIJ(PETSC_COMM_WORLD, 4, 4, PETSC_DETERMINE, PETSC_DETERMINE, 2, nullptr, 0,
                           nullptr, &H));
    PetscCall(MatCreateVecs(H, &x, nullptr));
    PetscCall(VecSet(x, 2));
    PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
    PetscCall(SNESSetType(snes, SNESTREFOIL));
    if (with_objective) PetscCall(SNESSetObjective(snes, energy, this));
    PetscCall(SNESSetFunction(snes, nullptr, residual, this));
    PetscCall(SNESSetJacobian(snes, H, H, jacobian, this));
    PetscCall(SNESGetKSP(snes, &ksp));
    PetscCall(KSPSetType(ksp, KSPPREONLY));
    PetscCall(KSPGetPC(ksp, &pc));
    PetscCall(PCSetType(pc, PCJACOBI));
    PetscCall(SNESSetFromOptions(snes));
    PetscCall(SNESSolve(snes, nullptr, x));
    PetscCall(TrefoilSNESGetRecord(snes, &text));
    *record = nlohmann::json::parse(text);
    PetscCall(VecNorm(x, NORM_INFINITY, farthest));
    PetscCall(SNESDestroy(&snes));
    PetscCall(MatDestroy(&H));
    PetscCall(VecDestroy(&x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};

TEST(IsolatedTest, AnUnknownThatHangsOnNoneIsNoBoundaryValue) {
  for (const bool with_objective : {true, false}) {
    Loose host;
    nlohmann::json record;
    double farthest = 0;
    ASSERT_EQ(host.solve(with_objective, &record, &farthest), PETSC_SUCCESS);
    EXPECT_TRUE(record.at("result").at("converged"));
    EXPECT_LT(farthest, 1e-4);
    EXPECT_LT(record.at("history")[0].at("step"), 1);  // the full step rises
    EXPECT_FALSE(record.at("history")[0].at("rho").is_null());
  }
}

TEST(NotFiniteResidualTest, IsNoPlaceToGoThoughTheEnergyIsFinite) {
  Loose host;
  host.spoil = true;
  nlohmann::json record;
  double farthest = 0;
  ASSERT_EQ(host.solve(true, &record, &farthest), PETSC_SUCCESS);
  EXPECT_TRUE(record.at("result").at("converged")) << record.at("result").at("reason");
  EXPECT_LT(farthest, 1e-4);
}

}  // namespace
}  // namespace trefoil::test
