#include <cstdlib>

#include "mesh/io/gmsh.hpp"

namespace trefoil {
namespace {

constexpr std::size_t bytes_of_integer = 4, bytes_of_size = 8, bytes_of_real = 8;

std::int64_t checked_dimension(const MeshFile &file, std::int64_t dimension) {
  if (dimension < 0 || dimension > 3)
    file.fail("a physical group has dimension " + std::to_string(dimension) +
              ", which is not 0 to 3; save the mesh again");
  return dimension;
}

// The groups of an entity. A negative number is the group of that number, turned round.
void read_groups_of_entity(GmshNumbers &numbers, std::int64_t dimension, std::int64_t entity,
                           GmshGroups &groups) {
  const std::int64_t count =
      numbers.checked_count(numbers.size("the number of physical groups of an entity"), 1,
                            bytes_of_integer, "physical groups");
  for (std::int64_t group = 0; group < count; ++group) {
    const std::int64_t number = numbers.integer("a physical group of an entity");
    groups.of_entity.emplace(GmshGroups::Key{dimension, entity}, std::abs(number));
  }
}

// A point: its tag, position and groups. Others: tag, box, groups and bounding entities.
void read_entity(GmshNumbers &numbers, std::int64_t dimension, GmshGroups &groups) {
  const std::int64_t entity = numbers.integer("the tag of an entity");
  for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) numbers.real("the extent of an entity");
  read_groups_of_entity(numbers, dimension, entity, groups);
  if (dimension == 0) return;
  const std::int64_t count =
      numbers.checked_count(numbers.size("the number of entities that bound another"), 1,
                            bytes_of_integer, "bounding entities");
  for (std::int64_t k = 0; k < count; ++k) numbers.integer("a bounding entity");
}

}  // namespace

void read_physical_names(MeshFile &file, GmshGroups &groups) {
  const std::int64_t count = file.integer("the number of physical names");
  constexpr std::size_t shortest_line = 6;  // 3 1 ""
  file.check_room(count, shortest_line, "physical names");
  for (std::int64_t k = 0; k < count; ++k) {
    const std::int64_t dimension =
        checked_dimension(file, file.integer("the dimension of a physical group"));
    const std::int64_t number = file.integer("the number of a physical group");
    groups.of_dimension[dimension].emplace(file.quotation("the name of a physical group"), number);
  }
}

void read_entities_4_1(GmshNumbers &numbers, GmshGroups &groups) {
  std::int64_t counts[4];
  for (std::int64_t &count : counts)
    count = numbers.checked_count(numbers.size("the number of entities"), 5,
                                  bytes_of_integer + 3 * bytes_of_real + bytes_of_size, "entities");
  for (std::int64_t dimension = 0; dimension < 4; ++dimension)
    for (std::int64_t k = 0; k < counts[dimension]; ++k) read_entity(numbers, dimension, groups);
}

}  // namespace trefoil
