#include "input/expression.hpp"

#include <muParser.h>

#include <cctype>
#include <cmath>
#include <numbers>
#include <sstream>

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

bool has_word(const std::string &text, const std::string &word) {
  const auto is_letter = [&](std::size_t i) {
    return i < text.size() && (std::isalnum(static_cast<unsigned char>(text[i])) || text[i] == '_');
  };
  for (std::size_t at = 0; (at = text.find(word, at)) != text.npos; at += word.size()) {
    if ((at == 0 || !is_letter(at - 1)) && !is_letter(at + word.size())) return true;
  }
  return false;
}

/// What other languages write, and this one writes otherwise.
std::string hint_for(const std::string &text) {
  if (has_word(text, "and") || has_word(text, "or") || has_word(text, "not")) {
    return "; write && for and, || for or, != for not equal";
  }
  if (text.find("**") != text.npos) return "; write ^ for a power, x^2";
  return "; a formula has x, y, z, t, xmin ... zmax, pi, numbers, + - * / ^, < <= == != >= >, &&, "
         "|| and functions such as sin, sqrt, abs";
}

// muParser's operators carry no data: what the comparisons of this thread allow.
thread_local double tolerance_of_comparisons = 0;
/// Added to both sides of every comparison, where only those matter that could come out otherwise.
thread_local double slack_of_comparisons = 0;

double is_below(double a, double b) {
  return a < b + slack_of_comparisons;
}
double is_above(double a, double b) {
  return a > b - slack_of_comparisons;
}
double is_equal(double a, double b) {
  return std::abs(a - b) <= tolerance_of_comparisons + slack_of_comparisons;
}
double is_other(double a, double b) {
  return slack_of_comparisons > 0 || std::abs(a - b) > tolerance_of_comparisons;
}
double is_at_most(double a, double b) {
  return a <= b + tolerance_of_comparisons + slack_of_comparisons;
}
double is_at_least(double a, double b) {
  return a >= b - tolerance_of_comparisons - slack_of_comparisons;
}

/// All operators, since muParser keeps its own or none.
void define_tolerant_operators(mu::Parser &parser) {
  using mu::value_type;
  parser.EnableBuiltInOprt(false);
  const auto define = [&](const char *name, value_type (*function)(value_type, value_type),
                          unsigned priority, mu::EOprtAssociativity side = mu::oaLEFT) {
    parser.DefineOprt(name, function, priority, side, true);
  };
  define(
      "||", [](double a, double b) -> double { return a != 0 || b != 0; }, mu::prLOR);
  define(
      "&&", [](double a, double b) -> double { return a != 0 && b != 0; }, mu::prLAND);
  define("<", is_below, mu::prCMP);
  define(">", is_above, mu::prCMP);
  define("==", is_equal, mu::prCMP);
  define("!=", is_other, mu::prCMP);
  define("<=", is_at_most, mu::prCMP);
  define(">=", is_at_least, mu::prCMP);
  define(
      "+", [](double a, double b) { return a + b; }, mu::prADD_SUB);
  define(
      "-", [](double a, double b) { return a - b; }, mu::prADD_SUB);
  define(
      "*", [](double a, double b) { return a * b; }, mu::prMUL_DIV);
  define(
      "/", [](double a, double b) { return a / b; }, mu::prMUL_DIV);
  define(
      "^", [](double a, double b) { return std::pow(a, b); }, mu::prPOW, mu::oaRIGHT);
}

}  // namespace

double Box::diagonal() const {
  return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

struct Expression::Parser {
  mu::Parser parser;
  double x = 0, y = 0, z = 0, t = 0, free = free_value;
  bool uses_time = false, uses_place = false;
};

Expression::Expression(const std::string &text, const std::string &where_from, const Box &box)
    : Expression(text, where_from, box, Comparisons::exact) {}

Expression::Expression(const std::string &text, const std::string &where_from, const Box &box,
                       Comparisons comparisons)
    : parser_(std::make_unique<Parser>()), text_(text), where_from_(where_from) {
  if (has_assignment(text)) {
    throw InputError(where_from + ": '" + text + "' assigns a value; compare with ==");
  }
  mu::Parser &parser = parser_->parser;
  try {
    if (comparisons == Comparisons::tolerant) define_tolerant_operators(parser);
    parser.DefineVar("x", &parser_->x);
    parser.DefineVar("y", &parser_->y);
    parser.DefineVar("z", &parser_->z);
    parser.DefineVar("t", &parser_->t);
    parser.DefineVar("free", &parser_->free);
    parser.DefineConst("pi", std::numbers::pi);
    const char *axes[] = {"x", "y", "z"};
    for (std::size_t i = 0; i < 3; ++i) {
      parser.DefineConst(std::string(axes[i]) + "min", box.low[i]);
      parser.DefineConst(std::string(axes[i]) + "max", box.high[i]);
    }
    parser.SetExpr(text);
    int count = 0;
    parser.Eval(count);
    const auto &used = parser.GetUsedVar();
    parser_->uses_time = used.count("t") > 0;
    parser_->uses_place = used.count("x") + used.count("y") + used.count("z") > 0;
  } catch (const mu::Parser::exception_type &error) {
    throw InputError(where_from + ": cannot read the expression '" + text + "': " + error.GetMsg() +
                     hint_for(text));
  }
}

Expression::~Expression() = default;
Expression::Expression(Expression &&) noexcept = default;

bool Expression::uses_place() const {
  return parser_->uses_place;
}

bool Expression::uses_time() const {
  return parser_->uses_time;
}

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
    const bool of_condition = count == 1;
    throw InputError(where_from_ + ": '" + text_ + "' has " + std::to_string(found) + " value" +
                     (found == 1 ? "" : "s") + ", but " + std::to_string(count) +
                     (count == 1 ? " is wanted" : " are wanted") +
                     (of_condition ? "; write && between conditions that must both hold"
                                   : "; write one for each direction, with commas between"));
  }
  for (int i = 0; i < found; ++i) {
    if (is_free(values[i]) || std::abs(values[i]) < 1e290) continue;
    std::ostringstream when;
    if (uses_time()) when << ", t = " << time;
    throw InputError(where_from_ + ": '" + text_ + "' is not finite at (" +
                     std::to_string(position[0]) + ", " + std::to_string(position[1]) + ", " +
                     std::to_string(position[2]) + ")" + when.str());
  }
  return {values, values + found};
}

bool Expression::is_free(double value) {
  return value == free_value;
}

Condition::Condition(const std::string &text, const std::string &where_from, const Box &box,
                     double tolerance)
    : expression_(text, where_from, box, Expression::Comparisons::tolerant),
      tolerance_(tolerance) {}

bool Condition::holds(const double *position, double time) const {
  return holds_with_slack(position, time, 0);
}

bool Condition::holds_with_slack(const double *position, double time, double slack) const {
  tolerance_of_comparisons = tolerance_;
  slack_of_comparisons = slack;
  const double value = expression_.evaluate(position, time, 1)[0];
  slack_of_comparisons = 0;
  if (Expression::is_free(value)) {
    throw InputError(expression_.where_from_ +
                     ": 'free' is for displacements, not for a choice of places");
  }
  return value != 0;
}

bool Condition::holds_nearby(const double *position, double time, int dimension) const {
  constexpr double steepest = 1000;  // sides of comparisons that change faster are not looked at
  if (!holds_with_slack(position, time, steepest * tolerance_)) return false;
  for (unsigned corner = 0; corner < 1U << dimension; ++corner) {
    double moved[3] = {position[0], position[1], position[2]};
    for (int i = 0; i < dimension; ++i) moved[i] += (corner >> i & 1U) ? tolerance_ : -tolerance_;
    try {
      if (holds(moved, time)) return true;
    } catch (const InputError &) {  // not finite there: what counts is the place itself
    }
  }
  return false;
}

}  // namespace trefoil
