#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "mesh/cell_list.hpp"
#include "mesh/io/mesh_file.hpp"

namespace trefoil {

/// Reads a Gmsh mesh, MSH 2.2 or 4.1, ASCII or binary: its nodes and its tetrahedra, of first order
/// (type 4) or second (11); where it has none its triangles (2 or 9); with
/// their physical groups. Other elements of lower
/// dimension and other sections are skipped, other volume elements are an InputError. Format: C.
/// Geuzaine, J.-F. Remacle, "Gmsh reference manual", chapter "File formats".
CellList read_gmsh(MeshFile &file);

// What follows is shared by the readers of the two versions.

/// The numbers of a Gmsh file, whether written as text or in binary.
class GmshNumbers {
 public:
  GmshNumbers(MeshFile &file, bool is_binary) : file_(file), is_binary_(is_binary) {}

  [[nodiscard]] MeshFile &file() const { return file_; }
  [[nodiscard]] bool is_binary() const { return is_binary_; }

  /// What the manual calls int, size_t and double: 4, 8 and 8 bytes in a binary file.
  std::int64_t integer(const char *what);
  std::int64_t size(const char *what);
  double real(const char *what);
  /// The number of items announced by `count`, each of at least `numbers` numbers that take
  /// `bytes` bytes in a binary file; InputError if the file has no room for them.
  std::int64_t checked_count(std::int64_t count, std::size_t numbers, std::size_t bytes,
                             const char *what);

 private:
  MeshFile &file_;
  bool is_binary_;
};

/// Cells of one type as the file has them: their own tags, their physical groups (0: none), and the
/// tags of their nodes.
struct GmshCells {
  const CellShape *shape = nullptr;
  std::vector<std::int64_t> tags{}, groups{}, nodes{};
};

/// What the sections $PhysicalNames and, in version 4.1, $Entities say of groups. Names and groups
/// belong to a dimension: a surface and a volume may have the same.
struct GmshGroups {
  using Key = std::pair<std::int64_t, std::int64_t>;  ///< dimension, tag of an entity
  std::map<Key, std::int64_t> of_entity;
  std::map<std::string, std::int64_t> of_dimension[4];  ///< numbers by name
};

/// What the sections $Nodes and $Elements say.
struct GmshContents {
  std::vector<std::int64_t> node_tags;
  std::vector<double> coordinates;  ///< nodes x 3
  GmshGroups groups;
  std::vector<GmshCells> cells;  ///< of the shapes that may make a mesh

  GmshContents() {
    for (const CellShape *shape : mesh_shapes()) cells.push_back({shape});
  }

  /// The cells of a type; null for other types.
  [[nodiscard]] GmshCells *of_type(std::int64_t type) {
    for (GmshCells &each : cells)
      if (each.shape->gmsh_type == type) return &each;
    return nullptr;
  }
};

/// The number of nodes of an element of a Gmsh type; InputError if the type is unknown, or if it
/// is a volume element other than a tetrahedron of first or second order.
int nodes_of_element(const MeshFile &file, std::int64_t type);

/// Reads a finite coordinate of node `tag`.
double read_coordinate(GmshNumbers &numbers, std::int64_t tag);

/// Read what stands between $Nodes and $EndNodes, $Elements and $EndElements.
void read_nodes_2_2(GmshNumbers &numbers, GmshContents &contents);
void read_elements_2_2(GmshNumbers &numbers, GmshContents &contents);
void read_nodes_4_1(GmshNumbers &numbers, GmshContents &contents);
void read_elements_4_1(GmshNumbers &numbers, GmshContents &contents);

/// Read what stands between $PhysicalNames and its end, which is text in binary files too, and
/// between $Entities and its end. An entity of several groups counts for the first.
void read_physical_names(MeshFile &file, GmshGroups &groups);
void read_entities_4_1(GmshNumbers &numbers, GmshGroups &groups);

}  // namespace trefoil
