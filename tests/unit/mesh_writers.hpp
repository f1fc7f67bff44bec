#pragma once

#include <unistd.h>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "mesh/cell_list.hpp"
#include "mesh/io/read_mesh.hpp"

/// Writes small meshes in every format that is read, byte by byte as the formats' manuals have it.
namespace trefoil::testing {

enum class Encoding { ascii, binary };

/// A mesh with the node tags it has in a Gmsh file, which Medit has no counterpart for.
struct TaggedMesh {
  CellList mesh;
  std::vector<std::int64_t> tags;
};

/// Two tetrahedra on a common face, the second negative: a reader must not turn it round.
inline TaggedMesh two_tetrahedra(std::vector<std::int64_t> tags = {1, 2, 3, 4, 5}) {
  CellList mesh;
  mesh.coordinates = {0, 0, 0, 1, 0, 0, 0, 1.5, 0, 0.125, 0.25, 1, -3e-5, 0.1, -2};
  mesh.cells = {0, 1, 2, 3, 1, 2, 0, 4};
  return {mesh, std::move(tags)};
}

/// Numbers as text, with a blank behind each, or as bytes.
class Bytes {
 public:
  explicit Bytes(Encoding encoding) : encoding_(encoding) { text_.precision(17); }

  Bytes &text(const std::string &characters) { return text_ << characters, *this; }
  Bytes &integer(std::int64_t value) { return write(static_cast<std::int32_t>(value)); }
  Bytes &size(std::int64_t value) { return write(value); }
  Bytes &real(double value) { return write(value); }
  Bytes &end_line() { return encoding_ == Encoding::ascii ? text("\n") : *this; }
  [[nodiscard]] std::string str() const { return text_.str(); }

 private:
  template <class Number>
  Bytes &write(Number value) {
    if (encoding_ == Encoding::ascii)
      text_ << value << ' ';
    else
      text_.write(reinterpret_cast<const char *>(&value), sizeof(Number));
    return *this;
  }

  Encoding encoding_;
  std::ostringstream text_;
};

inline void write_gmsh_head(Bytes &bytes, const std::string &version, Encoding encoding) {
  const bool is_binary = encoding == Encoding::binary;
  bytes.text("$MeshFormat\n" + version + (is_binary ? " 1 8\n" : " 0 8\n"));
  if (is_binary) bytes.integer(1).text("\n");
  bytes.text("$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"body\"\n$EndPhysicalNames\n");
}

/// MSH 2.2: a triangle first, then the tetrahedra, with two labels each.
inline std::string gmsh_2_2(const TaggedMesh &tagged, Encoding encoding) {
  const auto &[mesh, tags] = tagged;
  Bytes bytes(encoding);
  write_gmsh_head(bytes, "2.2", encoding);
  bytes.text("$Nodes\n" + std::to_string(tags.size()) + "\n");
  for (std::size_t node = 0; node < tags.size(); ++node) {
    bytes.integer(tags[node]);
    for (std::size_t k = 0; k < 3; ++k) bytes.real(mesh.coordinates[3 * node + k]);
    bytes.end_line();
  }
  bytes.text("\n$EndNodes\n$Elements\n" + std::to_string(mesh.size() + 1) + "\n");

  const bool is_binary = encoding == Encoding::binary;
  const auto write_head = [&](std::int64_t tag, std::int64_t type, std::int64_t count) {
    if (!is_binary) bytes.integer(tag).integer(type).integer(2);
    if (is_binary && count > 0) bytes.integer(type).integer(count).integer(2);
    if (is_binary) bytes.integer(tag);
    bytes.integer(7).integer(1);
  };
  write_head(1, 2, 1);
  for (std::size_t node = 0; node < 3; ++node) bytes.integer(tags[node]);
  bytes.end_line();
  for (PetscInt cell = 0; cell < mesh.size(); ++cell) {
    write_head(cell + 2, 4, cell == 0 ? mesh.size() : 0);
    for (PetscInt k = 0; k < 4; ++k) bytes.integer(tags[mesh.cells[4 * cell + k]]);
    bytes.end_line();
  }
  return bytes.text("\n$EndElements\n").str();
}

/// MSH 4.1: a parametric node block on a surface (u and v behind x y z) and one in the volume.
inline std::string gmsh_4_1(const TaggedMesh &tagged, Encoding encoding) {
  const auto &[mesh, tags] = tagged;
  const auto nodes = static_cast<std::int64_t>(tags.size());
  Bytes bytes(encoding);
  write_gmsh_head(bytes, "4.1", encoding);
  bytes.text("$Nodes\n").size(2).size(nodes).size(1).size(nodes).end_line();
  const auto write_block = [&](std::int64_t dimension, bool is_parametric, std::size_t first,
                               std::size_t last) {
    bytes.integer(dimension).integer(1).integer(is_parametric);
    bytes.size(static_cast<std::int64_t>(last - first)).end_line();
    for (std::size_t node = first; node < last; ++node) bytes.size(tags[node]).end_line();
    for (std::size_t node = first; node < last; ++node) {
      for (std::size_t k = 0; k < 3; ++k) bytes.real(mesh.coordinates[3 * node + k]);
      if (is_parametric) bytes.real(0.5).real(0.25);
      bytes.end_line();
    }
  };
  write_block(2, true, 0, 2);
  write_block(3, false, 2, tags.size());
  bytes.text("\n$EndNodes\n$Elements\n")
      .size(2)
      .size(mesh.size() + 1)
      .size(1)
      .size(mesh.size() + 1);
  bytes.end_line().integer(2).integer(1).integer(2).size(1).end_line().size(1);
  for (std::size_t node = 0; node < 3; ++node) bytes.size(tags[node]);
  bytes.end_line().integer(3).integer(1).integer(4).size(mesh.size()).end_line();
  for (PetscInt cell = 0; cell < mesh.size(); ++cell) {
    bytes.size(cell + 2);
    for (PetscInt k = 0; k < 4; ++k) bytes.size(tags[mesh.cells[4 * cell + k]]);
    bytes.end_line();
  }
  return bytes.text("\n$EndElements\n").str();
}

inline const std::string physical_names =
    "$PhysicalNames\n3\n2 7 \"skin\"\n3 3 \"soft tissue\"\n3 8 \"bone\"\n$EndPhysicalNames\n";

/// Two volumes of entity tags 5 and 6 after a point, a curve and a surface, which are in groups 4,
/// 6 and 9, and 7; the second volume has two groups, and is turned round in one.
inline std::string entities_4_1(Encoding encoding) {
  Bytes bytes(encoding);
  bytes.text("$Entities\n").size(1).size(1).size(1).size(2).end_line();
  bytes.integer(1).real(0).real(0).real(0).size(1).integer(4).end_line();
  const auto entity = [&](int tag, std::vector<int> groups, std::vector<int> bounds) {
    bytes.integer(tag);
    for (int k = 0; k < 6; ++k) bytes.real(k);
    bytes.size(static_cast<std::int64_t>(groups.size()));
    for (const int group : groups) bytes.integer(group);
    bytes.size(static_cast<std::int64_t>(bounds.size()));
    for (const int bound : bounds) bytes.integer(bound);
    bytes.end_line();
  };
  entity(1, {6, -9}, {1, -1});
  entity(5, {7}, {1});
  entity(5, {3}, {5});
  entity(6, {-8, 3}, {5});
  return bytes.text("\n$EndEntities\n").str();
}

inline std::string two_volumes_4_1(Encoding encoding) {
  const auto [mesh, tags] = two_tetrahedra();
  Bytes bytes(encoding);
  bytes.text("$MeshFormat\n4.1 " + std::string(encoding == Encoding::binary ? "1" : "0") + " 8\n");
  if (encoding == Encoding::binary) bytes.integer(1).text("\n");
  bytes.text("$EndMeshFormat\n" + physical_names + entities_4_1(encoding));
  bytes.text("$Nodes\n").size(1).size(5).size(1).size(5).end_line();
  bytes.integer(3).integer(5).integer(0).size(5).end_line();
  for (const std::int64_t tag : tags) bytes.size(tag).end_line();
  for (const double coordinate : mesh.coordinates) bytes.real(coordinate);
  bytes.text("\n$EndNodes\n$Elements\n").size(5).size(6).size(1).size(6).end_line();
  bytes.integer(0).integer(1).integer(15).size(1).end_line().size(3).size(1).end_line();
  bytes.integer(1).integer(1).integer(1).size(2).end_line();
  bytes.size(4).size(1).size(2).end_line().size(5).size(3).size(2).end_line();
  bytes.integer(2).integer(5).integer(2).size(1).end_line();
  bytes.size(6).size(3).size(2).size(1).end_line();
  for (int cell = 0; cell < 2; ++cell) {
    bytes.integer(3).integer(6 - cell).integer(4).size(1).end_line().size(cell + 1);
    for (std::size_t k = 0; k < 4; ++k)
      bytes.size(mesh.cells[4 * static_cast<std::size_t>(cell) + k] + 1);
    bytes.end_line();
  }
  return bytes.text("\n$EndElements\n").str();
}

/// A partitioned file: the elements are on entities of $PartitionedEntities, the second of which
/// does not repeat its parent's groups. Between them is a surface of the partition, whose parent is
/// a volume.
inline std::string partitioned_4_1(Encoding encoding) {
  const auto [mesh, tags] = two_tetrahedra();
  Bytes bytes(encoding);
  bytes.text("$MeshFormat\n4.1 " + std::string(encoding == Encoding::binary ? "1" : "0") + " 8\n");
  if (encoding == Encoding::binary) bytes.integer(1).text("\n");
  bytes.text("$EndMeshFormat\n" + physical_names + entities_4_1(encoding));
  bytes.text("$PartitionedEntities\n").size(2).size(1).integer(77).integer(2).end_line();
  bytes.size(0).size(0).size(1).size(2).end_line();
  const auto entity = [&](int tag, int parent_dimension, int parent, std::vector<int> partitions,
                          std::vector<int> groups) {
    bytes.integer(tag).integer(parent_dimension).integer(parent);
    bytes.size(static_cast<std::int64_t>(partitions.size()));
    for (const int partition : partitions) bytes.integer(partition);
    for (int k = 0; k < 6; ++k) bytes.real(k);
    bytes.size(static_cast<std::int64_t>(groups.size()));
    for (const int group : groups) bytes.integer(group);
    bytes.size(1).integer(9).end_line();
  };
  entity(30, 3, 6, {1, 2}, {});
  entity(10, 3, 5, {1}, {3});
  entity(11, 3, 6, {2}, {});
  bytes.text("\n$EndPartitionedEntities\n");
  bytes.text("$Nodes\n").size(1).size(5).size(1).size(5).end_line();
  bytes.integer(3).integer(10).integer(0).size(5).end_line();
  for (const std::int64_t tag : tags) bytes.size(tag).end_line();
  for (const double coordinate : mesh.coordinates) bytes.real(coordinate);
  bytes.text("\n$EndNodes\n$Elements\n").size(3).size(3).size(1).size(3).end_line();
  bytes.integer(2).integer(30).integer(2).size(1).end_line().size(1);
  bytes.size(1).size(2).size(3).end_line();
  for (int cell = 0; cell < 2; ++cell) {
    bytes.integer(3).integer(10 + cell).integer(4).size(1).end_line().size(cell + 2);
    for (std::size_t k = 0; k < 4; ++k)
      bytes.size(mesh.cells[4 * static_cast<std::size_t>(cell) + k] + 1);
    bytes.end_line();
  }
  return bytes.text("\n$EndElements\n").str();
}

/// Medit, with a surface section before the tetrahedra.
inline std::string medit(const CellList &mesh) {
  std::ostringstream text;
  text.precision(17);
  text << "MeshVersionFormatted 2\nDimension 3\nVertices\n" << mesh.vertices() << '\n';
  for (std::size_t entry = 0; entry < mesh.coordinates.size(); ++entry)
    text << mesh.coordinates[entry] << (entry % 3 == 2 ? " 0\n" : " ");
  text << "Triangles\n1\n1 2 3 0\nTetrahedra\n" << mesh.size() << '\n';
  for (std::size_t entry = 0; entry < mesh.cells.size(); ++entry)
    text << mesh.cells[entry] + 1 << (entry % 4 == 3 ? " 0\n" : " ");
  return text.str() + "End\n";
}

/// A file that goes when this does.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string &contents)
      : path_((std::filesystem::temp_directory_path() /
               ("trefoil_mesh_test_" + std::to_string(getpid())))
                  .string()) {
    std::ofstream(path_, std::ios::binary) << contents;
  }
  TemporaryFile(const TemporaryFile &) = delete;
  TemporaryFile &operator=(const TemporaryFile &) = delete;
  ~TemporaryFile() { std::filesystem::remove(path_); }

  [[nodiscard]] const std::string &path() const { return path_; }

 private:
  std::string path_;
};

inline CellList read_contents(const std::string &contents) {
  return read_mesh(TemporaryFile(contents).path());
}

/// The sentence with which the contents are refused; empty if they are not.
inline std::string refusal(const std::string &contents) {
  try {
    read_contents(contents);
  } catch (const InputError &error) {
    return error.what();
  }
  return "";
}

}  // namespace trefoil::testing
