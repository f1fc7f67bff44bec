// What tells a mesh from others: the same over ranks, partitions and files, another after any
// change. Needs petsc_main.cpp.

#include "output/mesh_fingerprint.hpp"

#include "body.hpp"
#include "mesh/cell_list.hpp"

namespace trefoil::test {
namespace {

nlohmann::ordered_json fingerprint_of(MPI_Comm comm, CellList whole) {
  Mesh mesh;
  MeshFingerprint fingerprint;
  number_as_in_file(whole);
  EXPECT_EQ(distribute_mesh(comm, whole, "metis", 0, &mesh), PETSC_SUCCESS);
  EXPECT_EQ(fingerprint.take(mesh), PETSC_SUCCESS);
  return nlohmann::ordered_json::parse(fingerprint.json().dump());
}

/// What the body on all ranks has to say about the fingerprint of another, taken on one rank.
std::string difference(const CellList &one, const CellList &other) {
  Mesh mesh;
  MeshFingerprint fingerprint;
  CellList numbered = one;
  number_as_in_file(numbered);
  EXPECT_EQ(distribute_mesh(PETSC_COMM_WORLD, numbered, "metis", 0, &mesh), PETSC_SUCCESS);
  EXPECT_EQ(fingerprint.take(mesh), PETSC_SUCCESS);
  return fingerprint.difference(fingerprint_of(PETSC_COMM_SELF, other));
}

TEST(MeshFingerprintTest, IsTheSameOnAnyRanks) {
  for (const char *kind : {"box", "square"}) {
    const CellList mesh = generate_mesh(kind, 4, 0);
    EXPECT_EQ(difference(mesh, mesh), "") << kind;
  }
}

TEST(MeshFingerprintTest, NoticesWhatIsDifferent) {
  const CellList mesh = generate_mesh("box", 4, 0);
  CellList moved = mesh, exchanged = mesh, rewired = mesh, swapped = mesh;
  moved.coordinates[3 * 17 + 1] += 1e-6;
  const auto vertex = exchanged.coordinates.begin() + 3 * 17;
  std::swap_ranges(vertex, vertex + 3, exchanged.coordinates.begin());
  std::swap(rewired.cells[0], rewired.cells[1]);
  std::swap_ranges(swapped.cells.begin(), swapped.cells.begin() + 4, swapped.cells.begin() + 4);
  EXPECT_NE(difference(mesh, moved).find("vertices in other places"), std::string::npos);
  EXPECT_NE(difference(mesh, exchanged).find("vertices in other places"), std::string::npos);
  EXPECT_NE(difference(mesh, rewired).find("of other vertices"), std::string::npos);
  EXPECT_NE(difference(mesh, swapped).find("of other vertices"), std::string::npos);
  EXPECT_NE(difference(mesh, generate_mesh("box", 5, 0)).find("cells there"), std::string::npos);
  EXPECT_NE(difference(mesh, generate_mesh("square", 4, 0)).find("tri3"), std::string::npos);
}

/// Coordinates that are sums over ranks, in any order, may differ by rounding.
TEST(MeshFingerprintTest, ForgivesRounding) {
  const CellList mesh = generate_mesh("box", 4, 0);
  CellList rounded = mesh;
  for (double &coordinate : rounded.coordinates) coordinate *= 1 + 1e-15;
  EXPECT_EQ(difference(mesh, rounded), "");
}

}  // namespace
}  // namespace trefoil::test
