// Every rule against hand-made sequences of iterations.

#include "rule/rule.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace trefoil {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double clamp = 0.5, absolute = 1;

/// The record of a step whose energy came out as rho times what the model predicted.
IterationRecord step_with(double rho, int k = 0) {
  IterationRecord record;
  record.k = k;
  record.energy = 1.5;
  record.gradient_norm = 0.25;
  record.weight = absolute;
  record.rho = rho;
  record.step = 0.8;
  record.trials = 2;
  record.decrement = 0.125;
  return record;
}

/// The weights of a whole solve whose steps have these ratios.
std::vector<double> weights_of_a_solve(Rule &rule, const std::vector<double> &ratios) {
  std::vector<double> weights{rule.first()};
  for (const double rho : ratios)
    weights.push_back(rule.next(step_with(rho, static_cast<int>(weights.size()) - 1)));
  return weights;
}

const std::vector<double> all_ratios{1,   1.001, 0.999,        2,        0.5,       0,  -3,
                                     1e9, -1e9,  not_a_number, infinity, -infinity, 1.0};

class RuleTest : public testing::TestWithParam<std::string> {};

TEST_P(RuleTest, GivesFiniteWeightsWhateverHappens) {
  const auto rule = make_rule(GetParam(), {});
  ASSERT_NE(rule, nullptr);
  for (const double weight : weights_of_a_solve(*rule, all_ratios)) {
    EXPECT_TRUE(std::isfinite(weight));
    EXPECT_GE(weight, 0);
  }
}

TEST_P(RuleTest, ForgetsTheLastSolve) {
  const auto rule = make_rule(GetParam(), {});
  const std::vector<double> before = weights_of_a_solve(*rule, all_ratios);
  weights_of_a_solve(*rule, {0.3, not_a_number, 5});
  EXPECT_EQ(weights_of_a_solve(*rule, all_ratios), before);
  EXPECT_EQ(weights_of_a_solve(*make_rule(GetParam(), {}), all_ratios), before);
}

TEST_P(RuleTest, TwoOfAKindDoNotShareAMemory) {
  const auto one = make_rule(GetParam(), {}), other = make_rule(GetParam(), {});
  const double start = one->first();
  weights_of_a_solve(*other, {0.3, 7, not_a_number});
  EXPECT_EQ(one->next(step_with(1)), weights_of_a_solve(*make_rule(GetParam(), {}), {1})[1]);
  EXPECT_EQ(one->first(), start);
}

INSTANTIATE_TEST_SUITE_P(Registry, RuleTest, testing::ValuesIn(rule_names()),
                         [](const auto &each) { return each.param; });

TEST(RuleRegistryTest, KnowsTheRulesOfTheContractOnce) {
  const std::vector<std::string> listed = rule_names();
  const std::set<std::string> names(listed.begin(), listed.end());
  EXPECT_EQ(names.size(), listed.size());
  for (const char *name : {"newton", "clamp", "absolute", "adaptive", "constant", "on_demand",
                           "blend", "three_state", "newton_first", "multiplicative", "tikhonov"})
    EXPECT_EQ(names.count(name), 1u) << name;
}

TEST(RuleRegistryTest, UnknownNamesGiveNothing) {
  for (const char *name : {"", "Adaptive", "adaptive ", "adapt", "adaptiv\xc3\xa9", "0.5"})
    EXPECT_EQ(make_rule(name, {}), nullptr) << name;
}

TEST(FixedRuleTest, NewtonClampAndAbsoluteNeverChange) {
  for (const auto &[name, weight] : {std::pair{"newton", 0.0}, {"clamp", 0.5}, {"absolute", 1.0}})
    for (const double other : {0.25, 3.0})  // no parameter touches them
      EXPECT_EQ(weights_of_a_solve(*make_rule(name, {other, other}), all_ratios),
                std::vector<double>(all_ratios.size() + 1, weight))
          << name;
}

TEST(ConstantRuleTest, KeepsItsOwnWeight) {
  for (const double weight : {0.0, 0.125, 0.5, 1.0, 2.75})
    EXPECT_EQ(weights_of_a_solve(*make_rule("constant", {0.01, weight}), all_ratios),
              std::vector<double>(all_ratios.size() + 1, weight));
}

TEST(AdaptiveRuleTest, StartsAbsoluteAndClampsWhereTheModelWasGood) {
  const auto rule = make_rule("adaptive", {});
  EXPECT_EQ(weights_of_a_solve(*rule, {1, 0.5, 1.005, 0.995, 1.02, 0.98, 0, -1, 1}),
            (std::vector<double>{absolute, clamp, absolute, clamp, clamp, absolute, absolute,
                                 absolute, absolute, clamp}));
}

TEST(AdaptiveRuleTest, NoRatioIsNoEvidence) {
  const auto rule = make_rule("adaptive", {});
  EXPECT_EQ(weights_of_a_solve(*rule, {not_a_number, infinity, -infinity}),
            std::vector<double>(4, absolute));
}

TEST(AdaptiveRuleTest, LooksAtTheLastStepOnly) {
  const auto rule = make_rule("adaptive", {});
  weights_of_a_solve(*rule, std::vector<double>(50, 3.0));
  EXPECT_EQ(rule->next(step_with(1)), clamp);
  weights_of_a_solve(*rule, std::vector<double>(50, 1.0));
  EXPECT_EQ(rule->next(step_with(3)), absolute);
}

class AdaptiveToleranceTest : public testing::TestWithParam<double> {};

// Powers of two, with which 1 +- tolerance and its distance from 1 are exact.
TEST_P(AdaptiveToleranceTest, TheBoundaryItselfIsOutside) {
  const double tolerance = GetParam();
  const auto rule = make_rule("adaptive", {tolerance, 1});
  for (const double side : {-1.0, 1.0}) {
    const double boundary = 1 + side * tolerance;
    EXPECT_EQ(rule->next(step_with(boundary)), absolute);
    EXPECT_EQ(rule->next(step_with(std::nextafter(boundary, 1.0))), clamp);
    EXPECT_EQ(rule->next(step_with(std::nextafter(boundary, 9 * side))), absolute);
  }
}

INSTANTIATE_TEST_SUITE_P(Tolerances, AdaptiveToleranceTest,
                         testing::Values(0.0078125, 0.125, 0.25, 0.5));

TEST(AdaptiveRuleTest, ToleranceZeroIsAlwaysAbsolute) {
  const auto rule = make_rule("adaptive", {0, 1});
  EXPECT_EQ(weights_of_a_solve(*rule, {1, 1, 1}), std::vector<double>(4, absolute));
}

/// The record of an iteration whose Jacobian turned out to be indefinite.
IterationRecord refused_with(double weight, double decrement = 1) {
  IterationRecord record;
  record.weight = weight;
  record.decrement = decrement;
  return record;
}

TEST_P(RuleTest, ADefiniteWeightIsNeverReplaced) {
  const auto rule = make_rule(GetParam(), {});
  rule->first();
  for (const double weight : {0.5, 1.0, 3.0}) {
    EXPECT_FALSE(rule->rejected(refused_with(weight)).has_value());
  }
  if (!rule->may_be_rejected()) {
    EXPECT_FALSE(rule->rejected(refused_with(0)).has_value());
  }
}

TEST_P(RuleTest, RejectionsComeToAnEndAtClampAtMost) {
  const auto rule = make_rule(GetParam(), {});
  if (!rule->may_be_rejected()) GTEST_SKIP() << "never rejected";
  rule->first();
  rule->next(step_with(1));
  double weight = 0.125;
  for (int tries = 0; weight < clamp; ++tries) {
    ASSERT_LT(tries, 10);
    const auto other = rule->rejected(refused_with(weight));
    ASSERT_TRUE(other.has_value());
    EXPECT_GT(*other, weight);
    weight = *other;
  }
  EXPECT_EQ(weight, clamp);
}

TEST(OnDemandRuleTest, TriesNewtonAndThenClamps) {
  const auto rule = make_rule("on_demand", {});
  EXPECT_EQ(weights_of_a_solve(*rule, {1, 0.2, not_a_number}), std::vector<double>(4, 0.0));
  EXPECT_EQ(rule->rejected(refused_with(0)), clamp);
}

TEST(TikhonovRuleTest, IsAbsoluteWithAFloor) {
  const auto rule = make_rule("tikhonov", {});
  EXPECT_EQ(weights_of_a_solve(*rule, all_ratios),
            std::vector<double>(all_ratios.size() + 1, absolute));
  EXPECT_EQ(rule->floor(), 1e-3);
  for (const std::string &name : rule_names()) {
    if (name == "tikhonov") continue;
    EXPECT_EQ(make_rule(name, {})->floor(), 0) << name;
  }
}

TEST(BlendRuleTest, GoesFromClampToAbsolute) {
  const auto rule = make_rule("blend", {0.25, 1});
  EXPECT_EQ(weights_of_a_solve(*rule, {1, 1.25, 0.75, 1.75, not_a_number}),
            (std::vector<double>{1, 0.5, 0.75, 0.75, 0.875, 1}));
  EXPECT_EQ(make_rule("blend", {0, 1})->next(step_with(1)), 0.5);  // 0/0 of the formula
}

IterationRecord trusted_with(double weight, double decrement) {
  IterationRecord record = step_with(1);
  record.weight = weight;
  record.decrement = decrement;
  return record;
}

TEST(ThreeStateRuleTest, DropsTheFilterAfterAGoodClampedStep) {
  const auto rule = make_rule("three_state", {});
  EXPECT_EQ(rule->first(), absolute);
  EXPECT_EQ(rule->next(trusted_with(absolute, 1)), clamp);
  EXPECT_EQ(rule->next(trusted_with(clamp, 1)), 0);
  EXPECT_EQ(rule->next(trusted_with(0, 1)), 0);
  EXPECT_EQ(rule->next(step_with(2)), absolute);
}

TEST(ThreeStateRuleTest, IsPatientAfterARejection) {
  const auto rule = make_rule("three_state", {});
  rule->first();
  EXPECT_EQ(rule->rejected(refused_with(0, 1.0)), clamp);
  EXPECT_EQ(rule->next(trusted_with(clamp, 0.5)), clamp);
  EXPECT_EQ(rule->next(trusted_with(clamp, 0.02)), clamp);
  EXPECT_EQ(rule->next(trusted_with(clamp, 0.005)), 0);
}

TEST(ThreeStateRuleTest, ForgetsARejectionOfTheLastSolve) {
  const auto rule = make_rule("three_state", {});
  rule->first();
  EXPECT_EQ(rule->rejected(refused_with(0, 1e-6)), clamp);
  EXPECT_EQ(rule->next(trusted_with(clamp, 1)), clamp);
  rule->first();
  EXPECT_EQ(rule->next(trusted_with(clamp, 1)), 0);
}

TEST(ThreeStateRuleTest, GoesOnAfterARejectionThatAnotherHasSeen) {
  const auto before = make_rule("three_state", {}), after = make_rule("three_state", {});
  before->first();
  after->first();
  EXPECT_EQ(before->rejected(refused_with(0, 1.0)), clamp);
  after->set_refused_decrement(before->refused_decrement());
  EXPECT_EQ(after->next(trusted_with(clamp, 0.02)), clamp);
  EXPECT_EQ(after->next(trusted_with(clamp, 0.005)), 0);
}

IterationRecord step_of(double rho, double weight, double decrement) {
  IterationRecord record = trusted_with(weight, decrement);
  record.rho = rho;
  return record;
}

TEST(NewtonFirstRuleTest, TriesNewtonAfterAGoodModelAndIsAdaptiveElsewhere) {
  const auto rule = make_rule("newton_first", {});
  EXPECT_EQ(rule->first(), absolute);
  for (const double weight : {0.0, 0.125, clamp, absolute}) {
    for (const double good : {0.76, 0.999, 1.0, 1.24})
      EXPECT_EQ(rule->next(step_of(good, weight, 1)), 0) << good;
    for (const double bad : {-1.0, 0.74, 1.26, infinity})
      EXPECT_EQ(rule->next(step_of(bad, weight, 1)), absolute) << bad;
    // A step that met boundary values says nothing against the model.
    EXPECT_EQ(rule->next(step_of(not_a_number, weight, 1)), 0);
  }
}

TEST(NewtonFirstRuleTest, TriesSmallWeightsAndThenWhatTheAdaptiveRuleTakes) {
  const auto rule = make_rule("newton_first", {});
  for (const auto &[rho, filtered] : {std::pair(1.001, clamp), std::pair(1.1, absolute)}) {
    rule->first();
    EXPECT_EQ(rule->next(step_of(rho, clamp, 1)), 0);
    EXPECT_EQ(rule->rejected(refused_with(0)), 1. / 32);
    EXPECT_EQ(rule->rejected(refused_with(1. / 32)), 1. / 8);
    EXPECT_EQ(rule->rejected(refused_with(1. / 8)), filtered);
    EXPECT_EQ(rule->rejected(refused_with(filtered)), std::nullopt);
  }
}

TEST(NewtonFirstRuleTest, LowersTheWeightUntilNewtonsTurnComesAgain) {
  const auto rule = make_rule("newton_first", {});
  rule->first();
  EXPECT_EQ(rule->next(step_of(1, absolute, 1)), 0);
  // Where factors refuse it no direction is known, and no decrement.
  EXPECT_EQ(rule->rejected(refused_with(0, not_a_number)), 1. / 32);
  EXPECT_EQ(rule->next(step_of(1, absolute, 0.9)), 1. / 4);
  EXPECT_EQ(rule->next(step_of(1, clamp, 0.8)), 1. / 8);
  EXPECT_EQ(rule->next(step_of(1, 1. / 8, 0.7)), 1. / 32);
  EXPECT_EQ(rule->next(step_of(1, 1. / 32, 0.11)), 1. / 32);
  EXPECT_EQ(rule->next(step_of(1, 4, 0.11)), clamp);  // a quarter of it is no small weight
  EXPECT_EQ(rule->next(step_of(1, 1. / 32, 0.09)), 0);
  EXPECT_EQ(rule->next(step_of(1, 0, 0.08)), 0);  // once taken, it is taken as long as it is good
  EXPECT_EQ(rule->next(step_of(1, absolute, 0.5)), 0);
}

TEST(NewtonFirstRuleTest, TriesNewtonAfterAStepWithoutARatioWhateverWasRefused) {
  const auto rule = make_rule("newton_first", {});
  rule->first();
  EXPECT_EQ(rule->next(step_of(1, absolute, 1)), 0);
  EXPECT_EQ(rule->rejected(refused_with(0)), 1. / 32);
  EXPECT_EQ(rule->next(step_of(not_a_number, absolute, 0.9)), 0);
}

TEST(NewtonFirstRuleTest, ForgetsARejectionOfTheLastSolve) {
  const auto rule = make_rule("newton_first", {});
  rule->first();
  EXPECT_EQ(rule->next(step_of(1, absolute, 1e-6)), 0);
  rule->rejected(refused_with(0));
  EXPECT_EQ(rule->next(step_of(1, absolute, 1)), 1. / 4);
  rule->first();
  EXPECT_EQ(rule->next(step_of(1, absolute, 1)), 0);
}

TEST(MultiplicativeRuleTest, HalvesAndDoublesWithinItsBounds) {
  const auto rule = make_rule("multiplicative", {});
  double weight = rule->first();
  EXPECT_EQ(weight, 1);
  for (const double expected : {0.5, 0.25, 0.125, 0.125}) {
    EXPECT_EQ(weight = rule->next(trusted_with(weight, 1)), expected);
  }
  for (const double expected : {0.25, 0.5, 1., 2., 4., 4.}) {
    IterationRecord poor = step_with(2);
    poor.weight = weight;
    EXPECT_EQ(weight = rule->next(poor), expected);
  }
}

}  // namespace
}  // namespace trefoil
