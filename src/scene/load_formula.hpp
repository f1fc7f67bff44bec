#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "input/expression.hpp"
#include "input/selection.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {

/// A formula of a load: scaled by t, where that is no time, unless it depends on it.
class LoadFormula {
 public:
  /// @param grows whether what does not depend on t is scaled by it
  LoadFormula(const Mesh &mesh, const std::string &text, std::string option, bool grows)
      : dimension_(static_cast<std::size_t>(mesh.dimension())),
        option_(std::move(option)),
        expression_(text, option_, box_of(mesh)),
        is_scaled_(grows && !expression_.uses_time()) {}

  /// Throws InputError.
  [[nodiscard]] std::array<double, 3> vector(const std::array<double, 3> &at, double time) const {
    const std::vector<double> values = evaluate(at, time, dimension_);
    return {values[0], values[1], dimension_ == 3 ? values[2] : 0};
  }
  [[nodiscard]] double scalar(const std::array<double, 3> &at, double time) const {
    return evaluate(at, time, 1)[0];
  }

  [[nodiscard]] bool uses_time() const { return expression_.uses_time(); }

 private:
  [[nodiscard]] std::vector<double> evaluate(const std::array<double, 3> &at, double time,
                                             std::size_t count) const {
    std::vector<double> values = expression_.evaluate(at.data(), time, count);
    if (std::any_of(values.begin(), values.end(), Expression::is_free)) {
      throw InputError(option_ + ": 'free' is for displacements, not for loads");
    }
    if (is_scaled_) {
      for (double &value : values) value *= time;
    }
    return values;
  }

  std::size_t dimension_;
  std::string option_;
  Expression expression_;
  bool is_scaled_;
};

}  // namespace trefoil
