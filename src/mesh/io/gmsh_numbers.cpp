#include <cmath>
#include <string>

#include "mesh/io/gmsh.hpp"

namespace trefoil {
namespace {

struct ElementType {
  std::int64_t type;
  int dimension, nodes;
  const char *names;
};

struct VolumeType {
  std::int64_t type;
  const char *name;
};

// Points, lines, triangles and quadrilaterals of all orders, and tetrahedra of the first two.
constexpr ElementType accepted_types[] = {{1, 1, 2, "lines"},
                                          {2, 2, 3, "triangles"},
                                          {3, 2, 4, "quadrilaterals"},
                                          {4, 3, 4, "tetrahedra"},
                                          {8, 1, 3, "lines of 3 nodes"},
                                          {9, 2, 6, "triangles of 6 nodes"},
                                          {10, 2, 9, "quadrilaterals of 9 nodes"},
                                          {11, 3, 10, "tetrahedra of 10 nodes"},
                                          {15, 0, 1, "points"},
                                          {16, 2, 8, "quadrilaterals of 8 nodes"},
                                          {20, 2, 9, "triangles of 9 nodes"},
                                          {21, 2, 10, "triangles of 10 nodes"},
                                          {22, 2, 12, "triangles of 12 nodes"},
                                          {23, 2, 15, "triangles of 15 nodes"},
                                          {24, 2, 15, "triangles of 15 nodes"},
                                          {25, 2, 21, "triangles of 21 nodes"},
                                          {26, 1, 4, "lines of 4 nodes"},
                                          {27, 1, 5, "lines of 5 nodes"},
                                          {28, 1, 6, "lines of 6 nodes"},
                                          {36, 2, 16, "quadrilaterals of 16 nodes"},
                                          {37, 2, 25, "quadrilaterals of 25 nodes"}};

constexpr VolumeType refused_types[] = {{5, "a hexahedron"},
                                        {6, "a prism"},
                                        {7, "a pyramid"},
                                        {12, "a second-order hexahedron of 27 nodes"},
                                        {13, "a second-order prism of 18 nodes"},
                                        {14, "a second-order pyramid of 14 nodes"},
                                        {17, "a second-order hexahedron of 20 nodes"},
                                        {18, "a second-order prism of 15 nodes"},
                                        {19, "a second-order pyramid of 13 nodes"},
                                        {92, "a third-order hexahedron of 64 nodes"},
                                        {93, "a fourth-order hexahedron of 125 nodes"}};

constexpr VolumeType curved_tetrahedra[] = {{29, "a cubic tetrahedron of 20 nodes"},
                                            {30, "a fourth-order tetrahedron of 35 nodes"},
                                            {31, "a fifth-order tetrahedron of 56 nodes"}};

const ElementType *find_type(std::int64_t type) {
  for (const ElementType &accepted : accepted_types)
    if (accepted.type == type) return &accepted;
  return nullptr;
}

}  // namespace

int dimension_of_element(std::int64_t type) {
  return find_type(type)->dimension;
}

std::string name_of_elements(std::int64_t type) {
  return find_type(type)->names;
}

int nodes_of_element(const MeshFile &file, std::int64_t type) {
  if (const ElementType *accepted = find_type(type)) return accepted->nodes;
  const std::string number = "element type " + std::to_string(type);
  for (const VolumeType &curved : curved_tetrahedra)
    if (curved.type == type)
      file.fail(number + " is " + curved.name +
                ", but only the first two orders are read; save it again with gmsh -order 2");
  for (const VolumeType &refused : refused_types)
    if (refused.type == type)
      file.fail(number + " is " + refused.name +
                ", but only tetrahedra are read; mesh the volume with tetrahedra");
  file.fail(number + " is unknown; save a mesh of first-order tetrahedra");
}

std::int64_t GmshNumbers::integer(const char *what) {
  return is_binary_ ? file_.binary<std::int32_t>(what) : file_.integer(what);
}

std::int64_t GmshNumbers::size(const char *what) {
  return is_binary_ ? file_.binary<std::int64_t>(what) : file_.integer(what);
}

double GmshNumbers::real(const char *what) {
  return is_binary_ ? file_.binary<double>(what) : file_.real(what);
}

std::int64_t GmshNumbers::checked_count(std::int64_t count, std::size_t numbers, std::size_t bytes,
                                        const char *what) {
  const std::size_t bytes_of_text = 2 * numbers;  // a digit and a blank for each
  file_.check_room(count, is_binary_ ? bytes : bytes_of_text, what);
  return count;
}

double read_coordinate(GmshNumbers &numbers, std::int64_t tag) {
  const double coordinate = numbers.real("a node coordinate");
  if (!std::isfinite(coordinate))
    numbers.file().fail("node " + std::to_string(tag) +
                        " has a coordinate that is not finite; correct it");
  return coordinate;
}

}  // namespace trefoil
