// Axes of vertices that slide: orthonormal, with the displacements that the constraints give.

#include "scene/vertex_axes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace trefoil {
namespace {

using Axis = std::array<double, 3>;

double dot(const Axis &a, const Axis &b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Axis unit(double x, double y, double z) {
  const double length = std::hypot(x, y, z);
  return {x / length, y / length, z / length};
}

/// One vertex, of which some components are held by a constraint each.
struct OneVertex {
  explicit OneVertex(std::vector<char> which, std::vector<double> values)
      : held{std::move(which), std::move(values)} {
    for (int i = 0; i < 3; ++i) holder.push_back(held.held[static_cast<std::size_t>(i)] ? i : -1);
  }
  Direction slide(const Axis &normal, int constraint = 7) {
    if (held.turned.empty()) held.turned.push_back(begin_turned(held, 0, holder));
    return add_direction(normal, 0, constraint, &held.turned[0]);
  }
  void settle(int dimension) { settle_turned(dimension, &held, &holder); }

  HeldDofs held;
  std::vector<int> holder;
};

TEST(VertexAxes, AreOrthonormalAndKeepWhatIsPrescribed) {
  OneVertex one({1, 0, 0}, {.25, 0, 0});
  const Axis normal = unit(1, 2, 3);
  EXPECT_EQ(one.slide(normal), Direction::another);
  one.settle(3);
  ASSERT_EQ(one.held.turned.size(), 1u);
  const TurnedVertex &turned = one.held.turned[0];
  EXPECT_EQ(turned.held, 2);
  Axis u{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t l = 0; l < 3; ++l) {
      EXPECT_NEAR(dot(turned.axes[k], turned.axes[l]), k == l, 1e-15);
    }
    for (std::size_t i = 0; i < 3; ++i) u[i] += turned.values[k] * turned.axes[k][i];
  }
  EXPECT_NEAR(u[0], .25, 1e-15);
  EXPECT_NEAR(dot(u, normal), 0, 1e-15);
  for (const char held : one.held.held) EXPECT_FALSE(held);
}

TEST(VertexAxes, TellWhatOneMoreDirectionIs) {
  OneVertex one({0, 0, 0}, {0, 0, 0});
  EXPECT_EQ(one.slide(unit(1, 1, 0)), Direction::another);
  EXPECT_EQ(one.slide(unit(1, 1, 1e-9)), Direction::known);
  EXPECT_EQ(one.slide(unit(1, 1, 1e-4)), Direction::nearly_known);
  OneVertex moved({1, 0, 0}, {.25, 0, 0});
  EXPECT_EQ(moved.slide({1, 0, 0}), Direction::contradicts);
  OneVertex still({1, 0, 0}, {0, 0, 0});
  EXPECT_EQ(still.slide({1, 0, 0}), Direction::known);
}

TEST(VertexAxes, AlongThoseOfSpaceHoldComponents) {
  OneVertex one({0, 0, 1}, {0, 0, .5});
  EXPECT_EQ(one.slide({0, -1, 0}, 7), Direction::another);
  one.settle(3);
  EXPECT_TRUE(one.held.turned.empty());
  EXPECT_EQ(one.held.held, (std::vector<char>{0, 1, 1}));
  EXPECT_EQ(one.held.value, (std::vector<double>{0, 0, .5}));
  EXPECT_EQ(one.holder, (std::vector<int>{-1, 7, 2}));
}

TEST(VertexAxes, InThePlaneTheLastLeadsOutOfIt) {
  OneVertex one({0, 0, 1}, {0, 0, 0});
  one.holder[2] = -1;  // plane strain is nobody's constraint
  EXPECT_EQ(one.slide(unit(1, 1, 0)), Direction::another);
  one.settle(2);
  ASSERT_EQ(one.held.turned.size(), 1u);
  EXPECT_EQ(std::abs(one.held.turned[0].axes[2][2]), 1);
  EXPECT_EQ(one.held.turned[0].axes[1][2], 0);
}

}  // namespace
}  // namespace trefoil
