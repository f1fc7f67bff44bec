// Surfaces of obstacles, from .obj and from both kinds of .stl.

#include "mesh/io/surface_file.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

#include "trefoil/input_error.hpp"

namespace trefoil::test {
namespace {

const char *const triangle_pair =
    "solid two\n facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n vertex 0 1 0\n"
    " endloop\n endfacet\n facet normal 0 0 1\n outer loop\n vertex 1 0 0\n vertex 1 1 0\n"
    " vertex 0 1 0\n endloop\n endfacet\nendsolid two\n";

TEST(SurfaceFile, ObjHasPolygonsSegmentsAndNumbersFromBehind) {
  const SurfaceMesh surface = parse_obj("a.obj",
                                        "# a comment\no thing\nv 0 0 0\nv 1 0 0\nvn 0 0 1\n"
                                        "v 1 1 0\nv 0 1 0\nf 1/1/1 2/2/1 3/3/1 4\nf -1 -2 -3\n"
                                        "l 1 2 3\n");
  ASSERT_EQ(surface.points.size(), 4U);
  EXPECT_EQ(surface.points[2], (std::array<double, 3>{1, 1, 0}));
  const std::vector<std::array<int, 3>> facets{
      {0, 1, 2}, {0, 2, 3}, {3, 2, 1}, {0, 1, -1}, {1, 2, -1}};
  EXPECT_EQ(surface.facets, facets);
}

TEST(SurfaceFile, TextStlJoinsCorners) {
  const SurfaceMesh surface = parse_stl("a.stl", triangle_pair);
  EXPECT_EQ(surface.points.size(), 4U);
  const std::vector<std::array<int, 3>> facets{{0, 1, 2}, {1, 3, 2}};
  EXPECT_EQ(surface.facets, facets);
}

TEST(SurfaceFile, BinaryStlIsTheSame) {
  const float corners[2][9] = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {1, 0, 0, 1, 1, 0, 0, 1, 0}};
  std::string text(84 + 2 * 50, '\0');
  const std::uint32_t count = 2;
  std::memcpy(text.data() + 80, &count, 4);
  for (int k = 0; k < 2; ++k) std::memcpy(text.data() + 84 + 50 * k + 12, corners[k], 36);
  const SurfaceMesh binary = parse_stl("b.stl", text), other = parse_stl("a.stl", triangle_pair);
  EXPECT_EQ(binary.points, other.points);
  EXPECT_EQ(binary.facets, other.facets);
}

TEST(SurfaceFile, WhatIsNoneIsRefused) {
  EXPECT_THROW(parse_obj("a.obj", "v 0 0 0\nf 1 2 3\n"), InputError);
  EXPECT_THROW(parse_obj("a.obj", "v 0 0\n"), InputError);
  EXPECT_THROW(parse_obj("a.obj", "v 0 0 0\n"), InputError);
  EXPECT_THROW(parse_obj("a.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), InputError);
  EXPECT_THROW(parse_stl("a.stl", "plastic"), InputError);
  EXPECT_THROW(parse_stl("a.stl", "solid a\nvertex 0 0 0\nendsolid\n"), InputError);
  EXPECT_THROW(parse_stl("a.stl", ""), InputError);
}

/// What a surface's file is refused for; nothing where it is not.
std::string complaint_about_stl(const std::string &text) {
  try {
    parse_stl("a.stl", text);
  } catch (const InputError &error) {
    return error.what();
  }
  return {};
}

TEST(SurfaceFile, AnStlThatIsCutShortIsRefused) {
  const std::string whole = triangle_pair;
  const auto between = whole.find(" facet", whole.find("endfacet"));
  EXPECT_EQ(complaint_about_stl(whole.substr(0, between)),
            "'a.stl' is cut short: it has no `endsolid` at its end");
  EXPECT_EQ(complaint_about_stl(whole + whole), "");
  EXPECT_EQ(complaint_about_stl(whole + whole.substr(0, between)),
            "'a.stl' is cut short: it has no `endsolid` at its end");

  std::string binary = "solid of numbers";
  binary.resize(84 + 2 * 50);
  binary[80] = 3;
  EXPECT_EQ(complaint_about_stl(binary),
            "'a.stl' is cut short: it announces 3 triangles and has room for 2");
  binary[0] = 'x';
  EXPECT_EQ(complaint_about_stl(binary),
            "'a.stl' is cut short: it announces 3 triangles and has room for 2");
}

}  // namespace
}  // namespace trefoil::test
