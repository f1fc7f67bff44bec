#include <algorithm>
#include <cmath>
#include <limits>

#include "rule/rule.hpp"

namespace trefoil {
namespace {

/// Newton's own Hessian, or nearly, where it is definite. After a step that the model has predicted
/// as a trust region wants it to be enlarged, 3/4 < rho < 5/4, and after one of which there is no
/// ratio (it has met boundary values, and says nothing against the model), w = 0 is tried; where
/// that Hessian turns out to be indefinite, small weights, each four times the last, and then what
/// the adaptive rule says. Newton's is tried again once the decrement has fallen by a factor of
/// `patience`; until then the weight is a quarter of the last one. Far from a minimum it is the
/// adaptive rule.
class NewtonFirstRule final : public Rule {
 public:
  explicit NewtonFirstRule(double tolerance) : tolerance_(tolerance) {}

  double first() override {
    refused_decrement_ = decrement_ = std::numeric_limits<double>::infinity();
    filtered_ = 1;
    return filtered_;
  }

  double next(const IterationRecord &last) override {
    const double error = std::abs(last.rho - 1);
    filtered_ = error < tolerance_ ? 0.5 : 1;  // 1 without a ratio
    decrement_ = last.decrement;
    if (last.weight == 0) refused_decrement_ = std::numeric_limits<double>::infinity();
    if (std::isnan(last.rho)) return 0;
    if (error >= good_model) return filtered_;
    if (decrement_ < refused_decrement_ / patience) return 0;
    return or_filtered(std::max(least, last.weight / factor));
  }

  [[nodiscard]] double least_weight() const override { return 0; }
  [[nodiscard]] bool may_be_rejected() const override { return true; }

  /// Where factors refuse the Jacobian there is no decrement yet: the last step's has to do.
  std::optional<double> rejected(const IterationRecord &refused) override {
    if (refused.weight >= 0.5) return std::nullopt;
    if (refused.weight > 0) return or_filtered(factor * refused.weight);
    refused_decrement_ = decrement_;
    return least;
  }

  [[nodiscard]] double refused_decrement() const override { return refused_decrement_; }
  void set_refused_decrement(double decrement) override { refused_decrement_ = decrement; }

  [[nodiscard]] bool uses_rho() const override { return true; }
  [[nodiscard]] bool prefers_newton() const override { return true; }

 private:
  static constexpr double good_model = 0.25, patience = 10, factor = 4, least = 1.0 / 32;

  [[nodiscard]] double or_filtered(double weight) const {
    return weight < 0.5 ? weight : filtered_;
  }

  double tolerance_;
  double filtered_ = 1;                                         ///< the adaptive rule's weight
  double decrement_ = std::numeric_limits<double>::infinity();  ///< of the last step
  /// Of the step before the Jacobian that was indefinite with w = 0.
  double refused_decrement_ = std::numeric_limits<double>::infinity();
};

}  // namespace

std::unique_ptr<Rule> make_newton_first_rule(const RuleParameters &parameters) {
  return std::make_unique<NewtonFirstRule>(parameters.rho_tolerance);
}

}  // namespace trefoil
