// Rigid motions fitted to places: every screw is found, and of several the one that turns least.
// Needs petsc_main.cpp.

#include "scene/rigid_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using Vector = std::array<double, 3>;

class RigidMotionTest : public testing::Test {
 protected:
  /// Random places; `directions` of the axes they spread along.
  std::vector<double> places(int count, int directions) {
    std::vector<double> from;
    for (int p = 0; p < count; ++p) {
      Vector place{1, -2, 3};
      for (int d = 0; d < directions; ++d) place[static_cast<std::size_t>(d)] += uniform_(random_);
      for (const double component : place) from.push_back(component);
    }
    return from;
  }
  RigidMotion fit(const std::vector<double> &from, const std::vector<double> &to) {
    RigidMotion motion;
    EXPECT_EQ(fit_rigid_motion(PETSC_COMM_WORLD, from, to, &motion, &deviation_), PETSC_SUCCESS);
    return motion;
  }
  static std::vector<double> moved(const std::vector<double> &from, const RigidMotion &motion,
                                   double t = 1) {
    std::vector<double> to;
    for (std::size_t k = 0; k < from.size(); k += 3) {
      const Vector place = motion.move(&from[k], t);
      to.insert(to.end(), place.begin(), place.end());
    }
    return to;
  }
  static double distance(const std::vector<double> &a, const std::vector<double> &b) {
    double most = 0;
    for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
    return most;
  }
  RigidMotion random_screw(double angle) {
    RigidMotion motion;
    const Vector d{uniform_(random_), uniform_(random_), uniform_(random_)};
    const double length = std::hypot(d[0], d[1], d[2]), way = uniform_(random_);
    motion.axis = {d[0] / length, d[1] / length, d[2] / length};
    motion.point = {uniform_(random_), uniform_(random_), uniform_(random_)};
    motion.angle = angle;
    for (std::size_t i = 0; i < 3; ++i) motion.slide[i] = way * motion.axis[i];
    return motion;
  }

  std::mt19937 random_{7};
  std::uniform_real_distribution<double> uniform_{-1, 1};
  double deviation_ = 0;
};

/// The way there too is the screw's: about the same axis, in proportion.
TEST_F(RigidMotionTest, FindsEveryScrew) {
  for (const double angle : {1e-6, 0.01, 0.5, 1.5, 3., std::numbers::pi}) {
    for (const int directions : {2, 3}) {
      const RigidMotion given = random_screw(angle);
      const std::vector<double> from = places(20, directions);
      const RigidMotion found = fit(from, moved(from, given));
      EXPECT_LT(deviation_, 1e-9 / std::min(1., angle)) << angle;
      EXPECT_NEAR(found.angle, angle, 1e-7);
      if (angle == std::numbers::pi) continue;  // half a turn may go either way round
      EXPECT_LT(distance(moved(from, given, 0.3), moved(from, found, 0.3)), 1e-8) << angle;
    }
  }
}

TEST_F(RigidMotionTest, HalfATurnStaysRigidOnTheWay) {
  const std::vector<double> from = places(20, 2);
  const RigidMotion found = fit(from, moved(from, random_screw(std::numbers::pi)));
  const std::vector<double> half = moved(from, found, 0.5);
  for (std::size_t k = 3; k < from.size(); k += 3) {
    const auto length = [&](const std::vector<double> &at) {
      return std::hypot(at[k] - at[0], at[k + 1] - at[1], at[k + 2] - at[2]);
    };
    EXPECT_NEAR(length(half), length(from), 1e-12);
  }
}

TEST_F(RigidMotionTest, ATranslationGoesStraight) {
  const std::vector<double> from = places(20, 3);
  RigidMotion given;
  given.slide = {1, 2, 3};
  const RigidMotion found = fit(from, moved(from, given));
  EXPECT_EQ(found.angle, 0);
  EXPECT_LT(distance(moved(from, found, 0.5), moved(from, given, 0.5)), 1e-14);
}

/// Places on a line, and one place: they turn no more than they must.
TEST_F(RigidMotionTest, OfSeveralMotionsTheLeastTurn) {
  const std::vector<double> line = places(5, 1), point = places(1, 0);
  RigidMotion given;
  given.axis = {0, 0, 1};
  given.angle = 0.7;
  given.slide = {0, 0, 2};
  EXPECT_NEAR(fit(line, moved(line, given)).angle, 0.7, 1e-9);
  EXPECT_LT(deviation_, 1e-12);
  given.axis = {1, 0, 0};  // about the line itself
  given.slide = {};
  EXPECT_LT(fit(line, moved(line, given)).angle, 1e-7);
  EXPECT_LT(deviation_, 1e-12);
  EXPECT_EQ(fit(point, moved(point, given)).angle, 0);
  EXPECT_LT(deviation_, 1e-12);
}

TEST_F(RigidMotionTest, WhatIsNotRigidDeviates) {
  const std::vector<double> from = places(20, 3);
  std::vector<double> stretched = from, mirrored = from;
  for (std::size_t k = 0; k < from.size(); k += 3) stretched[k] *= 1.01, mirrored[k] *= -1;
  fit(from, stretched);
  EXPECT_GT(deviation_, 1e-4);
  fit(from, mirrored);
  EXPECT_GT(deviation_, 0.1);
}

/// The places of all ranks count, also where some have none.
TEST_F(RigidMotionTest, RanksTogether) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const std::vector<double> all = places(4, 3);
  const RigidMotion given = random_screw(1);
  std::vector<double> mine;
  if (ranks == 1) mine = all;
  if (ranks > 1 && rank < 2) mine.assign(all.begin() + 6 * rank, all.begin() + 6 * rank + 6);
  const RigidMotion found = fit(mine, moved(mine, given));
  EXPECT_NEAR(found.angle, 1, 1e-12);
  EXPECT_LT(deviation_, 1e-12);
}

}  // namespace
}  // namespace trefoil
