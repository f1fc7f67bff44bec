// Physical groups of Gmsh files: which cell is in which, and what they are called.

#include <gtest/gtest.h>

#include "mesh/check_mesh.hpp"
#include "mesh_writers.hpp"

namespace trefoil::testing {
namespace {

using Groups = std::vector<PetscInt>;
using Names = std::map<std::string, PetscInt>;

const std::string nodes_2_2 = "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n";
const std::string two_cells_2_2 =
    "$Elements\n3\n1 2 2 7 1 1 2 3\n2 4 2 3 9 1 2 3 4\n3 4 3 8 9 1 2 3 4 5\n$EndElements\n";
const std::string names =
    "$PhysicalNames\n3\n2 7 \"skin\"\n3 3 \"soft tissue\"\n3 8 \"bone\"\n$EndPhysicalNames\n";

TEST(MeshGroups, OfVersion22) {
  const CellList mesh =
      read_contents("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + names + nodes_2_2 + two_cells_2_2);
  EXPECT_EQ(mesh.groups, (Groups{3, 8}));
  // A surface's name is no name of cells.
  EXPECT_EQ(mesh.group_names, (Names{{"soft tissue", 3}, {"bone", 8}}));
}

TEST(MeshGroups, NoneWhereNoCellHasOne) {
  const std::string cells = "$Elements\n1\n2 4 2 0 9 1 2 3 4\n$EndElements\n";
  const CellList mesh = read_contents("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + nodes_2_2 + cells);
  EXPECT_TRUE(mesh.groups.empty());
  EXPECT_TRUE(mesh.group_names.empty());
}

/// Two volumes of entity tags 5 and 6 after a point, a curve and a surface; the second volume has
/// two groups, of which the first counts, and is turned round in it.
std::string entities_4_1(Encoding encoding) {
  Bytes bytes(encoding);
  bytes.text("$Entities\n").size(1).size(1).size(1).size(2).end_line();
  bytes.integer(1).real(0).real(0).real(0).size(0).end_line();
  const auto entity = [&](int tag, std::vector<int> groups, std::vector<int> bounds) {
    bytes.integer(tag);
    for (int k = 0; k < 6; ++k) bytes.real(k);
    bytes.size(static_cast<std::int64_t>(groups.size()));
    for (const int group : groups) bytes.integer(group);
    bytes.size(static_cast<std::int64_t>(bounds.size()));
    for (const int bound : bounds) bytes.integer(bound);
    bytes.end_line();
  };
  entity(1, {}, {1, -1});
  entity(5, {7}, {1});
  entity(5, {3}, {5});
  entity(6, {-8, 3}, {5});
  return bytes.text("\n$EndEntities\n").str();
}

std::string two_volumes_4_1(Encoding encoding) {
  const auto [mesh, tags] = two_tetrahedra();
  Bytes bytes(encoding);
  bytes.text("$MeshFormat\n4.1 " + std::string(encoding == Encoding::binary ? "1" : "0") + " 8\n");
  if (encoding == Encoding::binary) bytes.integer(1).text("\n");
  bytes.text("$EndMeshFormat\n" + names + entities_4_1(encoding));
  bytes.text("$Nodes\n").size(1).size(5).size(1).size(5).end_line();
  bytes.integer(3).integer(5).integer(0).size(5).end_line();
  for (const std::int64_t tag : tags) bytes.size(tag).end_line();
  for (const double coordinate : mesh.coordinates) bytes.real(coordinate);
  bytes.text("\n$EndNodes\n$Elements\n").size(2).size(2).size(1).size(2).end_line();
  for (int cell = 0; cell < 2; ++cell) {
    bytes.integer(3).integer(6 - cell).integer(4).size(1).end_line().size(cell + 1);
    for (std::size_t k = 0; k < 4; ++k)
      bytes.size(mesh.cells[4 * static_cast<std::size_t>(cell) + k] + 1);
    bytes.end_line();
  }
  return bytes.text("\n$EndElements\n").str();
}

TEST(MeshGroups, OfVersion41) {
  for (const Encoding encoding : {Encoding::ascii, Encoding::binary}) {
    const CellList mesh = read_contents(two_volumes_4_1(encoding));
    EXPECT_EQ(mesh.groups, (Groups{8, 3}));
    EXPECT_EQ(mesh.group_names, (Names{{"soft tissue", 3}, {"bone", 8}}));
  }
}

TEST(MeshGroups, GoWithTheirCellsWhereOthersAreDropped) {
  CellList mesh;
  mesh.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  mesh.cells = {0, 1, 1, 2, 0, 1, 2, 3, 0, 2, 1, 3, 1, 2, 0, 3};
  mesh.groups = {4, 5, 6, 7};
  EXPECT_EQ(repair_rest_shape(mesh, Repair::drop, "four"), 2);
  EXPECT_EQ(mesh.groups, (Groups{5, 7}));
}

TEST(MeshGroups, BadSectionsAreRefused) {
  const std::string head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n";
  EXPECT_NE(refusal(head + "1\n3 1 body\n$EndPhysicalNames\n").find("quotation"),
            std::string::npos);
  EXPECT_NE(refusal(head + "1\n4 1 \"body\"\n$EndPhysicalNames\n").find("dimension 4"),
            std::string::npos);
  EXPECT_NE(refusal(head + "1000000000\n3 1 \"body\"\n").find("physical names"), std::string::npos);
  EXPECT_NE(refusal("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 9999999\n"), "");
}

}  // namespace
}  // namespace trefoil::testing
