#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace trefoil {

/// A formula of the user in rest position x y z, time t and the mesh's box xmin..zmax, compiled by
/// muParser; pi is known. One or several values: "z < zmin + 0.1", or "0, 0, 0.5*sin(pi*x)".
class Expression {
 public:
  /// @param text the formula
  /// @param where_from for messages: whose formula it is, for example "-constraint_hind_where"
  /// @throws InputError for a malformed formula, an unknown name or an assignment
  Expression(const std::string &text, const std::string &where_from,
             const std::array<double, 3> &box_min, const std::array<double, 3> &box_max);
  ~Expression();
  Expression(const Expression &) = delete;
  Expression &operator=(const Expression &) = delete;

  /// The values at a point; is_free() tells those that are the word `free`.
  /// @throws InputError where a value is not finite, or there are not `count` values
  std::vector<double> evaluate(const double *position, double time, std::size_t count) const;

  /// Whether a value is the word `free`: the component is not prescribed.
  static bool is_free(double value);

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
  std::string text_, where_from_;
};

}  // namespace trefoil
