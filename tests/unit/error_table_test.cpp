// The table of iterations and seconds against the error, from histories made by hand.

#include "output/error_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace trefoil {
namespace {

using Json = nlohmann::ordered_json;

/// A run whose relative errors before its steps are these, the last one being the final state's:
/// energy = offset + scale error, one linear solve and two seconds a direction.
Json run_with(const std::vector<double> &errors, double decrement, double offset = 0,
              double scale = 4) {
  Json history = Json::array();
  for (std::size_t k = 0; k < errors.size(); ++k)
    history.push_back({{"k", k},
                       {"energy", offset + scale * errors[k]},
                       {"linear_solves", k + 1},
                       {"seconds", 2.0 * static_cast<double>(k + 1)}});
  return {{"result",
           {{"converged", true},
            {"iterations", errors.size()},
            {"energy", offset + scale * errors.back()},
            {"energy_scale", scale},
            {"newton_decrement", decrement * scale},
            {"guess_linear_solves", 0}}},
          {"history", history}};
}

std::vector<int> column(const Json &table, const char *key) {
  std::vector<int> values;
  for (const Json &level : table) values.push_back(level.at(key).get<int>());
  return values;
}

const std::vector<double> by_tens{1,      0.09,   0.9e-2, 0.9e-3, 0.9e-4,
                                  0.9e-5, 0.9e-6, 0.9e-7, 0.9e-8, 0};

TEST(ErrorTableTest, CountsTheDirectionThatOnlySatisfiesAStopTest) {
  const Json table = error_table(run_with(by_tens, 1e-14));
  ASSERT_EQ(table.size(), 8u);
  EXPECT_EQ(column(table, "iterations"), (std::vector<int>{2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(column(table, "linear_solves"), (std::vector<int>{2, 3, 4, 5, 6, 7, 8, 9}));
  for (std::size_t i = 0; i < table.size(); ++i) {
    EXPECT_DOUBLE_EQ(table[i].at("relative_error"), std::pow(10.0, -1.0 - static_cast<double>(i)));
    EXPECT_EQ(table[i].at("seconds"), 2.0 * static_cast<double>(i + 2));
  }
}

TEST(ErrorTableTest, TheGuessIsPaidFor) {
  Json run = run_with(by_tens, 1e-14);
  run["result"]["guess_linear_solves"] = 21;
  EXPECT_EQ(column(error_table(run), "linear_solves").front(), 23);
}

TEST(ErrorTableTest, AFastStepReachesSeveralErrorsAtOnce) {
  const Json table = error_table(run_with({0.05, 1e-6, 0}, 1e-12));
  EXPECT_EQ(column(table, "iterations"), (std::vector<int>{1, 2, 2, 2, 2, 2, 3, 3}));
}

TEST(ErrorTableTest, TheLastStateMayHaveNoDirectionOfItsOwn) {
  Json run = run_with({1, 0.05, 0}, 1e-12);
  run["result"]["iterations"] = 2;
  EXPECT_EQ(column(error_table(run), "iterations"), (std::vector<int>{2, 2, 2, 2, 2, 2, 2, 2}));
}

TEST(ErrorTableTest, OnlyTheLastLoadStepIsNearTheEndAndAllAreCounted) {
  // In the first step, of three directions and a last state without one, energies are lower.
  Json run = run_with({-1, -2, -3, -4, 1, 0.05, 1e-6, 0}, 1e-12);
  for (std::size_t k = 0; k < 8; ++k) run["history"][k]["load_step"] = k < 4 ? 1 : 2;
  run["result"]["iterations"] = 7;
  run["result"]["load_step_iterations"] = {3, 4};
  const Json table = error_table(run);
  EXPECT_EQ(column(table, "iterations"), (std::vector<int>{5, 6, 6, 6, 6, 6, 7, 7}));
  EXPECT_EQ(column(table, "linear_solves"), (std::vector<int>{6, 7, 7, 7, 7, 7, 8, 8}));
  EXPECT_EQ(table.front().at("seconds"), 12);
}

TEST(ErrorTableTest, OnlyErrorsThatTheLastDecrementSupports) {
  for (const auto &[decrement, levels] :
       {std::pair{1e-9, 8u}, {1.1e-9, 7u}, {1e-8, 7u}, {9e-5, 3u}, {1e-2, 1u}, {0.02, 0u}})
    EXPECT_EQ(error_table(run_with(by_tens, decrement)).size(), levels) << decrement;
}

TEST(ErrorTableTest, OnlyErrorsThatRoundingLeaves) {
  // 4e8 in doubles is exact to 9e-8, which is 2.2e-8 of the scale.
  EXPECT_EQ(error_table(run_with(by_tens, 1e-14, 4e8)).size(), 6u);
}

TEST(ErrorTableTest, EnergiesMayBeNegative) {
  const Json table = error_table(run_with(by_tens, 1e-14, -100));
  EXPECT_EQ(column(table, "iterations"), (std::vector<int>{2, 3, 4, 5, 6, 7, 8, 9}));
}

TEST(ErrorTableTest, ARunThatKnowsNotWhereItEndedHasNone) {
  Json run = run_with(by_tens, 1e-14);
  run["result"]["converged"] = false;
  EXPECT_TRUE(error_table(run).empty());
  for (const char *key : {"energy", "energy_scale", "newton_decrement"}) {
    run = run_with(by_tens, 1e-14);
    run["result"][key] = nullptr;
    EXPECT_TRUE(error_table(run).empty()) << key;
  }
  EXPECT_TRUE(error_table(run_with(by_tens, 1e-14, 0, 0)).empty());
}

TEST(ErrorTableTest, EnergiesThatAreNotFiniteAreNotClose) {
  Json run = run_with({1, 0.05, 0}, 1e-12);
  run["history"][0]["energy"] = nullptr;
  EXPECT_EQ(column(error_table(run), "iterations").front(), 2);
}

TEST(ErrorTableTest, PrintsAColumnALevel) {
  const std::string text = text_of_error_table(error_table(run_with({1, 0.05, 0}, 9e-4)));
  EXPECT_EQ(text,
            "to relative energy error    1e-01   1e-02\n"
            "  iterations                    2       3\n"
            "  linear solves                 2       3\n"
            "  seconds                       4       6\n");
  EXPECT_EQ(text_of_error_table(Json::array()), "");
}

}  // namespace
}  // namespace trefoil
