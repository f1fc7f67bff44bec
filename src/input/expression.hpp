#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace trefoil {

/// The box of a mesh, which formulas know as xmin ... zmax.
struct Box {
  std::array<double, 3> low{}, high{};
  [[nodiscard]] double diagonal() const;
};

/// A formula of the user in rest position x y z, time t and the mesh's box xmin..zmax, compiled by
/// muParser; pi is known. One or several values: "1 + x", or "0, 0, 0.5*sin(pi*x)".
class Expression {
 public:
  /// @param text the formula
  /// @param where_from for messages: whose formula it is, for example "-constraint_hind_move"
  /// @throws InputError for a malformed formula, an unknown name or an assignment
  Expression(const std::string &text, const std::string &where_from, const Box &box);
  ~Expression();
  Expression(const Expression &) = delete;
  Expression &operator=(const Expression &) = delete;
  Expression(Expression &&) noexcept;

  /// The values at a point; is_free() tells those that are the word `free`.
  /// @throws InputError where a value is not finite, or there are not `count` values
  [[nodiscard]] std::vector<double> evaluate(const double *position, double time,
                                             std::size_t count) const;

  /// Whether the formula depends on t.
  [[nodiscard]] bool uses_time() const;
  /// Whether it depends on x, y or z.
  [[nodiscard]] bool uses_place() const;

  /// Whether a value is the word `free`: the component is not prescribed.
  static bool is_free(double value);

 private:
  friend class Condition;
  struct Parser;
  enum class Comparisons { exact, tolerant };
  Expression(const std::string &text, const std::string &where_from, const Box &box,
             Comparisons comparisons);

  std::unique_ptr<Parser> parser_;
  std::string text_, where_from_;
};

/// A formula that chooses places: true where its value is not 0. In it a == b, a <= b and a >= b
/// hold within a tolerance, as coordinates are rarely exact; a < b and a > b are as they say.
class Condition {
 public:
  /// @param tolerance the most that the two sides of ==, <=, >= may be off
  /// @throws InputError like an Expression
  Condition(const std::string &text, const std::string &where_from, const Box &box,
            double tolerance);

  /// @throws InputError where the value is not finite, `free`, or not one value
  [[nodiscard]] bool holds(const double *position, double time) const;

  /// Whether it holds at a corner of the cube around the position whose faces are the tolerance
  /// away. That is, whether moving the place by so little could change the choice.
  [[nodiscard]] bool holds_nearby(const double *position, double time, int dimension) const;

  [[nodiscard]] bool uses_time() const { return expression_.uses_time(); }

 private:
  [[nodiscard]] bool holds_with_slack(const double *position, double time, double slack) const;

  Expression expression_;
  double tolerance_;
};

}  // namespace trefoil
