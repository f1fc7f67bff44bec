#pragma once

#include <petscsystypes.h>

#include <array>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace trefoil {

/// A part of a mesh that its file names or numbers: a physical group of Gmsh's, or what has one
/// reference in a Medit file. Groups of different dimensions may have the same number and name.
struct Group {
  int dimension = 3;    ///< of what is in it: 0 points, 1 curves, 2 surfaces, 3 volumes
  PetscInt number = 0;  ///< as the file has it
  std::string name{};   ///< empty: it has only its number
  PetscInt count = 0;   ///< points, edges, faces or cells in it, of a distributed mesh on all ranks
  std::string body{};   ///< of several bodies the one that it belongs to

  /// The number of the group of all cells of one of several bodies.
  static constexpr PetscInt whole = std::numeric_limits<PetscInt>::min();
};

/// Those entities of one dimension below the cells' that are in groups: each by its corners'
/// vertices, and by the number of the set of groups that it is in.
struct GroupedEntities {
  std::vector<PetscInt> vertices;  ///< entities x corners
  std::vector<PetscInt> sets;      ///< of each entity

  [[nodiscard]] std::size_t size() const { return sets.size(); }
};

/// The groups of a mesh, and what is in them. An entity may be in several groups; few different
/// sets of groups occur, so each entity has the number of one. Set 0 is empty.
class Groups {
 public:
  std::vector<PetscInt> set_of_cell;     ///< of each cell; empty: no cell is in a group
  std::array<GroupedEntities, 3> below;  ///< points, edges and, of a volume mesh, faces

  [[nodiscard]] const std::vector<Group> &list() const { return list_; }
  /// Each an ascending list of places in list().
  [[nodiscard]] const std::vector<std::vector<int>> &sets() const { return sets_; }
  /// Whether each set has a group in it.
  [[nodiscard]] std::vector<char> sets_with(int group) const;

  /// Place in list() of the group of this number, of a body where there are several, which is made
  /// where there is none.
  int add(int dimension, PetscInt number, const std::string &body = "");
  /// Names a group that has no name yet.
  void name(int group, const std::string &name);
  void set_count(int group, PetscInt count) {
    list_[static_cast<std::size_t>(group)].count = count;
  }
  /// Number of the set of these groups, which is made where there is none.
  PetscInt set_of(std::vector<int> groups);
  /// Number of the set of the group of this number alone; fast where the same is asked again.
  PetscInt set_of(int dimension, PetscInt number);
  /// Number of the set of the groups of both sets.
  PetscInt joined(PetscInt one, PetscInt other);

 private:
  std::vector<Group> list_;
  std::vector<std::vector<int>> sets_{{}};
  std::map<std::tuple<std::string, int, PetscInt>, int> places_;
  std::map<std::vector<int>, PetscInt> numbers_{{{}, 0}};
  int last_group_ = -1;  // that set_of(dimension, number) was asked for
  PetscInt last_set_ = 0;
};

/// "surface 7 'wall'"; of one of several bodies "surface 7 'low/wall'"
std::string text_of(const Group &group);

/// The group that the user calls `text`: by its name, by its number, or by both kind and number, as
/// "surface 7" or "curve 7". Of several bodies each has its own, "low/wall", "low/surface 7"; what
/// one body only has is also called by its own name. All cells of a body are called by its name.
/// @param dimensions what will do, in the order in which it is looked for
/// @param option whose value `text` is, for errors, "-load_wind_group"
/// @return its place in groups.list()
/// @throws InputError, which lists the groups that will do, where there is none; or which says that
/// the group is of another dimension, or that several bodies have it
int find_group(const Groups &groups, const std::string &text, std::span<const int> dimensions,
               const std::string &option);

}  // namespace trefoil
