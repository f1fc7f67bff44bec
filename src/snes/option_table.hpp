#pragma once

#include <string>
#include <variant>
#include <vector>

#include "snes/solver_options.hpp"

namespace trefoil {

/// A number and the values that make sense.
struct Number {
  double *value;
  bool (*makes_sense)(double);
  const char *condition;  ///< what follows "... is -1 and "
};
struct WholeNumber {
  int *value;
  bool (*makes_sense)(double);
  const char *condition;
};
/// One of several names.
struct NamedChoice {
  std::vector<std::string> names;
  std::variant<std::string *, TrefoilSearch *, TrefoilSpace *, TrefoilProxy *> value;
  const char *noun;
};

struct Option {
  const char *name;  ///< behind the SNES's prefix
  std::string help;
  std::variant<Number, WholeNumber, NamedChoice, bool *, std::string *> value;
  bool *given = nullptr;  ///< set where the user gives it
  /// With what the option has no effect, as the options are now; null: it has one.
  const char *(*idle)(const SolverOptions &options) = nullptr;
};

/// The table of options; values go to `options`. Parsing, the check of misspelt names, -help, view,
/// and the list in the line search's manual page come from it.
std::vector<Option> table_of(SolverOptions &options);

/// The name that a choice has now.
std::string name_in(const NamedChoice &choice);
/// Makes the i-th name the choice.
void choose(const NamedChoice &choice, std::size_t i);
/// The present value as one would write it.
std::string text_of(const Option &option);

/// Words with commas between them.
std::string join(const std::vector<std::string> &words);

}  // namespace trefoil
