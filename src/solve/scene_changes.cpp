#include "solve/scene_changes.hpp"

#include <algorithm>
#include <set>

namespace trefoil {

namespace {

/// Of options by name those that begin with one of some words.
template <class Words>
std::map<std::string, std::string> beginning_with(const Words &words,
                                                  const std::map<std::string, std::string> &given) {
  std::map<std::string, std::string> kept;
  for (const auto &[name, value] : given) {
    const bool counts = std::any_of(std::begin(words), std::end(words),
                                    [&](const char *word) { return name.rfind(word, 0) == 0; });
    if (counts) kept[name] = value;
  }
  return kept;
}

}  // namespace

std::map<std::string, std::string> options_of_energy(
    const std::map<std::string, std::string> &given) {
  static const char *const beginnings[] = {
      "material_",  "region",       "constraint",      "load_",           "loads",
      "contact",    "obstacle",     "time_mass",       "time_integrator", "time_beta",
      "time_gamma", "time_damping", "element_pressure"};
  std::map<std::string, std::string> kept = beginning_with(beginnings, given);
  std::erase_if(kept, [](const auto &option) { return option.first.rfind("load_steps", 0) == 0; });
  return kept;
}

std::map<std::string, std::string> options_of_way(const std::map<std::string, std::string> &given) {
  static const char *const beginnings[] = {"load_steps", "initial", "time_"};
  return beginning_with(beginnings, given);
}

std::string differences(const std::map<std::string, std::string> &there,
                        const std::map<std::string, std::string> &here) {
  const auto text = [](const std::map<std::string, std::string> &options, const std::string &name) {
    const auto found = options.find(name);
    return found == options.end() ? "none" : found->second;
  };
  std::set<std::string> names;
  for (const auto *options : {&there, &here}) {
    for (const auto &option : *options) names.insert(option.first);
  }
  std::string list;
  for (const std::string &name : names) {
    const std::string before = text(there, name), now = text(here, name);
    if (before == now) continue;
    list += (list.empty() ? "-" : "; -") + name + " " + before + " there, " + now + " here";
  }
  return list;
}

}  // namespace trefoil
