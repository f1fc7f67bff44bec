// What the plugin says of a solve: the JSON record, the weight and the trust-region ratio, against
// what the callbacks saw. Needs petsc_main.cpp.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

namespace fs = std::filesystem;

/// A solve from a concave start with the options given.
void run(Host &host, const std::vector<std::pair<const char *, const char *>> &options = {}) {
  for (const auto &[name, value] : options) host.option(name, value);
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  ASSERT_TRUE(host.record.is_object()) << host.text_of_record;
}

// The contract of design.md; scripts read these names. What the plugin cannot know is null or 0.
TEST(RecordTest, HasEveryKeyOfTheContract) {
  const std::vector<std::pair<const char *, std::vector<const char *>>> keys{
      {"mesh", {"vertices", "elements", "element", "dofs", "free_dofs", "inverted_at_start"}},
      {"solver", {"filter", "ranks", "options"}},
      {"result",
       {"converged", "reason", "iterations", "linear_solves", "line_search_trials", "energy_start",
        "energy", "energy_rest", "energy_scale", "gradient_norm", "newton_decrement", "inverted"}},
      {"time",
       {"total", "read", "setup", "assembly", "filter", "linear_solve", "line_search", "output",
        "other"}},
      {"memory", {"peak_bytes", "mesh_bytes", "matrix_bytes", "factor_bytes"}}};
  Host host;
  run(host);
  EXPECT_EQ(host.record.at("schema"), 1);
  for (const auto &[section, names] : keys)
    for (const char *name : names)
      EXPECT_TRUE(host.record.at(section).contains(name)) << section << '.' << name;
  for (const auto &entry : host.history())
    for (const char *name : {"k", "energy", "weight", "rho", "step", "trials", "decrement",
                             "indefinite", "linear_iterations", "linear_solves", "seconds"})
      EXPECT_TRUE(entry.contains(name)) << "history." << name;
}

// The record of an objective that leaves a constant out is that of the objective with it.
TEST(RecordTest, AnEnergyOffsetIsAddedToEveryEnergyAndChangesNothingElse) {
  constexpr double constant = 4096;
  Host whole, relative("relative_");
  whole.chain.constant = constant;
  run(whole);
  ASSERT_EQ(relative.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(TrefoilSNESSetEnergyOffset(relative.snes, constant * relative.chain.energy_unit), 0);
  ASSERT_EQ(relative.solve(concave_start(relative.chain)), PETSC_SUCCESS);
  for (const char *key : {"energy_start", "energy"})
    EXPECT_NEAR(relative.record.at("result").at(key), whole.record.at("result").at(key), 1e-9);
  ASSERT_EQ(relative.history().size(), whole.history().size());
  for (std::size_t k = 0; k < whole.history().size(); ++k) {
    EXPECT_NEAR(relative.history()[k].at("energy"), whole.history()[k].at("energy"), 1e-9);
    EXPECT_EQ(relative.history()[k].at("weight"), whole.history()[k].at("weight"));
  }
  const QuietErrors quiet;
  EXPECT_NE(TrefoilSNESSetEnergyOffset(relative.snes, std::nan("")), 0);
}

TEST(RecordTest, OptionsAreWhatTheUserGave) {
  const char *turned = "4, -z - y, y -z", *empty = "";
  PetscBool used = PETSC_TRUE;
  Host host;
  host.option("used", turned);
  host.option("without_value", empty);
  host.option("unused", turned);
  ASSERT_EQ(PetscOptionsHasName(nullptr, nullptr, "-chain_used", &used), PETSC_SUCCESS);
  run(host, {{"snes_trefoil_filter", "clamp"}});
  const auto &options = host.record.at("solver").at("options");
  EXPECT_EQ(options.value("chain_used", ""), turned);
  EXPECT_EQ(options.value("chain_unused", ""), turned);
  EXPECT_EQ(options.value("chain_without_value", "none"), empty);
  EXPECT_EQ(options.value("chain_snes_trefoil_filter", ""), "clamp");
  for (const auto &[name, value] : options.items()) EXPECT_EQ(name.find_first_of(" ,-"), name.npos);
  ASSERT_EQ(PetscOptionsUsed(nullptr, "chain_unused", &used), PETSC_SUCCESS);
  EXPECT_FALSE(used);  // nor does the record make it look used
}

class FilterTest : public testing::TestWithParam<const char *> {};
INSTANTIATE_TEST_SUITE_P(Filters, FilterTest, testing::Values("adaptive", "clamp", "absolute"),
                         [](const auto &each) { return std::string(each.param); });

TEST_P(FilterTest, CountsAgreeWithTheCallbacks) {
  Host host;
  run(host, {{"snes_trefoil_filter", GetParam()}});
  const auto &result = host.record.at("result");
  const auto &history = host.history();
  EXPECT_EQ(result.at("converged"), true);
  EXPECT_EQ(host.record.at("solver").at("filter"), GetParam());
  EXPECT_EQ(host.record.at("solver").at("options").at("chain_snes_trefoil_filter"), GetParam());
  const auto directions = host.chain.calls.size();
  EXPECT_EQ(result.at("iterations"), directions);
  EXPECT_EQ(result.at("linear_solves"), host.linear_solves.size());
  ASSERT_EQ(history.size(), directions);
  EXPECT_EQ(history.back().at("step"), 0);
  EXPECT_EQ(history.back().at("trials"), 0);
  EXPECT_TRUE(history.back().at("rho").is_null());
  int trials = 0;
  double seconds = 0;
  for (std::size_t k = 0; k < history.size(); ++k) {
    EXPECT_EQ(history[k].at("k"), k);
    EXPECT_EQ(history[k].at("linear_solves"), k + 1);  // this search makes no corrections
    trials += history[k].at("trials").get<int>();
    const JacobianCall &call = host.chain.calls[k];
    EXPECT_NEAR(history[k].at("energy"), host.chain.energy(call.x), 1e-14) << k;
    EXPECT_DOUBLE_EQ(history[k].at("indefinite"),
                     call.indefinite / (2.0 * static_cast<double>(host.chain.vertices)));
    EXPECT_GE(history[k].at("seconds"), seconds);
    seconds = history[k].at("seconds");
  }
  EXPECT_EQ(result.at("line_search_trials"), trials);
  EXPECT_EQ(host.chain.energies, 1 + trials);  // that of the start, and no point twice
  EXPECT_EQ(result.at("energy_start"), history.front().at("energy"));
  EXPECT_EQ(result.at("energy"), history.back().at("energy"));
  EXPECT_EQ(result.at("newton_decrement"), history.back().at("decrement"));
  EXPECT_NEAR(result.at("gradient_norm"), host.gradient_norm(), 1e-14);
  expect_descent(host);

  const auto &time = host.record.at("time");
  double sum = 0;
  for (const auto &[phase, value] : time.items())
    if (phase != "total") sum += value.get<double>();
  EXPECT_NEAR(sum, time.at("total"), 1e-12 + 1e-9 * sum);
}

// Rank 0 is slow in the line search, rank 1 in the residual: each waits for the other in its own
// phase, so the phases' maxima over the ranks are more than the total.
TEST(RecordTest, RanksThatWaitDoNotMakeATimeNegative) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks == 1) GTEST_SKIP() << "nobody to wait for";
  Host host;
  host.chain.disturb_energy = [=](int, double energy) {
    if (rank == 0) usleep(4000);
    return energy;
  };
  host.chain.spoil_residual = [=](int) {
    if (rank == 1) usleep(4000);
    return false;
  };
  run(host);
  for (const auto &[phase, value] : host.record.at("time").items())
    EXPECT_GE(value.get<double>(), 0) << phase;
}

// H + 2 w N, entry by entry: w is the recorded one, and an N that was left alone is not added.
TEST_P(FilterTest, TheLinearSolverGetsTheRecordedWeight) {
  Host host;
  run(host, {{"snes_trefoil_filter", GetParam()}});
  ASSERT_EQ(host.linear_solves.size(), host.chain.calls.size());
  ASSERT_EQ(host.history().size(), host.chain.calls.size());
  bool stale_negative_part = false;
  for (std::size_t k = 0; k < host.linear_solves.size(); ++k) {
    const JacobianCall &call = host.chain.calls[k];
    const double weight = host.history()[k].at("weight");
    EXPECT_EQ(host.linear_solves[k].weight, weight);
    stale_negative_part = stale_negative_part || (call.existed && call.indefinite == 0);
    for (std::size_t i = 0; i < call.hessian.size(); ++i)
      EXPECT_NEAR(host.linear_solves[k].matrix[i], call.hessian[i] + 2 * weight * call.negative[i],
                  1e-13)
          << k;
  }
  EXPECT_TRUE(stale_negative_part);
  EXPECT_FALSE(host.chain.calls[0].existed);
  EXPECT_TRUE(host.chain.calls[0].answered && host.chain.calls[1].existed);
}

// rho = (f(x) - f(x+u)) / -(g'u + u'Hu/2), from what the callbacks saw.
TEST_P(FilterTest, RhoIsThatOfTheUnfilteredModel) {
  Host host;
  run(host, {{"snes_trefoil_filter", GetParam()}});
  const auto n = static_cast<std::size_t>(host.chain.vertices);
  int compared = 0;
  for (std::size_t k = 0; k + 1 < host.chain.calls.size(); ++k) {
    const JacobianCall &call = host.chain.calls[k];
    const std::vector<double> &next = host.chain.calls[k + 1].x;
    const std::vector<double> g = host.chain.gradient(call.x);
    double predicted = 0;
    for (std::size_t i = 0; i < n; ++i) {
      predicted -= g[i] * (next[i] - call.x[i]);
      for (std::size_t j = 0; j < n; ++j)
        predicted -= 0.5 * call.hessian[n * i + j] * (next[i] - call.x[i]) * (next[j] - call.x[j]);
    }
    const double energy = host.chain.energy(call.x);
    if (std::abs(predicted) < 1e-6 * energy) continue;  // rounding of the energies would decide
    const double rho = (energy - host.chain.energy(next)) / predicted;
    EXPECT_NEAR(host.history()[k].at("rho"), rho, 1e-8 * std::max(1.0, std::abs(rho))) << k;
    ++compared;
  }
  EXPECT_GE(compared, 3);
  PetscReal last = 0;
  ASSERT_EQ(TrefoilSNESGetTrustRegionRatio(host.snes, &last), PETSC_SUCCESS);
  EXPECT_EQ(last, host.history()[host.history().size() - 2].at("rho").get<double>());
}

TEST(RecordTest, AdaptiveWeightsFollowTheRecordedRatios) {
  Host host;
  run(host, {{"snes_trefoil_filter", "adaptive"}, {"snes_trefoil_rho_tolerance", "0.2"}});
  EXPECT_EQ(host.history()[0].at("weight"), 1);
  int clamped = 0;
  for (std::size_t k = 1; k < host.history().size(); ++k) {
    const bool good = std::abs(host.history()[k - 1].at("rho").get<double>() - 1) < 0.2;
    EXPECT_EQ(host.history()[k].at("weight"), good ? 0.5 : 1.0) << k;
    clamped += good;
  }
  EXPECT_GT(clamped, 0);
}

TEST(RecordTest, EnergyScaleIsThatOfTheFinalState) {
  for (const auto &[option, value] : {std::pair{"snes_trefoil_energy_tolerance", "1e-8"},
                                      {"snes_trefoil_decrement_tolerance", "1e-5"},
                                      {"snes_max_it", "3"}}) {
    Host host;
    run(host, {{option, value}});
    const auto &scale = host.record.at("result").at("energy_scale");
    EXPECT_TRUE(scale.is_number()) << option;
    if (scale.is_number()) {
      EXPECT_NEAR(scale, host.chain.energy(host.solution), 1e-13) << option;
    }
  }
}

TEST(NegativePartTest, IsNotMadeWhereNothingIsIndefinite) {
  Host host;
  host.option("snes_trefoil_filter", "absolute");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(convex_start(host.chain)), PETSC_SUCCESS);
  EXPECT_GT(host.reason, 0);
  EXPECT_GE(host.chain.calls.size(), 3u);
  for (const JacobianCall &call : host.chain.calls) {
    EXPECT_TRUE(call.asked);
    EXPECT_FALSE(call.existed || call.answered);
    EXPECT_EQ(call.indefinite, 0);
  }
  for (const auto &entry : host.history()) EXPECT_EQ(entry.at("indefinite"), 0);
}

class RecordFileTest : public testing::Test {
 protected:
  void SetUp() override {
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank_);
    std::string name = testing::TempDir() + "/trefoil_record_XXXXXX";
    if (rank_ == 0 && mkdtemp(name.data()) == nullptr) ADD_FAILURE() << "cannot make " << name;
    MPI_Bcast(name.data(), static_cast<int>(name.size()), MPI_CHAR, 0, PETSC_COMM_WORLD);
    directory_ = name;
  }
  void TearDown() override {
    MPI_Barrier(PETSC_COMM_WORLD);
    if (rank_ == 0) fs::remove_all(directory_);
  }
  int rank_ = 0;
  fs::path directory_;
};

TEST_F(RecordFileTest, HoldsTheRecord) {
  const fs::path path = directory_ / "record.json";
  // A solve that does not converge is recorded as well.
  for (const char *iterations : {"200", "2"}) {
    Host host;
    run(host, {{"snes_trefoil_record", path.c_str()}, {"snes_max_it", iterations}});
    MPI_Barrier(PETSC_COMM_WORLD);
    std::ifstream stream(path);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    if (rank_ == 0) {
      EXPECT_EQ(text, host.text_of_record + "\n");
    }
    EXPECT_EQ(nlohmann::json::parse(text).at("result"), host.record.at("result"));
    EXPECT_EQ(host.record.at("result").at("converged"), host.reason > 0);
    EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);  // nothing half-written
    MPI_Barrier(PETSC_COMM_WORLD);
  }
}

TEST_F(RecordFileTest, APathThatCannotBeWrittenIsAnErrorBeforeTheSolve) {
  for (const fs::path &path : {directory_ / "nowhere" / "record.json", directory_}) {
    Host host;
    host.option("snes_trefoil_record", path);
    const QuietErrors quiet;
    EXPECT_EQ(host.set_up(), PETSC_ERR_FILE_OPEN);  // on every rank
    EXPECT_TRUE(fs::is_empty(directory_));
    MPI_Barrier(PETSC_COMM_WORLD);
  }
}

}  // namespace
}  // namespace trefoil::test
