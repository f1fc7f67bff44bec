#include "scene/expression.hpp"

#include <muParser.h>

#include <cmath>
#include <numbers>

#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

// `free` is a variable with a value that no formula means.
constexpr double free_value = -0x1.5a5a5a5a5a5a5p+1000;

/// muParser would take `x = 3` as an assignment and change x for all that follows.
bool has_assignment(const std::string &text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    const bool comparison = i > 0 && std::string("<>!=").find(text[i - 1]) != std::string::npos;
    if (!comparison && (i + 1 >= text.size() || text[i + 1] != '=')) return true;
    if (!comparison) ++i;  // the second sign of ==
  }
  return false;
}

}  // namespace

struct Expression::Parser {
  mu::Parser parser;
  double x = 0, y = 0, z = 0, t = 0, free = free_value;
};

Expression::Expression(const std::string &text, const std::string &where_from,
                       const std::array<double, 3> &box_min, const std::array<double, 3> &box_max)
    : parser_(std::make_unique<Parser>()), text_(text), where_from_(where_from) {
  if (has_assignment(text)) {
    throw InputError(where_from + ": '" + text + "' assigns a value; compare with ==");
  }
  mu::Parser &parser = parser_->parser;
  try {
    parser.DefineVar("x", &parser_->x);
    parser.DefineVar("y", &parser_->y);
    parser.DefineVar("z", &parser_->z);
    parser.DefineVar("t", &parser_->t);
    parser.DefineVar("free", &parser_->free);
    parser.DefineConst("pi", std::numbers::pi);
    const char *axes[] = {"x", "y", "z"};
    for (std::size_t i = 0; i < 3; ++i) {
      parser.DefineConst(std::string(axes[i]) + "min", box_min[i]);
      parser.DefineConst(std::string(axes[i]) + "max", box_max[i]);
    }
    parser.SetExpr(text);
    int count = 0;
    parser.Eval(count);
  } catch (const mu::Parser::exception_type &error) {
    throw InputError(where_from + ": cannot read the expression '" + text + "': " + error.GetMsg());
  }
}

Expression::~Expression() = default;

std::vector<double> Expression::evaluate(const double *position, double time,
                                         std::size_t count) const {
  parser_->x = position[0];
  parser_->y = position[1];
  parser_->z = position[2];
  parser_->t = time;
  int found = 0;
  const double *values = nullptr;
  try {
    values = parser_->parser.Eval(found);
  } catch (const mu::Parser::exception_type &error) {
    throw InputError(where_from_ + ": cannot evaluate '" + text_ + "': " + error.GetMsg());
  }
  if (static_cast<std::size_t>(found) != count) {
    throw InputError(where_from_ + ": '" + text_ + "' has " + std::to_string(found) +
                     " values, but " + std::to_string(count) + " are wanted");
  }
  for (int i = 0; i < found; ++i) {
    if (is_free(values[i]) || std::abs(values[i]) < 1e290) continue;
    throw InputError(where_from_ + ": '" + text_ + "' is not finite at (" +
                     std::to_string(position[0]) + ", " + std::to_string(position[1]) + ", " +
                     std::to_string(position[2]) + ")");
  }
  return {values, values + found};
}

bool Expression::is_free(double value) {
  return value == free_value;
}

}  // namespace trefoil
