// The table of cell shapes: whatever a row says twice, in two ways, agrees.

#include "mesh/cell_shape.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

namespace trefoil {
namespace {

/// Corners of the edge that a midpoint belongs to, ascending.
std::pair<int, int> ends_of(const CellShape &shape, int midpoint) {
  const auto &edge = shape.edges[static_cast<std::size_t>(midpoint - shape.corners)];
  return std::minmax(edge[0], edge[1]);
}

class CellShapeTest : public testing::TestWithParam<const CellShape *> {
 protected:
  const CellShape &shape_ = *GetParam();
};

TEST_P(CellShapeTest, NodesAreCornersAndMidpoints) {
  const auto midpoints = is_quadratic(shape_) ? static_cast<int>(shape_.edges.size()) : 0;
  EXPECT_EQ(shape_.nodes, shape_.corners + midpoints);
  EXPECT_LE(shape_.nodes, CellShape::most_nodes);
  for (const CellShape *other : {shape_.linear, shape_.quadratic}) {
    EXPECT_EQ(other->dimension, shape_.dimension);
    EXPECT_EQ(other->corners, shape_.corners);
    EXPECT_EQ(other->edges.data(), shape_.edges.data());
  }
  EXPECT_EQ(shape_.linear->order, 1);
  EXPECT_EQ(shape_.quadratic->order, 2);
  std::set<std::pair<int, int>> edges;
  for (const auto &edge : shape_.edges) edges.insert(std::minmax(edge[0], edge[1]));
  EXPECT_EQ(edges.size(), shape_.edges.size());
}

TEST_P(CellShapeTest, FacetsCloseTheCellAndFaceOutward) {
  const CellShape &facet = *shape_.facet;
  EXPECT_EQ(facet.dimension, shape_.dimension - 1);
  EXPECT_EQ(facet.order, shape_.order);
  EXPECT_LE(facet.nodes, CellShape::most_facet_nodes);
  EXPECT_LE(facet.corners, CellShape::most_facet_corners);
  std::map<std::pair<int, int>, int> walked;  // how often along an edge, less how often back
  for (const auto &node : shape_.facets) {
    for (int c = 0; c < facet.corners; ++c)
      EXPECT_LT(node[static_cast<std::size_t>(c)], shape_.corners);
    for (std::size_t e = 0; e < facet.edges.size(); ++e) {
      const int from = node[static_cast<std::size_t>(facet.edges[e][0])];
      const int to = node[static_cast<std::size_t>(facet.edges[e][1])];
      walked[std::minmax(from, to)] += from < to ? 1 : -1;
      if (!is_quadratic(shape_)) continue;
      const int midpoint = node[static_cast<std::size_t>(facet.corners) + e];
      EXPECT_EQ(ends_of(shape_, midpoint), (std::pair<int, int>(std::minmax(from, to))));
    }
  }
  EXPECT_EQ(walked.size(), shape_.edges.size());
  if (shape_.dimension < 3) return;
  for (const auto &[edge, balance] : walked) EXPECT_EQ(balance, 0) << edge.first << edge.second;
}

/// The corners that a frame names are joined by edges, and in the cell turned round by the same.
TEST_P(CellShapeTest, TurningRoundIsAMirror) {
  const auto image = [&](int node) {
    const auto at = std::find(shape_.mirrored.begin(), shape_.mirrored.end(), node);
    return static_cast<int>(at - shape_.mirrored.begin());
  };
  ASSERT_EQ(shape_.mirrored.size(), static_cast<std::size_t>(shape_.nodes));
  for (int node = 0; node < shape_.nodes; ++node) {
    EXPECT_EQ(image(image(node)), node);
    if (node < shape_.corners) {
      EXPECT_LT(image(node), shape_.corners);
    } else {
      const auto [from, to] = ends_of(shape_, node);
      const std::pair<int, int> expected(std::minmax(image(from), image(to)));
      EXPECT_EQ(ends_of(shape_, image(node)), expected);
    }
  }
  int moved = 0;
  for (int corner = 0; corner < shape_.corners; ++corner) moved += image(corner) != corner;
  EXPECT_EQ(moved % 4, 2) << "one exchange, not two";
}

TEST_P(CellShapeTest, OrdersOfOtherFormatsArePermutations) {
  std::set<int> places(shape_.gmsh_order.begin(), shape_.gmsh_order.end());
  EXPECT_EQ(shape_.gmsh_order.size(), static_cast<std::size_t>(shape_.nodes));
  EXPECT_EQ(*places.begin(), 0);
  EXPECT_EQ(*places.rbegin(), shape_.nodes - 1);
  EXPECT_EQ(places.size(), shape_.gmsh_order.size());
}

INSTANTIATE_TEST_SUITE_P(Rows, CellShapeTest,
                         testing::ValuesIn(mesh_shapes().begin(), mesh_shapes().end()),
                         [](const auto &each) { return std::string(each.param->name); });

TEST(CellShape, Counts) {
  EXPECT_EQ(counted(1, shapes::tet10), "1 tetrahedron");
  EXPECT_EQ(counted(0, shapes::tri3), "0 triangles");
}

}  // namespace
}  // namespace trefoil
