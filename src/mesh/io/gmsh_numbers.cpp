#include <cmath>
#include <string>

#include "mesh/io/gmsh.hpp"

namespace trefoil {
namespace {

struct ElementType {
  std::int64_t type;
  int nodes;
};

struct VolumeType {
  std::int64_t type;
  const char *name;
};

// Points, lines, triangles and quadrilaterals of all orders, and tetrahedra of the first two.
constexpr ElementType accepted_types[] = {{1, 2},   {2, 3},   {3, 4},   {4, 4},   {8, 3},  {9, 6},
                                          {10, 9},  {11, 10}, {15, 1},  {16, 8},  {20, 9}, {21, 10},
                                          {22, 12}, {23, 15}, {24, 15}, {25, 21}, {26, 4}, {27, 5},
                                          {28, 6},  {36, 16}, {37, 25}};

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

}  // namespace

int nodes_of_element(const MeshFile &file, std::int64_t type) {
  for (const ElementType &accepted : accepted_types)
    if (accepted.type == type) return accepted.nodes;
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
