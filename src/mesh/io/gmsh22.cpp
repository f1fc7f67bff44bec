#include <string>

#include "mesh/io/gmsh.hpp"

namespace trefoil {
namespace {

constexpr std::size_t bytes_of_node = 4 + 3 * 8;  // tag and coordinates
constexpr std::size_t bytes_of_integer = 4;

// The count stands on a line of text also in a binary file.
std::int64_t read_count(GmshNumbers &numbers, const char *what) {
  const std::int64_t count = numbers.file().integer(what);
  if (numbers.is_binary()) numbers.file().end_line();
  return count;
}

// What follows an element's tag: its physical group, which comes first, and the like, and its
// nodes.
void read_element(GmshNumbers &numbers, std::int64_t tag, std::int64_t type, int nodes,
                  std::int64_t labels, GmshContents &contents) {
  PetscInt group = 0;
  for (std::int64_t label = 0; label < labels; ++label) {
    const std::int64_t number = numbers.integer("a tag of an element");
    if (label == 0) group = checked_group(numbers.file(), number);
  }
  const PetscInt set = group == 0 ? 0 : contents.groups.set_of(dimension_of_element(type), group);
  GmshElements *elements = contents.place_for(type, set);
  if (elements) elements->add(tag, set);
  for (int node = 0; node < nodes; ++node) {
    const std::int64_t node_tag = numbers.integer("a node of an element");
    if (elements) elements->nodes.push_back(node_tag);
  }
}

std::int64_t read_label_count(GmshNumbers &numbers) {
  return numbers.checked_count(numbers.integer("the number of tags of an element"), 1,
                               bytes_of_integer, "tags of an element");
}

// In a binary file elements of one type and one number of labels follow a common header.
std::int64_t read_binary_block(GmshNumbers &numbers, std::int64_t left, GmshContents &contents) {
  const std::int64_t type = numbers.integer("an element type");
  const int nodes = nodes_of_element(numbers.file(), type);
  const std::int64_t count = numbers.integer("the number of elements in a block");
  if (count < 1 || count > left)
    numbers.file().fail("a block of " + std::to_string(count) + " elements where " +
                        std::to_string(left) + " are left of $Elements; save the mesh again");
  const std::int64_t labels = read_label_count(numbers);
  for (std::int64_t element = 0; element < count; ++element)
    read_element(numbers, numbers.integer("an element tag"), type, nodes, labels, contents);
  return count;
}

std::int64_t read_text_element(GmshNumbers &numbers, GmshContents &contents) {
  const std::int64_t tag = numbers.integer("an element tag");
  const std::int64_t type = numbers.integer("an element type");
  const int nodes = nodes_of_element(numbers.file(), type);
  const std::int64_t labels = read_label_count(numbers);
  read_element(numbers, tag, type, nodes, labels, contents);
  return 1;
}

// Behind a node of $ParametricNodes: the entity that it lies on, and where on a curve or a surface.
void skip_parameters(GmshNumbers &numbers) {
  const std::int64_t dimension = numbers.integer("the dimension of a node's entity");
  if (dimension < 0 || dimension > 3)
    numbers.file().fail("an entity has dimension " + std::to_string(dimension) +
                        ", which is not 0 to 3; save the mesh again");
  numbers.integer("the tag of a node's entity");
  for (std::int64_t k = 0; k < dimension % 3; ++k) numbers.real("a parameter of a node");
}

}  // namespace

void read_nodes_2_2(GmshNumbers &numbers, bool is_parametric, GmshContents &contents) {
  const std::int64_t count =
      numbers.checked_count(read_count(numbers, "the number of nodes"), 4, bytes_of_node, "nodes");
  contents.node_tags.reserve(static_cast<std::size_t>(count));
  contents.coordinates.reserve(static_cast<std::size_t>(3 * count));
  for (std::int64_t node = 0; node < count; ++node) {
    const std::int64_t tag = numbers.integer("a node tag");
    contents.node_tags.push_back(tag);
    for (int component = 0; component < 3; ++component)
      contents.coordinates.push_back(read_coordinate(numbers, tag));
    if (is_parametric) skip_parameters(numbers);
  }
}

void read_elements_2_2(GmshNumbers &numbers, GmshContents &contents) {
  constexpr std::size_t tag_and_node = 2;
  const std::int64_t count =
      numbers.checked_count(read_count(numbers, "the number of elements"), tag_and_node,
                            tag_and_node * bytes_of_integer, "elements");
  for (std::int64_t read = 0; read < count;)
    read += numbers.is_binary() ? read_binary_block(numbers, count - read, contents)
                                : read_text_element(numbers, contents);
}

}  // namespace trefoil
