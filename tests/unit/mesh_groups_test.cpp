// Physical groups of Gmsh files and references of Medit files: what is in which, and what they are
// called.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "mesh/check_mesh.hpp"
#include "mesh/repeated.hpp"
#include "mesh_writers.hpp"

namespace trefoil::testing {
namespace {

/// The numbers of a cell's groups, or of an entity's of lower dimension; ascending.
std::vector<PetscInt> numbers_of_set(const Groups &groups, PetscInt set) {
  std::vector<PetscInt> numbers;
  for (const int group : groups.sets()[static_cast<std::size_t>(set)])
    numbers.push_back(groups.list()[static_cast<std::size_t>(group)].number);
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

using Numbers = std::vector<std::vector<PetscInt>>;

Numbers groups_of_cells(const CellList &mesh) {
  Numbers all;
  for (const PetscInt set : mesh.groups.set_of_cell)
    all.push_back(numbers_of_set(mesh.groups, set));
  return all;
}

/// Vertices of the entities of a dimension, then their groups.
std::map<std::vector<PetscInt>, std::vector<PetscInt>> entities(const CellList &mesh,
                                                                std::size_t dimension) {
  std::map<std::vector<PetscInt>, std::vector<PetscInt>> found;
  const GroupedEntities &below = mesh.groups.below[dimension];
  for (std::size_t e = 0; e < below.size(); ++e) {
    const auto first = below.vertices.begin() + static_cast<std::ptrdiff_t>((dimension + 1) * e);
    std::vector<PetscInt> vertices(first, first + static_cast<std::ptrdiff_t>(dimension) + 1);
    std::sort(vertices.begin(), vertices.end());
    EXPECT_TRUE(found.emplace(vertices, numbers_of_set(mesh.groups, below.sets[e])).second);
  }
  return found;
}

std::vector<std::string> texts(const Groups &groups) {
  std::vector<std::string> all;
  for (const Group &group : groups.list()) all.push_back(text_of(group));
  std::sort(all.begin(), all.end());
  return all;
}

using Texts = std::vector<std::string>;
using Entities = std::map<std::vector<PetscInt>, std::vector<PetscInt>>;

const std::string nodes_2_2 = "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n";
const std::string two_cells_2_2 =
    "$Elements\n3\n1 2 2 7 1 1 2 3\n2 4 2 3 9 1 2 3 4\n3 4 3 8 9 1 2 3 4 5\n$EndElements\n";

TEST(MeshGroups, OfVersion22) {
  const CellList mesh = read_contents("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + physical_names +
                                      nodes_2_2 + two_cells_2_2);
  EXPECT_EQ(groups_of_cells(mesh), (Numbers{{3}, {8}}));
  EXPECT_EQ(texts(mesh.groups),
            (Texts{"surface 7 'skin'", "volume 3 'soft tissue'", "volume 8 'bone'"}));
  EXPECT_EQ(entities(mesh, 2), (Entities{{{0, 1, 2}, {7}}}));
}

TEST(MeshGroups, OfVersion22InBinary) {
  for (const Encoding encoding : {Encoding::ascii, Encoding::binary}) {
    const CellList mesh = read_contents(gmsh_2_2(two_tetrahedra(), encoding));
    EXPECT_EQ(groups_of_cells(mesh), (Numbers{{7}, {7}}));
    EXPECT_EQ(entities(mesh, 2), (Entities{{{0, 1, 2}, {7}}}));
  }
}

TEST(MeshGroups, NoneWhereNoCellHasOne) {
  const std::string cells = "$Elements\n1\n2 4 2 0 9 1 2 3 4\n$EndElements\n";
  const CellList mesh = read_contents("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + nodes_2_2 + cells);
  EXPECT_TRUE(mesh.groups.set_of_cell.empty());
  EXPECT_TRUE(mesh.groups.list().empty());
}

TEST(MeshGroups, OfVersion41) {
  for (const Encoding encoding : {Encoding::ascii, Encoding::binary}) {
    const CellList mesh = read_contents(two_volumes_4_1(encoding));
    EXPECT_EQ(groups_of_cells(mesh), (Numbers{{3, 8}, {3}}));
    EXPECT_EQ(texts(mesh.groups), (Texts{"curve 6", "curve 9", "point 4", "surface 7 'skin'",
                                         "volume 3 'soft tissue'", "volume 8 'bone'"}));
    EXPECT_EQ(entities(mesh, 0), (Entities{{{0}, {4}}}));
    EXPECT_EQ(entities(mesh, 1), (Entities{{{0, 1}, {6, 9}}, {{1, 2}, {6, 9}}}));
    EXPECT_EQ(entities(mesh, 2), (Entities{{{0, 1, 2}, {7}}}));
  }
}

TEST(MeshGroups, OfPartitionedFiles) {
  for (const Encoding encoding : {Encoding::ascii, Encoding::binary}) {
    const CellList mesh = read_contents(partitioned_4_1(encoding));
    EXPECT_EQ(groups_of_cells(mesh), (Numbers{{3}, {3, 8}}));
    EXPECT_TRUE(entities(mesh, 2).empty());
  }
}

/// Points, curves and surfaces of several groups, an element for each of them.
TEST(MeshGroups, BelowTheCellsInVersion22) {
  const std::string cells =
      "$Elements\n8\n1 15 2 4 1 2\n2 1 2 5 1 2 3\n3 2 2 7 1 1 2 3\n4 2 2 -9 1 3 2 1\n"
      "5 1 2 5 1 3 4\n6 2 2 0 1 1 2 4\n7 15 2 0 1 3\n8 4 2 3 9 1 2 3 4\n$EndElements\n";
  CellList mesh =
      read_contents("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + physical_names + nodes_2_2 + cells);
  EXPECT_EQ(take_once(mesh, "one"), 0);
  EXPECT_EQ(entities(mesh, 0), (Entities{{{1}, {4}}}));
  EXPECT_EQ(entities(mesh, 1), (Entities{{{1, 2}, {5}}, {{2, 3}, {5}}}));
  EXPECT_EQ(entities(mesh, 2), (Entities{{{0, 1, 2}, {7, 9}}}));
}

TEST(MeshGroups, CellsOfSeveralGroupsAreTakenOnce) {
  const std::string cells =
      "$Elements\n5\n1 4 2 3 1 1 2 3 4\n2 4 2 3 1 2 4 3 5\n3 4 2 8 1 3 2 4 5\n"
      "4 4 2 8 1 2 3 1 4\n5 4 2 6 1 4 3 2 1\n$EndElements\n";
  CellList mesh = read_contents("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + nodes_2_2 + cells);
  EXPECT_EQ(take_once(mesh, "two"), 3);
  EXPECT_EQ(groups_of_cells(mesh), (Numbers{{3, 6, 8}, {3, 8}}));
  EXPECT_EQ(mesh.cells, (std::vector<PetscInt>{0, 1, 2, 3, 1, 3, 2, 4}));
  CellList plane;
  plane.shape = &shapes::tri3;
  plane.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  plane.cells = {0, 1, 2, 1, 3, 2, 2, 1, 0, 3, 2, 1};
  EXPECT_EQ(take_once(plane, "plane"), 2);
  EXPECT_TRUE(plane.groups.set_of_cell.empty());
  EXPECT_EQ(plane.cells, (std::vector<PetscInt>{0, 1, 2, 1, 3, 2}));
}

/// The same tetrahedron both ways round: one of them is wrong, and both are named.
TEST(MeshGroups, TwinsAreRefusedOrDropped) {
  CellList mesh = two_tetrahedra().mesh;
  mesh.cells = {0, 2, 1, 3, 0, 1, 2, 3};
  mesh.groups.set_of_cell = {mesh.groups.set_of(3, 4), mesh.groups.set_of(3, 5)};
  EXPECT_EQ(take_once(mesh, "twins"), 0);
  try {
    CellList refused = mesh;
    repair_rest_shape(refused, Repair::none, "twins");
    ADD_FAILURE() << "accepted";
  } catch (const InputError &error) {
    EXPECT_NE(std::string(error.what()).find("tetrahedron 2 is tetrahedron 1 turned round"),
              std::string::npos)
        << error.what();
  }
  EXPECT_EQ(repair_rest_shape(mesh, Repair::drop, "twins").dropped, 1);
  EXPECT_EQ(mesh.cells, (std::vector<PetscInt>{0, 1, 2, 3}));
  EXPECT_EQ(groups_of_cells(mesh), (Numbers{{4, 5}}));
}

TEST(MeshGroups, QuadraticCellsAreTakenOnceWhereTheirMidpointsAreTheSame) {
  CellList mesh;
  mesh.shape = &shapes::tri6;
  mesh.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, .5, 0, 0, .5, .5, 0, 0, .5, 0, .5, .1, 0};
  mesh.cells = {0, 1, 2, 3, 4, 5, 2, 1, 0, 4, 3, 5};
  EXPECT_EQ(take_once(mesh, "two"), 1);
  mesh.cells = {0, 1, 2, 3, 4, 5, 0, 1, 2, 6, 4, 5};
  EXPECT_THROW(take_once(mesh, "two"), InputError);
}

TEST(MeshGroups, ReferencesOfMedit) {
  const CellList mesh = read_contents(
      "MeshVersionFormatted 2\nDimension 3\nVertices 5\n0 0 0 6\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
      "1 1 1 0\nEdges 2\n1 2 0\n2 3 -4\nTriangles 2\n1 2 3 7\n2 3 4 0\n"
      "Tetrahedra 2\n1 2 3 4 0\n2 3 4 5 8\nEnd\n");
  EXPECT_EQ(groups_of_cells(mesh), (Numbers{{0}, {8}}));
  EXPECT_EQ(entities(mesh, 0), (Entities{{{0}, {6}}}));
  EXPECT_EQ(entities(mesh, 1), (Entities{{{1, 2}, {-4}}}));
  EXPECT_EQ(entities(mesh, 2), (Entities{{{0, 1, 2}, {7}}}));
  EXPECT_TRUE(read_contents(medit(two_tetrahedra().mesh)).groups.list().empty());
}

/// What a user may call a group, and what is said where there is none.
TEST(FindGroup, ByNameByNumberOrByKind) {
  Groups groups;
  groups.name(groups.add(3, 1), "body");
  groups.name(groups.add(2, 1), "wall");
  groups.name(groups.add(2, 7), "1");
  groups.add(1, 1);
  groups.add(0, 4);
  const auto find = [&](const std::string &text, std::vector<int> dimensions) {
    return text_of(groups.list()[static_cast<std::size_t>(
        find_group(groups, text, dimensions, "-load_x_group"))]);
  };
  EXPECT_EQ(find("wall", {2}), "surface 1 'wall'");
  EXPECT_EQ(find("1", {2, 1, 0}), "surface 7 '1'");  // names come first
  EXPECT_EQ(find("surface 1", {2}), "surface 1 'wall'");
  EXPECT_EQ(find("1", {3}), "volume 1 'body'");
  EXPECT_EQ(find("curve 1", {2, 1, 0}), "curve 1");
  EXPECT_EQ(find("4", {2, 1, 0}), "point 4");
  const auto refusal = [&](const std::string &text, std::vector<int> dimensions) -> std::string {
    try {
      return find(text, dimensions);
    } catch (const InputError &error) {
      return error.what();
    }
  };
  EXPECT_EQ(refusal("wal", {2, 1, 0}),
            "-load_x_group: the mesh has no group 'wal' that is a surface, curve or point; it has: "
            "surface 1 'wall', surface 7 '1', curve 1, point 4");
  EXPECT_EQ(refusal("body", {2}),
            "-load_x_group: 'body' is a group of volumes where a surface is wanted; the mesh has: "
            "surface 1 'wall', surface 7 '1'");
  EXPECT_EQ(find_group(groups, "7", std::vector<int>{2}, "-x"), 2);
  groups = {};
  EXPECT_EQ(refusal("body", {2}),
            "-load_x_group: the mesh has no group 'body' that is a surface; it names none");
}

TEST(MeshGroups, GoWithTheirCellsWhereOthersAreDropped) {
  CellList mesh;
  mesh.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  mesh.cells = {0, 1, 1, 2, 0, 1, 2, 3, 0, 2, 1, 3, 1, 2, 0, 3};
  for (const PetscInt number : {4, 5, 6, 7})
    mesh.groups.set_of_cell.push_back(mesh.groups.set_of(3, number));
  EXPECT_EQ(repair_rest_shape(mesh, Repair::drop, "four").dropped, 2);
  EXPECT_EQ(groups_of_cells(mesh), (Numbers{{5}, {7}}));
}

/// What is in groups is renumbered with its vertices, and goes where one of them goes.
TEST(MeshGroups, SurviveRepair) {
  CellList mesh;
  mesh.coordinates = {9, 9, 9, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 5, 5, 5};
  mesh.cells = {1, 2, 3, 4, 1, 2, 3, 5, 2, 3, 3, 4};
  std::swap(mesh.cells[4], mesh.cells[5]);  // the second is turned round, the third flat
  const PetscInt wall = mesh.groups.set_of(2, 7), tip = mesh.groups.set_of(0, 2);
  mesh.groups.below[2] = {{1, 2, 4, 1, 2, 5}, {wall, wall}};
  mesh.groups.below[0] = {{4, 5, 0}, {tip, tip, tip}};
  const RepairReport report = repair_rest_shape(mesh, Repair::drop, "three");
  EXPECT_EQ(report.dropped, 2);
  EXPECT_EQ(drop_unused_vertices(mesh), 2);
  EXPECT_EQ(entities(mesh, 2), (Entities{{{0, 1, 3}, {7}}}));
  EXPECT_EQ(entities(mesh, 0), (Entities{{{3}, {2}}}));
}

TEST(MeshGroups, BadSectionsAreRefused) {
  const std::string head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n";
  EXPECT_NE(refusal(head + "1\n3 1 body\n$EndPhysicalNames\n").find("quotation"),
            std::string::npos);
  EXPECT_NE(refusal(head + "1\n4 1 \"body\"\n$EndPhysicalNames\n").find("dimension 4"),
            std::string::npos);
  EXPECT_NE(refusal(head + "1000000000\n3 1 \"body\"\n").find("physical names"), std::string::npos);
  EXPECT_NE(refusal("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 9999999\n"), "");
  // The number furthest from zero has no opposite number.
  const std::string lowest = "-9223372036854775808";
  EXPECT_NE(refusal("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + nodes_2_2 + "$Elements\n1\n1 4 2 " +
                    lowest + " 9 1 2 3 4\n$EndElements\n")
                .find(lowest),
            std::string::npos);
}

}  // namespace
}  // namespace trefoil::testing
