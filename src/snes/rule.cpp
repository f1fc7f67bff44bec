#include "snes/rule.hpp"

#include <array>
#include <utility>

namespace trefoil {
namespace {

// The registry: a new rule is one file and one line here.
constexpr std::array<std::pair<const char *, RuleFactory>, 5> registry{{
    {"newton", make_newton_rule},
    {"clamp", make_clamp_rule},
    {"absolute", make_absolute_rule},
    {"adaptive", make_adaptive_rule},
    {"constant", make_constant_rule},
}};

}  // namespace

std::unique_ptr<Rule> make_rule(const std::string &name, const RuleParameters &parameters) {
  for (const auto &[known, factory] : registry) {
    if (name == known) return factory(parameters);
  }
  return nullptr;
}

const std::vector<std::string> &rule_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const auto &entry : registry) list.emplace_back(entry.first);
    return list;
  }();
  return names;
}

}  // namespace trefoil
