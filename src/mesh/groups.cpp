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

bool is_whole(const Group &group) {
  return !group.body.empty() && group.number == Group::whole;
}

/// The user's text without the group's body, "wall" of "low/wall".
std::string within_body(const Group &group, const std::string &text) {
  const std::string prefix = group.body + "/";
  return !group.body.empty() && text.rfind(prefix, 0) == 0 ? text.substr(prefix.size()) : text;
}

/// "low/wall", "wall", "low/7", "low"
std::string whole_name(const Group &group) {
  if (is_whole(group)) return group.body;
  const std::string own = group.name.empty() ? std::to_string(group.number) : group.name;
  return group.body.empty() ? own : group.body + "/" + own;
}

/// Whether the user's text means a group's name.
bool is_named(const Group &group, const std::string &text) {
  if (is_whole(group)) return text == group.body;
  return !group.name.empty() && within_body(group, text) == group.name;
}

/// Whether it means the group: its name, its number, or "surface 7".
bool is_called(const Group &group, const std::string &whole_text) {
  if (is_named(group, whole_text)) return true;
  if (is_whole(group)) return false;
  const std::string text = within_body(group, whole_text);
  const std::string kind = std::string(singular(group.dimension)) + " ";
  const std::string_view digits =
      std::string_view(text).substr(text.rfind(kind, 0) == 0 ? kind.size() : 0);
  PetscInt number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc{} && end == digits.data() + digits.size() && number == group.number;
}

/// The places of the groups of a dimension that are meant: one at most, unless several bodies have
/// one. A name counts before a number.
std::vector<std::size_t> find(const Groups &groups, const std::string &text, int dimension) {
  std::vector<std::size_t> found;
  for (const bool by_name : {true, false}) {
    if (!found.empty()) break;
    for (std::size_t g = 0; g < groups.list().size(); ++g) {
      const Group &group = groups.list()[g];
      if (group.dimension != dimension) continue;
      if (by_name ? !is_named(group, text) : !is_called(group, text)) continue;
      const bool is_first = std::none_of(found.begin(), found.end(), [&](std::size_t other) {
        return groups.list()[other].body == group.body;
      });
      if (is_first) found.push_back(g);
    }
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
              [](const Group *a, const Group *b) {
                return std::tie(a->body, a->number) < std::tie(b->body, b->number);
              });
  }
  std::string text;
  for (std::size_t k = 0; k < std::min(chosen.size(), most); ++k) {
    text += (text.empty() ? "" : ", ") + text_of(*chosen[k]);
  }
  const std::size_t others = chosen.size() - std::min(chosen.size(), most);
  return text + (others ? " and " + std::to_string(others) + " others" : "");
}

}  // namespace

int Groups::add(int dimension, PetscInt number, const std::string &body) {
  const auto [place, is_new] =
      places_.emplace(std::tuple{body, dimension, number}, static_cast<int>(list_.size()));
  if (is_new) list_.push_back({.dimension = dimension, .number = number, .body = body});
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
  const std::string kind = singular(group.dimension), name = " '" + whole_name(group) + "'";
  if (is_whole(group)) return kind + name;
  const bool has_name = !group.name.empty() || !group.body.empty();
  return kind + " " + std::to_string(group.number) + (has_name ? name : "");
}

int find_group(const Groups &groups, const std::string &text, std::span<const int> dimensions,
               const std::string &option) {
  for (const int dimension : dimensions) {
    const std::vector<std::size_t> found = find(groups, text, dimension);
    if (found.size() == 1) return static_cast<int>(found.front());
    if (found.empty()) continue;
    const Group &first = groups.list()[found.front()], &second = groups.list()[found[1]];
    throw InputError(option + ": several bodies have a group '" + text + "'; name one, as '" +
                     whole_name(first) + "' or '" + whole_name(second) + "'");
  }
  const std::string list = all_of(groups, dimensions);
  const std::string rest =
      list.empty() ? "; the mesh has no such group" : "; the mesh has: " + list;
  for (int dimension = 3; dimension >= 0; --dimension) {
    if (find(groups, text, dimension).empty()) continue;
    throw InputError(option + ": '" + text + "' is a group of " +
                     plurals[static_cast<std::size_t>(dimension)] + " where a " +
                     kinds(dimensions) + " is wanted" + rest);
  }
  throw InputError(option + ": the mesh has no group '" + text + "' that is a " +
                   kinds(dimensions) + (list.empty() ? "; it names none" : "; it has: " + list));
}

}  // namespace trefoil
