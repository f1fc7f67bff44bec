#include <limits>
#include <string>

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

// A list of integers behind their number.
std::vector<std::int64_t> read_list(GmshNumbers &numbers, const char *items, const char *item) {
  std::vector<std::int64_t> list(static_cast<std::size_t>(
      numbers.checked_count(numbers.size(items), 1, bytes_of_integer, items)));
  for (std::int64_t &each : list) each = numbers.integer(item);
  return list;
}

// What an entity has behind its tag: a point its position, others their box; the groups; and what
// bounds it. Returns the number of the set of its groups.
PetscInt read_extent_and_groups(GmshNumbers &numbers, std::int64_t dimension,
                                GmshContents &contents) {
  for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) numbers.real("the extent of an entity");
  std::vector<int> groups;
  for (const std::int64_t number : read_list(numbers, "the number of physical groups of an entity",
                                             "a physical group of an entity")) {
    const PetscInt group = checked_group(numbers.file(), number);
    if (group != 0) groups.push_back(contents.groups.add(static_cast<int>(dimension), group));
  }
  if (dimension > 0)
    read_list(numbers, "the number of entities that bound another", "a bounding entity");
  return contents.groups.set_of(std::move(groups));
}

// Calls read(dimension) for each of the entities whose numbers come next: points, curves, surfaces,
// volumes.
template <class Read>
void for_each_entity(GmshNumbers &numbers, const Read &read) {
  std::int64_t counts[4];
  for (std::int64_t &count : counts)
    count = numbers.checked_count(numbers.size("the number of entities"), 5,
                                  bytes_of_integer + 3 * bytes_of_real + bytes_of_size, "entities");
  for (std::int64_t dimension = 0; dimension < 4; ++dimension)
    for (std::int64_t k = 0; k < counts[dimension]; ++k) read(dimension);
}

}  // namespace

PetscInt checked_group(const MeshFile &file, std::int64_t number) {
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  if (number < -most || number > most)
    file.fail("a physical group has the number " + std::to_string(number) +
              ", which is out of range; save the mesh again");
  return static_cast<PetscInt>(number < 0 ? -number : number);
}

void read_physical_names(MeshFile &file, GmshContents &contents) {
  const std::int64_t count = file.integer("the number of physical names");
  constexpr std::size_t shortest_line = 6;  // 3 1 ""
  file.check_room(count, shortest_line, "physical names");
  for (std::int64_t k = 0; k < count; ++k) {
    const std::int64_t dimension =
        checked_dimension(file, file.integer("the dimension of a physical group"));
    const PetscInt number = checked_group(file, file.integer("the number of a physical group"));
    const int group = contents.groups.add(static_cast<int>(dimension), number);
    contents.groups.name(group, file.quotation("the name of a physical group"));
  }
}

void read_entities_4_1(GmshNumbers &numbers, GmshContents &contents) {
  for_each_entity(numbers, [&](std::int64_t dimension) {
    const std::int64_t entity = numbers.integer("the tag of an entity");
    contents.set_of_entity[{dimension, entity}] =
        read_extent_and_groups(numbers, dimension, contents);
  });
}

void read_partitioned_entities_4_1(GmshNumbers &numbers, GmshContents &contents) {
  numbers.size("the number of partitions");
  const std::int64_t ghosts = numbers.checked_count(numbers.size("the number of ghost entities"), 2,
                                                    2 * bytes_of_integer, "ghost entities");
  for (std::int64_t k = 0; k < ghosts; ++k) {
    numbers.integer("the tag of a ghost entity");
    numbers.integer("the partition of a ghost entity");
  }
  for_each_entity(numbers, [&](std::int64_t dimension) {
    const std::int64_t entity = numbers.integer("the tag of an entity");
    const std::int64_t parent_dimension = numbers.integer("the dimension of an entity's parent");
    const std::int64_t parent = numbers.integer("the tag of an entity's parent");
    read_list(numbers, "the number of partitions of an entity", "a partition of an entity");
    PetscInt set = read_extent_and_groups(numbers, dimension, contents);
    // The groups of its parent are repeated with it; where they are not, they are its own.
    const auto found = contents.set_of_entity.find({dimension, parent});
    if (set == 0 && parent_dimension == dimension && found != contents.set_of_entity.end())
      set = found->second;
    contents.set_of_entity[{dimension, entity}] = set;
  });
}

}  // namespace trefoil
