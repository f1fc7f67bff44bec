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
/// (type 4) or second (11), where it has none its triangles (2 or 9), with the physical groups of
/// these and of all points, curves and surfaces. Other elements of lower dimension and other
/// sections are skipped, other elements of the body's dimension are an InputError. Format: C.
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

/// Elements of one type as the file has them: their own tags, the numbers of their sets of groups,
/// and the tags of their nodes. Of points and curves only those that are in groups.
struct GmshElements {
  const CellShape *shape = nullptr;
  std::vector<std::int64_t> tags{}, nodes{};
  std::vector<PetscInt> sets{};

  void add(std::int64_t tag, PetscInt set) {
    tags.push_back(tag);
    sets.push_back(set);
  }
};

/// What the sections of a file say.
struct GmshContents {
  using Entity = std::pair<std::int64_t, std::int64_t>;  ///< dimension and tag, in version 4.1

  std::vector<std::int64_t> node_tags;
  std::vector<double> coordinates;  ///< nodes x 3
  Groups groups;                    ///< whose sets the elements have
  std::map<Entity, PetscInt> set_of_entity;
  std::vector<GmshElements> elements;                ///< of the shapes that are read
  std::map<std::int64_t, std::int64_t> other_types;  ///< elements of types that are not, by type

  GmshContents() {
    for (const CellShape *shape : all_shapes()) elements.push_back({shape});
  }
  /// Where to put an element; null where it has nothing to say.
  GmshElements *place_for(std::int64_t type, PetscInt set);
};

/// The number of nodes of an element of a Gmsh type; InputError if the type is unknown, or if it
/// is a volume element other than a tetrahedron of first or second order.
int nodes_of_element(const MeshFile &file, std::int64_t type);
/// The dimension of such an element.
int dimension_of_element(std::int64_t type);
/// "quadrilaterals"; of a type that nodes_of_element() knows.
std::string name_of_elements(std::int64_t type);

/// Reads a finite coordinate of node `tag`.
double read_coordinate(GmshNumbers &numbers, std::int64_t tag);

/// The number of a group as the user knows it: a negative one stands for the group turned round.
PetscInt checked_group(const MeshFile &file, std::int64_t number);

/// Read what stands between $Nodes and $EndNodes, $Elements and $EndElements.
/// @param is_parametric the section is $ParametricNodes: in version 2.2 parameters may follow a
/// node
void read_nodes_2_2(GmshNumbers &numbers, bool is_parametric, GmshContents &contents);
void read_elements_2_2(GmshNumbers &numbers, GmshContents &contents);
void read_nodes_4_1(GmshNumbers &numbers, GmshContents &contents);
void read_elements_4_1(GmshNumbers &numbers, GmshContents &contents);

/// Read what stands between $PhysicalNames and its end, which is text in binary files too, between
/// $Entities and its end, and between $PartitionedEntities and its end.
void read_physical_names(MeshFile &file, GmshContents &contents);
void read_entities_4_1(GmshNumbers &numbers, GmshContents &contents);
void read_partitioned_entities_4_1(GmshNumbers &numbers, GmshContents &contents);

/// The mesh that the contents of a file make.
CellList mesh_of(const MeshFile &file, GmshContents contents);

}  // namespace trefoil
