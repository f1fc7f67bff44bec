#include <string>

#include "mesh/io/gmsh.hpp"

namespace trefoil {
namespace {

constexpr std::size_t bytes_of_tag = 8;
constexpr std::size_t bytes_of_real = 8;
constexpr std::size_t bytes_of_block = 3 * 4 + 8;  // three integers and a count

struct SectionHeader {
  std::int64_t blocks;
  std::int64_t items;
};

SectionHeader read_section_header(GmshNumbers &numbers, std::size_t bytes_of_item,
                                  const char *items) {
  SectionHeader header{};
  header.blocks = numbers.checked_count(numbers.size("the number of entity blocks"), 4,
                                        bytes_of_block, "entity blocks");
  header.items =
      numbers.checked_count(numbers.size("the number of items"), 2, bytes_of_item, items);
  numbers.size("the lowest tag");
  numbers.size("the highest tag");
  return header;
}

void check_all_read(const MeshFile &file, std::int64_t read, std::int64_t announced,
                    const char *items) {
  if (read != announced)
    file.fail("the blocks hold " + std::to_string(read) + " " + items + " where " +
              std::to_string(announced) + " are announced; save the mesh again");
}

// A node on a parametrised entity carries its u, its u v or its u v w behind x y z.
std::int64_t read_parameter_count(GmshNumbers &numbers) {
  const std::int64_t dimension = numbers.integer("the dimension of an entity");
  if (dimension < 0 || dimension > 3)
    numbers.file().fail("an entity has dimension " + std::to_string(dimension) +
                        ", which is not 0 to 3; save the mesh again");
  numbers.integer("the tag of an entity");
  const std::int64_t parametric = numbers.integer("the mark of parametric nodes");
  if (parametric != 0 && parametric != 1)
    numbers.file().fail("the mark of parametric nodes is " + std::to_string(parametric) +
                        ", which is not 0 or 1; save the mesh again");
  return parametric == 1 ? dimension : 0;
}

std::int64_t read_node_block(GmshNumbers &numbers, GmshContents &contents) {
  const std::int64_t parameters = read_parameter_count(numbers);
  const std::int64_t count = numbers.checked_count(numbers.size("the number of nodes in a block"),
                                                   4, bytes_of_tag + 3 * bytes_of_real, "nodes");
  const std::size_t first = contents.node_tags.size();
  for (std::int64_t node = 0; node < count; ++node)
    contents.node_tags.push_back(numbers.size("a node tag"));
  for (std::size_t node = first; node < contents.node_tags.size(); ++node) {
    for (int component = 0; component < 3; ++component)
      contents.coordinates.push_back(read_coordinate(numbers, contents.node_tags[node]));
    for (std::int64_t parameter = 0; parameter < parameters; ++parameter)
      numbers.real("a parameter of a node");
  }
  return count;
}

std::int64_t read_element_block(GmshNumbers &numbers, GmshContents &contents) {
  const std::int64_t dimension = numbers.integer("the dimension of an entity");
  const std::int64_t entity = numbers.integer("the tag of an entity");
  const auto found = contents.set_of_entity.find({dimension, entity});
  const PetscInt set = found == contents.set_of_entity.end() ? 0 : found->second;
  const std::int64_t type = numbers.integer("an element type");
  const int nodes = nodes_of_element(numbers.file(), type);
  const auto width = static_cast<std::size_t>(1 + nodes);
  const std::int64_t count = numbers.checked_count(
      numbers.size("the number of elements in a block"), width, width * bytes_of_tag, "elements");
  for (std::int64_t element = 0; element < count; ++element) {
    const std::int64_t tag = numbers.size("an element tag");
    GmshElements *elements = contents.place_for(type, set);
    if (elements) elements->add(tag, set);
    for (int node = 0; node < nodes; ++node) {
      const std::int64_t node_tag = numbers.size("a node of an element");
      if (elements) elements->nodes.push_back(node_tag);
    }
  }
  return count;
}

}  // namespace

void read_nodes_4_1(GmshNumbers &numbers, GmshContents &contents) {
  const SectionHeader header =
      read_section_header(numbers, bytes_of_tag + 3 * bytes_of_real, "nodes");
  contents.node_tags.reserve(static_cast<std::size_t>(header.items));
  contents.coordinates.reserve(static_cast<std::size_t>(3 * header.items));
  std::int64_t read = 0;
  for (std::int64_t block = 0; block < header.blocks; ++block)
    read += read_node_block(numbers, contents);
  check_all_read(numbers.file(), read, header.items, "nodes");
}

void read_elements_4_1(GmshNumbers &numbers, GmshContents &contents) {
  const SectionHeader header = read_section_header(numbers, 2 * bytes_of_tag, "elements");
  std::int64_t read = 0;
  for (std::int64_t block = 0; block < header.blocks; ++block)
    read += read_element_block(numbers, contents);
  check_all_read(numbers.file(), read, header.items, "elements");
}

}  // namespace trefoil
