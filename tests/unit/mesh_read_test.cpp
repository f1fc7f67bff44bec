#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "mesh/io/foreign_format.hpp"
#include "mesh_writers.hpp"

namespace trefoil::testing {
namespace {

std::vector<std::string> sample_in_all_formats() {
  const TaggedMesh sample = two_tetrahedra();
  return {medit(sample.mesh), gmsh_2_2(sample, Encoding::ascii), gmsh_2_2(sample, Encoding::binary),
          gmsh_4_1(sample, Encoding::ascii), gmsh_4_1(sample, Encoding::binary)};
}

void expect_equal(const CellList &mesh, const CellList &expected) {
  EXPECT_EQ(mesh.dimension(), 3);
  EXPECT_EQ(mesh.nodes_per_cell(), 4);
  EXPECT_EQ(mesh.coordinates, expected.coordinates);
  EXPECT_EQ(mesh.cells, expected.cells);
}

// Whatever is read from damaged bytes may be wrong, but can be worked with.
bool is_usable(const CellList &mesh) {
  return mesh.vertices() > 0 && mesh.size() > 0 && mesh.coordinates.size() % 3 == 0 &&
         mesh.cells.size() % static_cast<std::size_t>(mesh.nodes_per_cell()) == 0 &&
         std::all_of(mesh.coordinates.begin(), mesh.coordinates.end(),
                     [](double coordinate) { return std::isfinite(coordinate); }) &&
         std::all_of(mesh.cells.begin(), mesh.cells.end(),
                     [&](PetscInt vertex) { return vertex >= 0 && vertex < mesh.vertices(); });
}

bool is_refused_or_usable(const std::string &contents) {
  try {
    return is_usable(read_contents(contents));
  } catch (const InputError &) {
    return true;
  }
}

std::string replaced(std::string contents, const std::string &old_part, const std::string &part) {
  const std::size_t position = contents.find(old_part);
  EXPECT_NE(position, std::string::npos) << old_part;
  return contents.replace(position, old_part.size(), part);
}

void expect_refused(const std::string &contents, const std::vector<std::string> &named) {
  const std::string sentence = refusal(contents);
  for (const std::string &part : named)
    EXPECT_NE(sentence.find(part), std::string::npos)
        << "'" << part << "' is missing in: " << sentence;
  EXPECT_NE(sentence.find("trefoil_mesh_test_"), std::string::npos) << "no file in: " << sentence;
}

const std::string medit_sample = medit(two_tetrahedra().mesh);
const std::string ascii_2_2 = gmsh_2_2(two_tetrahedra(), Encoding::ascii);
const std::string ascii_4_1 = gmsh_4_1(two_tetrahedra(), Encoding::ascii);

TEST(ReadMesh, AllFormatsGiveTheSameMesh) {
  for (const std::string &contents : sample_in_all_formats())
    expect_equal(read_contents(contents), two_tetrahedra().mesh);
}

TEST(ReadMesh, NodeTagsMayBeScatteredAndUnordered) {
  for (const auto &tags : std::vector<std::vector<std::int64_t>>{
           {5, 4, 3, 2, 1}, {100, 7, 60, 8, 9}, {2000000000, 3, 1000000, 77, 5}}) {
    const TaggedMesh sample = two_tetrahedra(tags);
    for (const Encoding encoding : {Encoding::ascii, Encoding::binary}) {
      expect_equal(read_contents(gmsh_2_2(sample, encoding)), sample.mesh);
      expect_equal(read_contents(gmsh_4_1(sample, encoding)), sample.mesh);
    }
  }
}

TEST(ReadMesh, MeditMayBeLaidOutFreely) {
  const CellList expected = two_tetrahedra().mesh;
  expect_equal(read_contents("\xEF\xBB\xBF# made by hand\n\n" + medit_sample), expected);
  expect_equal(read_contents(replaced(medit_sample, "Dimension 3", "Dimension\n3")), expected);
  expect_equal(read_contents(replaced(medit_sample, "Vertices\n5", "Vertices 5 # five")), expected);
  expect_equal(read_contents(replaced(medit_sample, "End\n", "")), expected);
  expect_equal(read_contents(replaced(medit_sample, "End\n", "END")), expected);
  expect_equal(read_contents(replaced(medit_sample, "Triangles",
                                      "Hexahedra 0 Corners 2 1 2 Normals 1 nan 0 1 Triangles")),
               expected);
  std::string windows;
  for (const char character : medit_sample)
    windows += character == '\n' ? std::string("\r\n") : std::string(1, character);
  expect_equal(read_contents(windows), expected);
}

TEST(ReadMesh, TinyAndSignedNumbersAreRead) {
  const CellList mesh = read_contents(replaced(medit_sample, "1.5", "+1e-400"));
  EXPECT_EQ(mesh.coordinates[7], 0);
}

TEST(ReadMesh, TruncationAtAnyByteIsRefusedOrHarmless) {
  for (const std::string &contents : sample_in_all_formats())
    for (std::size_t length = 0; length < contents.size(); ++length)
      EXPECT_TRUE(is_refused_or_usable(contents.substr(0, length))) << length << " of\n"
                                                                    << contents;
}

TEST(ReadMesh, DamagedBytesAreRefusedOrHarmless) {
  std::mt19937 random(20240607);
  const std::string likely = "0123456789-+.eEn $#\n";
  for (const std::string &contents : sample_in_all_formats())
    for (int trial = 0; trial < 1500; ++trial) {
      std::string damaged = contents;
      for (auto bytes = 1 + random() % 3; bytes > 0; --bytes)
        damaged[random() % damaged.size()] =
            random() % 2 == 0 ? likely[random() % likely.size()] : static_cast<char>(random());
      EXPECT_TRUE(is_refused_or_usable(damaged)) << damaged;
    }
}

TEST(ReadMesh, RefusesWhatIsNoMeshFile) {
  EXPECT_THROW(read_mesh("/nonexistent/horse.mesh"), InputError);
  EXPECT_THROW(read_mesh("/dev/null"), InputError);
  try {
    read_mesh("/tmp");
    ADD_FAILURE() << "a directory was read";
  } catch (const InputError &error) {
    EXPECT_STREQ(error.what(), "/tmp: is a directory; name a mesh file in it");
  }
  expect_refused("", {"is empty"});
  expect_refused(" \n\n", {"Medit .mesh (ASCII) and Gmsh .msh 2.2 and 4.1"});
  expect_refused("\x7f\x45LF\x02\x01", {"Medit .mesh (ASCII) and Gmsh .msh 2.2 and 4.1"});
  expect_refused("solid cube\nfacet", {"Medit .mesh (ASCII) and Gmsh .msh 2.2 and 4.1"});
  expect_refused(std::string("\1\0\0\0\3\0\0\0", 8), {".meshb", "meshio convert"});
}

/// Formats are known by their files' names, or by how they begin.
TEST(ReadMesh, SaysHowOtherFormatsAreConverted) {
  const auto advice = [](const std::string &path, const std::string &beginning = "") {
    return advice_on_format(path, beginning);
  };
  const auto expect = [](const std::string &sentence, const std::vector<std::string> &parts) {
    for (const std::string &part : parts)
      EXPECT_NE(sentence.find(part), std::string::npos) << part << " is missing in: " << sentence;
  };
  expect(advice("parts/bracket.BDF"),
         {"Nastran", "meshio convert bracket.BDF bracket.msh --output-format gmsh",
          "gmsh bracket.BDF -save -o bracket.msh"});
  expect(advice("a.inp"), {"Abaqus", "meshio convert a.inp a.msh"});
  expect(advice("a.msh", "(1 \"meshio 5\")\n"), {"Fluent", "meshio convert a.msh a_gmsh.msh"});
  expect(advice("a", "# vtk DataFile Version 5.1\n"), {"VTK", "meshio convert a a.msh"});
  expect(advice("a.mesh", "<?xml version=\"1.0\"?>\n<VTKFile type="), {"VTK"});
  expect(advice("a.stl"), {"surface", "tetrahedra"});
  expect(advice("a.step"), {"gmsh -3 a.step -o a.msh"});
  expect(advice("a.txt", "hello"), {"meshio convert", "gmsh -save"});
}

TEST(ReadMesh, RefusesBadMedit) {
  const std::string &good = medit_sample;
  expect_refused(replaced(good, "Dimension 3", "Dimension 4"), {"line 2", "dimension 4"});
  expect_refused(replaced(good, "Dimension 3", ""), {"line 3", "Dimension 3"});
  expect_refused(replaced(good, "Vertices\n5", "Vertices\n50000"), {"line 4", "50000 vertices"});
  expect_refused(replaced(good, "Vertices\n5", "Vertices\n-5"), {"line 4", "-5"});
  expect_refused(replaced(good, "Vertices\n5", "Vertices\n4"), {"line 9", "'-3"});
  expect_refused(replaced(good, "Vertices\n5", "Vertices\n6"), {"line 10", "'Triangles'"});
  expect_refused(replaced(good, "Vertices\n5", "Vertices\n9999999999999999999"), {"line 4"});
  expect_refused(replaced(good, "1.5", "1.5x"), {"line 7", "'1.5x'"});
  expect_refused(replaced(good, "1.5", "nan"), {"line 7", "vertex 3", "not finite"});
  expect_refused(replaced(good, "1.5", "1e999"), {"line 7", "vertex 3", "not finite"});
  expect_refused(replaced(good, "2 3 1 5", "2 3 1 6"), {"tetrahedron 2", "vertex 6", "to 5"});
  expect_refused(replaced(good, "2 3 1 5", "2 0 1 5"), {"tetrahedron 2", "vertex 0"});
  expect_refused(replaced(good, "2 3 1 5", "2 3.5 1 5"), {"line 16", "'3.5'"});
  expect_refused(replaced(replaced(good, "Tetrahedra", "Tetras"), "Triangles", "Tris"),
                 {"no Tetrahedra and no Triangles"});
  expect_refused(replaced(good, "Vertices", "Points"), {"no Vertices"});
  expect_refused(replaced(good, "Triangles", "Hexahedra"), {"Hexahedra", "first-order tetrahedra"});
  expect_refused(replaced(good, "End", "Vertices 0 End"), {"second section Vertices"});
  expect_refused(good.substr(0, good.find("Tetrahedra") + 20), {"truncated"});
}

TEST(ReadMesh, RefusesOtherVersionsOfGmsh) {
  for (const std::string version : {"1", "4", "4.2", "3.0"})
    expect_refused(replaced(ascii_4_1, "4.1", version), {"line 2", "'" + version + "'"});
  expect_refused("$NOD\n1\n", {"'1.0'"});
  expect_refused(replaced(ascii_4_1, "4.1 0 8", "4.1 0 4"), {"line 2", "4 bytes"});
  expect_refused(replaced(ascii_4_1, "4.1 0 8", "4.1 7 8"), {"file type is 7"});
  std::string swapped = gmsh_4_1(two_tetrahedra(), Encoding::binary);
  const auto mark = swapped.begin() + static_cast<std::ptrdiff_t>(swapped.find("1 8\n")) + 4;
  std::reverse(mark, mark + 4);
  expect_refused(swapped, {"other byte order"});
}

TEST(ReadMesh, RefusesBadGmsh) {
  expect_refused(replaced(ascii_2_2, "$Nodes\n5", "$Nodes\n4"), {"'5'", "$EndNodes"});
  expect_refused(replaced(ascii_2_2, "$Nodes\n5", "$Nodes\n900719925474099"), {"900719925474099"});
  expect_refused(replaced(ascii_2_2, "$Elements\n3", "$Elements\n4"), {"'$EndElements'"});
  expect_refused(replaced(ascii_2_2, "2 4 2 7 1", "2 29 2 7 1"), {"type 29", "-order 2"});
  expect_refused(replaced(ascii_2_2, "2 4 2 7 1", "2 5 2 7 1"), {"type 5", "hexahedron"});
  expect_refused(replaced(ascii_2_2, "2 4 2 7 1", "2 6 2 7 1"), {"type 6", "prism"});
  expect_refused(replaced(ascii_2_2, "2 4 2 7 1", "2 999 2 7 1"), {"type 999", "unknown"});
  expect_refused(replaced(ascii_2_2, "2 3 1 5", "2 3 1 12"), {"element 3", "node 12"});
  expect_refused(gmsh_2_2(two_tetrahedra({1, 2, 3, 4, 4}), Encoding::ascii), {"node 4 twice"});
  expect_refused(gmsh_4_1(two_tetrahedra({1, 2, 3, 99999, 99999}), Encoding::binary),
                 {"node 99999 twice"});
  expect_refused(replaced(ascii_4_1, "1.5", "inf"), {"node 3", "not finite"});
  expect_refused(replaced(ascii_4_1, "$Nodes\n2 5", "$Nodes\n2 6"), {"hold 5 nodes", "6"});
  expect_refused(replaced(ascii_4_1, "3 1 4 2", "3 1 29 2"), {"type 29", "cubic"});
  expect_refused(replaced(ascii_4_1, "$EndPhysicalNames", ""),
                 {"$EndPhysicalNames", "save the mesh again"});
  expect_refused(ascii_4_1.substr(0, ascii_4_1.find("$Elements")), {"no tetrahedra"});
  expect_refused(ascii_4_1.substr(0, ascii_4_1.find("$Nodes")), {"no $Nodes"});
  expect_refused(gmsh_2_2({two_tetrahedra().mesh, {1, 2, 3, 4, 5}}, Encoding::binary) + "rest",
                 {"'rest'"});
}

/// A triangle of order 2 beside its boundary, and a tetrahedron of order 2, as Gmsh writes them.
TEST(ReadMesh, SecondOrderCellsOfGmsh) {
  const std::string head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n";
  const CellList flat = read_contents(head +
                                      "6\n1 0 0 0\n2 2 0 0\n3 0 2 0\n4 1 0.1 0\n5 1 1 0\n6 0 1 0\n"
                                      "$EndNodes\n$Elements\n2\n1 8 2 0 1 1 2 4\n"
                                      "2 9 2 0 1 1 2 3 4 5 6\n$EndElements\n");
  EXPECT_EQ(flat.dimension(), 2);
  EXPECT_EQ(flat.shape->order, 2);
  EXPECT_EQ(flat.size(), 1);
  EXPECT_EQ(flat.cells, (std::vector<PetscInt>{0, 1, 2, 3, 4, 5}));
  const CellList solid = read_contents(
      head +
      "10\n1 0 0 0\n2 2 0 0\n3 0 2 0\n4 0 0 2\n5 1 0 0\n6 1 1 0\n7 0 1 0\n8 0 0 1\n9 0 1 1\n"
      "10 1 0 1\n$EndNodes\n$Elements\n1\n1 11 2 0 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n");
  EXPECT_EQ(solid.dimension(), 3);
  EXPECT_EQ(solid.shape->order, 2);
  // Every midpoint lies between its corners in our order, which is not Gmsh's.
  constexpr std::size_t edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  for (std::size_t e = 0; e < 6; ++e)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = [&](std::size_t node) {
        return solid.coordinates[static_cast<std::size_t>(3 * solid.cells[node]) + i];
      };
      EXPECT_EQ(at(4 + e), 0.5 * (at(edges[e][0]) + at(edges[e][1]))) << e;
    }
  expect_refused(head +
                     "6\n1 0 0 0\n2 2 0 0\n3 0 2 0\n4 1 0 0\n5 1 1 0\n6 0 1 0\n$EndNodes\n"
                     "$Elements\n2\n1 2 2 0 1 1 2 3\n2 9 2 0 1 1 2 3 4 5 6\n$EndElements\n",
                 {"first order", "second"});
}

/// MSH 2.2 with Mesh.SaveParametric: a node on a curve has its u, on a surface its u and v.
TEST(ReadMesh, ParametricNodes) {
  const TaggedMesh sample = two_tetrahedra();
  for (const Encoding encoding : {Encoding::ascii, Encoding::binary}) {
    Bytes nodes(encoding);
    nodes.text("$ParametricNodes\n5\n");
    for (int node = 0; node < 5; ++node) {
      const int dimension = node % 4;
      nodes.integer(node + 1);
      for (int k = 0; k < 3; ++k)
        nodes.real(sample.mesh.coordinates[static_cast<std::size_t>(3 * node + k)]);
      nodes.integer(dimension).integer(17);
      for (int k = 0; k < dimension % 3; ++k) nodes.real(0.5);
      nodes.end_line();
    }
    nodes.text("\n$EndParametricNodes\n");
    std::string contents = gmsh_2_2(sample, encoding);
    const std::size_t begin = contents.find("$Nodes"), end = contents.find("$Elements");
    expect_equal(read_contents(contents.replace(begin, end - begin, nodes.str())), sample.mesh);
    // In version 4.1 a block says itself whether it has parameters.
    contents = replaced(gmsh_4_1(sample, encoding), "$Nodes", "$ParametricNodes");
    expect_equal(read_contents(replaced(contents, "$EndNodes", "$EndParametricNodes")),
                 sample.mesh);
  }
}

/// Elements of the body's dimension that are not read would be missing in it.
TEST(ReadMesh, RefusesOtherCellsBesideTriangles) {
  const std::string head =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n"
      "5 2 0 0\n$EndNodes\n$Elements\n";
  const std::string triangle = "1 2 2 0 1 2 5 3\n", end = "$EndElements\n";
  const std::string quadrilateral = "2 3 2 0 1 1 2 3 4\n";
  EXPECT_EQ(read_contents(head + "1\n" + triangle + end).size(), 1);
  expect_refused(head + "2\n" + triangle + quadrilateral + end,
                 {"quadrilaterals (1) beside 1 triangle", "Recombine"});
  expect_refused(head + "2\n" + triangle + "2 21 2 0 1 1 2 3 4 5 1 2 3 4 5\n" + end,
                 {"triangles of 10 nodes (1)"});
  expect_refused(head + "1\n" + quadrilateral + end, {"no triangles", "quadrilaterals (1)"});
  // On the surface of a volume mesh they are no cells.
  EXPECT_EQ(read_contents(head + "2\n" + quadrilateral + "1 4 2 0 1 1 2 4 5\n" + end).size(), 1);
  const std::string plane =
      "MeshVersionFormatted 2\nDimension 2\nVertices 5\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n";
  for (const std::string section :
       {"Quadrilaterals 1\n1 2 3 4 0\n", "TrianglesP2 1\n1 2 3 4 5 1\n"}) {
    expect_refused(plane + section + "Triangles 1\n2 5 3 0\nEnd\n",
                   {section.substr(0, section.find(' ')) + " (1) beside Triangles"});
    expect_refused(plane + section + "End\n", {"(1), but only Triangles and Tetrahedra"});
  }
  EXPECT_EQ(read_contents(plane + "Quadrilaterals 0\nTriangles 1\n2 5 3 0\nEnd\n").size(), 1);
}

TEST(ReadMesh, PlaneMeditMeshes) {
  for (const bool has_z : {false, true}) {
    const std::string z = has_z ? " 0" : "";
    const CellList mesh =
        read_contents(std::string("MeshVersionFormatted 2\nDimension ") + (has_z ? "3" : "2") +
                      "\nVertices\n4\n0 0" + z + " 0\n1 0" + z + " 0\n1 1" + z + " 0\n0 1" + z +
                      " 0\nEdges 1\n1 2 7\nTriangles\n2\n1 2 3 0\n1 3 4 0\nEnd\n");
    EXPECT_EQ(mesh.dimension(), 2);
    EXPECT_EQ(mesh.coordinates, (std::vector<double>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}));
    EXPECT_EQ(mesh.cells, (std::vector<PetscInt>{0, 1, 2, 0, 2, 3}));
  }
}

}  // namespace
}  // namespace trefoil::testing
