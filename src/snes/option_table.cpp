#include "snes/option_table.hpp"

#include <sstream>

const char *const TrefoilSearches[] = {"armijo", "subspace", "TrefoilSearch", "TREFOIL_SEARCH_",
                                       nullptr};
const char *const TrefoilProxies[] = {"hessian",      "mass",           "identity",
                                      "TrefoilProxy", "TREFOIL_PROXY_", nullptr};
const char *const TrefoilSpaces[] = {"element", "deformation", "TrefoilSpace", "TREFOIL_SPACE_",
                                     nullptr};

namespace trefoil {
namespace {

bool is_positive_share(double value) {
  return value > 0 && value < 1;
}
bool is_not_negative(double value) {
  return value >= 0;
}
constexpr const char *not_negative = "must not be negative";

const char *without_planes(const SolverOptions &options) {
  return options.search.kind == TREFOIL_SEARCH_SUBSPACE ? nullptr : "-snes_trefoil_search armijo";
}

/// Search `subspace` begins once |rho - 1| is below the tolerance as well.
const char *without_rho(const SolverOptions &options) {
  if (!without_planes(options) && !options.search.trust_start) return nullptr;
  const auto rule = make_rule(options.filter, options.rule);
  return rule && rule->uses_rho() ? nullptr : "this -snes_trefoil_filter";
}

}  // namespace

std::string join(const std::vector<std::string> &words) {
  std::ostringstream text;
  for (std::size_t i = 0; i < words.size(); ++i) text << (i ? ", " : "") << words[i];
  return text.str();
}

static std::vector<std::string> names_of(const char *const *enumeration) {
  std::vector<std::string> names;
  // The last two strings are the type's name and the prefix of its constants.
  for (; enumeration[2]; ++enumeration) names.emplace_back(*enumeration);
  return names;
}

/// When a solve has come to its end.
static std::vector<Option> rows_of(StopOptions &stop) {
  return {
      {"snes_trefoil_decrement_tolerance",
       "Stop when the Newton decrement |g'd|/2 is below (energy units, 0 off)",
       Number{&stop.decrement_tolerance, is_not_negative, not_negative}},
      {"snes_trefoil_energy_tolerance",
       "Stop when the decrement over the energy scale is below (dimensionless, 0 off; off where "
       "decrement_tolerance is set)",
       Number{&stop.energy_tolerance, is_not_negative, not_negative}, &stop.energy_tolerance_set},
      {"snes_trefoil_direction_tolerance",
       "Stop when the direction is no larger, at filter weights up to 1/2: no entry of it, or no "
       "point's vector where the host says so (units of the unknowns, 0 off)",
       Number{&stop.direction_tolerance, is_not_negative, not_negative}},
      {"snes_trefoil_take_last",
       "The direction that meets a stop test is followed before the solve ends", &stop.takes_last},
      {"snes_trefoil_verify_minimum",
       "Where the stop test is met, look for negative curvature of the unfiltered Hessian, and "
       "leave a saddle along it (off where decrement_tolerance is set)",
       &stop.verify_minimum, &stop.verify_minimum_set},
      {"snes_trefoil_verify_share",
       "verify_minimum with an iterative solver: the most that it may take, as a share of the "
       "solve; 0: no bound",
       Number{&stop.verify_share, is_not_negative, not_negative}},
  };
}

std::vector<Option> table_of(SolverOptions &options) {
  SearchOptions &search = options.search;
  std::vector<Option> table = {
      {"snes_trefoil_filter", "Filter of the element Hessians: " + join(rule_names()),
       NamedChoice{rule_names(), &options.filter, "filter"}},
      {"snes_trefoil_rho_tolerance",
       "adaptive: clamp while |rho - 1| is below this (dimensionless)",
       Number{&options.rule.rho_tolerance, is_not_negative, not_negative}, nullptr, without_rho},
      {"snes_trefoil_weight", "constant: w of H + 2 w N; 0 Newton, 0.5 clamp, 1 absolute",
       Number{&options.rule.weight, is_not_negative, not_negative}, &options.weight_set},
      {"snes_trefoil_floor",
       "Least eigenvalue of a filtered element, as a share of its largest; 0 none; negative: the "
       "filter's own (tikhonov 1e-3, others none)",
       Number{&options.floor, [](double value) { return value < 1; },
              "must be below 1, a share of the largest eigenvalue"}},
      {"snes_trefoil_space",
       "What is filtered: element, the element's Hessian; deformation, dP/dF at its quadrature "
       "points",
       NamedChoice{names_of(TrefoilSpaces), &options.space, "space"}},
      {"snes_trefoil_fields", "Fields to filter, by name or number, separated by commas",
       &options.fields},
      {"snes_trefoil_strict",
       "A Jacobian that cannot be filtered is an error; false: pass it unfiltered and count it in "
       "the record",
       &options.strict},
      {"snes_trefoil_search",
       "Search: armijo, along the direction; subspace, in the plane of it and the previous step, "
       "with Shamanskii steps",
       NamedChoice{names_of(TrefoilSearches), &search.kind, "search"}},
      {"snes_trefoil_proxy",
       "Matrix P of the direction -P^-1 g: hessian, the filtered one; mass, as the host gives it; "
       "identity, gradient descent",
       NamedChoice{names_of(TrefoilProxies), &search.proxy, "proxy"}},
      {"snes_trefoil_continue",
       "Filter and search go on from the end of the last solve of the same SNES", &search.goes_on},
      {"snes_trefoil_corrections",
       "subspace: most Shamanskii steps an iteration, by the same linear solver; -1: 8 where it is "
       "direct, else 0",
       WholeNumber{&search.shamanskii_steps, [](double value) { return value >= -1; },
                   "must be at least -1"},
       nullptr, without_planes},
      {"snes_trefoil_correction_gain",
       "subspace: least share of the first step's decrease to go on",
       Number{&search.shamanskii_gain, is_not_negative, not_negative}, nullptr, without_planes},
      {"snes_trefoil_newton_steps",
       "Most steps of conjugate gradients on the unfiltered Hessian that turn a filtered direction "
       "into Newton's, by the same linear solver; -1: 8 with filter newton_first where it is "
       "direct, else 0",
       WholeNumber{&search.newton_steps, [](double value) { return value >= -1; },
                   "must be at least -1"}},
      {"snes_trefoil_trust_start",
       "subspace: from the first iteration; false: once |rho - 1| is small", &search.trust_start,
       nullptr, without_planes},
  };
  const std::vector<Option> ends = rows_of(options.stop);
  table.insert(table.end(), ends.begin(), ends.end());
  table.insert(table.end(),
               {
                   {"snes_trefoil_monitor", "One line an iteration", &options.monitor},
                   {"snes_trefoil_record", "Write a JSON record of the solve to a file",
                    &options.record_file},
                   {"snes_linesearch_shrink", "Factor from a step length to the next",
                    Number{&search.shrink, is_positive_share, "must lie between 0 and 1"}},
                   {"snes_linesearch_armijo", "Share of the predicted decrease to reach",
                    Number{&search.armijo, [](double value) { return value >= 0 && value < 0.5; },
                           "must be at least 0 and below 0.5"}},
               });
  return table;
}

std::string name_in(const NamedChoice &choice) {
  if (auto *search = std::get_if<TrefoilSearch *>(&choice.value)) return TrefoilSearches[**search];
  if (auto *space = std::get_if<TrefoilSpace *>(&choice.value)) return TrefoilSpaces[**space];
  if (auto *proxy = std::get_if<TrefoilProxy *>(&choice.value)) return TrefoilProxies[**proxy];
  return *std::get<std::string *>(choice.value);
}

void choose(const NamedChoice &choice, std::size_t i) {
  if (auto *name = std::get_if<std::string *>(&choice.value)) **name = choice.names[i];
  if (auto *search = std::get_if<TrefoilSearch *>(&choice.value)) {
    **search = static_cast<TrefoilSearch>(i);
  }
  if (auto *space = std::get_if<TrefoilSpace *>(&choice.value)) {
    **space = static_cast<TrefoilSpace>(i);
  }
  if (auto *proxy = std::get_if<TrefoilProxy *>(&choice.value)) {
    **proxy = static_cast<TrefoilProxy>(i);
  }
}

std::string text_of(const Option &option) {
  std::ostringstream text;
  if (auto *number = std::get_if<Number>(&option.value)) text << *number->value;
  if (auto *whole = std::get_if<WholeNumber>(&option.value)) text << *whole->value;
  if (auto *choice = std::get_if<NamedChoice>(&option.value)) text << name_in(*choice);
  if (auto *flag = std::get_if<bool *>(&option.value)) text << (**flag ? "true" : "false");
  if (auto *string = std::get_if<std::string *>(&option.value)) text << **string;
  return text.str();
}

std::string manual_of_options() {
  SolverOptions defaults;
  std::ostringstream text;
  for (const Option &option : table_of(defaults)) {
    text << '-' << option.name << " <" << text_of(option) << "> - " << option.help << '\n';
  }
  return text.str();
}

}  // namespace trefoil
