// How a way is cut into load steps: equal ones, halved ones, ones that grow again.

#include "solve/step_sizes.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace trefoil {
namespace {

/// The times at which steps stand, where steps longer than `longest` fail.
std::vector<double> walk(StepSizes sizes, double longest, bool all_easy = true) {
  std::vector<double> times;
  while (!sizes.is_done()) {
    const double time = sizes.next();
    if (time - sizes.time() > longest) {
      if (!sizes.halve()) break;
    } else {
      sizes.accept(all_easy);
      times.push_back(time);
      EXPECT_EQ(sizes.time(), time);
    }
  }
  EXPECT_EQ(sizes.accepted(), static_cast<int>(times.size()));
  return times;
}

TEST(StepSizesTest, EqualStepsEndAtOneAndAreNeverHalved) {
  for (const int count : {1, 3, 7, 10}) {
    const std::vector<double> times = walk(StepSizes::equal(count), 2);
    ASSERT_EQ(times.size(), static_cast<std::size_t>(count));
    EXPECT_EQ(times.back(), 1);
    EXPECT_DOUBLE_EQ(times.front(), 1. / count);
  }
  EXPECT_TRUE(walk(StepSizes::equal(3), 0.1).empty());
}

TEST(StepSizesTest, GrowsWhereItIsEasy) {
  EXPECT_EQ(walk(StepSizes::adaptive(0.25, 0.01), 2), (std::vector<double>{0.25, 0.75, 1}));
  EXPECT_EQ(walk(StepSizes::adaptive(1, 0.01), 2), (std::vector<double>{1}));
  EXPECT_EQ(walk(StepSizes::adaptive(7, 0.01), 2), (std::vector<double>{1}));
}

TEST(StepSizesTest, KeepsItsLengthWhereItIsNot) {
  EXPECT_EQ(walk(StepSizes::adaptive(0.25, 0.01), 2, false),
            (std::vector<double>{0.25, 0.5, 0.75, 1}));
}

TEST(StepSizesTest, HalvesWhereItFails) {
  const std::vector<double> times = walk(StepSizes::adaptive(1, 0.01), 0.2);
  EXPECT_EQ(times.front(), 0.125);
  EXPECT_EQ(times.back(), 1);
  for (std::size_t k = 1; k < times.size(); ++k) EXPECT_LE(times[k] - times[k - 1], 0.2);
  // Each step is tried again at twice its length, but not right after it was halved.
  EXPECT_LE(times.size(), 9U);
}

TEST(StepSizesTest, GivesUpBelowTheLeastStep) {
  EXPECT_TRUE(walk(StepSizes::adaptive(1, 0.01), 0.001).empty());
  StepSizes sizes = StepSizes::adaptive(0.25, 0.2);
  EXPECT_FALSE(sizes.halve());
  EXPECT_EQ(sizes.time(), 0);
}

/// Thirds add up to one less a rounding: no fourth step.
TEST(StepSizesTest, NoStepOfRounding) {
  EXPECT_EQ(walk(StepSizes::adaptive(1. / 3, 0.01), 2, false).size(), 3U);
  EXPECT_EQ(walk(StepSizes::adaptive(0.1, 0.01), 2, false).size(), 10U);
}

}  // namespace
}  // namespace trefoil
