#include "mesh/groups.hpp"

#include <algorithm>
#include <charconv>

#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

constexpr const char *singulars[] = {"point", "curve", "surface", "volume"};
constexpr const char *plurals[] = {"points", "curves", "surfaces", "volumes"};

const char *singular(int dimension) {
  return singulars[static_cast<std::size_t>(dimension)];
}

/// Whether the user's text means a group: its name, its number, or "surface 7".
bool is_called(const Group &group, const std::string &text) {
  if (!group.name.empty() && text == group.name) return true;
  const std::string kind = std::string(singular(group.dimension)) + " ";
  const std::string_view digits =
      std::string_view(text).substr(text.rfind(kind, 0) == 0 ? kind.size() : 0);
  PetscInt number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc{} && end == digits.data() + digits.size() && number == group.number;
}

/// The place of a group of a dimension; -1: there is none. A name counts before a number.
int find(const Groups &groups, const std::string &text, int dimension) {
  int found = -1;
  for (std::size_t g = 0; g < groups.list().size(); ++g) {
    const Group &group = groups.list()[g];
    if (group.dimension != dimension || !is_called(group, text)) continue;
    if (group.name == text) return static_cast<int>(g);
    found = static_cast<int>(g);
  }
  return found;
}

/// "surface", "surface, curve or point"
std::string kinds(std::span<const int> dimensions) {
  std::string text;
  for (std::size_t k = 0; k < dimensions.size(); ++k) {
    text += k == 0 ? "" : k + 1 == dimensions.size() ? " or " : ", ";
    text += singular(dimensions[k]);
  }
  return text;
}

/// "surface 7 'wall', curve 2", or nothing; of many groups the first.
std::string all_of(const Groups &groups, std::span<const int> dimensions) {
  constexpr std::size_t most = 20;
  std::vector<const Group *> chosen;
  for (const int dimension : dimensions) {
    const auto begin = chosen.size();
    for (const Group &group : groups.list()) {
      if (group.dimension == dimension) chosen.push_back(&group);
    }
    std::sort(chosen.begin() + static_cast<std::ptrdiff_t>(begin), chosen.end(),
              [](const Group *a, const Group *b) { return a->number < b->number; });
  }
  std::string text;
  for (std::size_t k = 0; k < std::min(chosen.size(), most); ++k) {
    text += (text.empty() ? "" : ", ") + text_of(*chosen[k]);
  }
  const std::size_t others = chosen.size() - std::min(chosen.size(), most);
  return text + (others ? " and " + std::to_string(others) + " others" : "");
}

}  // namespace

int Groups::add(int dimension, PetscInt number) {
  const auto [place, is_new] =
      places_.emplace(std::pair{dimension, number}, static_cast<int>(list_.size()));
  if (is_new) list_.push_back({dimension, number});
  return place->second;
}

void Groups::name(int group, const std::string &name) {
  std::string &known = list_[static_cast<std::size_t>(group)].name;
  if (known.empty()) known = name;
}

PetscInt Groups::set_of(std::vector<int> groups) {
  std::sort(groups.begin(), groups.end());
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  const auto [entry, is_new] = numbers_.emplace(groups, static_cast<PetscInt>(sets_.size()));
  if (is_new) sets_.push_back(std::move(groups));
  return entry->second;
}

PetscInt Groups::set_of(int dimension, PetscInt number) {
  const bool is_last = last_group_ >= 0 &&
                       list_[static_cast<std::size_t>(last_group_)].dimension == dimension &&
                       list_[static_cast<std::size_t>(last_group_)].number == number;
  if (!is_last) {
    last_group_ = add(dimension, number);
    last_set_ = set_of({last_group_});
  }
  return last_set_;
}

PetscInt Groups::joined(PetscInt one, PetscInt other) {
  if (one == other) return one;
  std::vector<int> both = sets_[static_cast<std::size_t>(one)];
  const std::vector<int> &second = sets_[static_cast<std::size_t>(other)];
  both.insert(both.end(), second.begin(), second.end());
  return set_of(std::move(both));
}

std::vector<char> Groups::sets_with(int group) const {
  std::vector<char> with;
  for (const std::vector<int> &set : sets_) {
    with.push_back(std::binary_search(set.begin(), set.end(), group));
  }
  return with;
}

std::string text_of(const Group &group) {
  return std::string(singular(group.dimension)) + " " + std::to_string(group.number) +
         (group.name.empty() ? "" : " '" + group.name + "'");
}

int find_group(const Groups &groups, const std::string &text, std::span<const int> dimensions,
               const std::string &option) {
  for (const int dimension : dimensions) {
    const int found = find(groups, text, dimension);
    if (found >= 0) return found;
  }
  const std::string list = all_of(groups, dimensions);
  const std::string rest =
      list.empty() ? "; the mesh has no such group" : "; the mesh has: " + list;
  for (int dimension = 3; dimension >= 0; --dimension) {
    if (find(groups, text, dimension) < 0) continue;
    throw InputError(option + ": '" + text + "' is a group of " +
                     plurals[static_cast<std::size_t>(dimension)] + " where a " +
                     kinds(dimensions) + " is wanted" + rest);
  }
  throw InputError(option + ": the mesh has no group '" + text + "' that is a " +
                   kinds(dimensions) + (list.empty() ? "; it names none" : "; it has: " + list));
}

}  // namespace trefoil
