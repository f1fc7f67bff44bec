#include <petscsnes.h>

#include <string>

#include "rule/rule.hpp"
#include "snes/solve_context.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// A rule that a host has registered through the C API.
class UserRule final : public Rule {
 public:
  UserRule(SNES snes, TrefoilRuleFunction function, void *context)
      : snes_(snes), function_(function), context_(context) {}

  double first() override { return ask(nullptr); }

  double next(const IterationRecord &last) override {
    const TrefoilIteration iteration{last.k,    last.energy, last.weight,    last.rho,
                                     last.step, last.trials, last.decrement, last.indefinite};
    return ask(&iteration);
  }

 private:
  double ask(const TrefoilIteration *last) {
    PetscReal weight = 0;
    // A weight that is no number stops the solve where the rule is asked.
    return function_(snes_, last, &weight, context_) ? IterationRecord::none : weight;
  }

  SNES snes_;
  TrefoilRuleFunction function_;
  void *context_;
};

}  // namespace
}  // namespace trefoil

PetscErrorCode TrefoilRuleRegister(const char name[], TrefoilRuleFunction function, void *ctx) {
  PetscFunctionBegin;
  PetscCall(TrefoilInitializePackage());
  const bool added = trefoil::register_rule(name, [function,
                                                   ctx](const trefoil::RuleParameters &parameters) {
    return std::make_unique<trefoil::UserRule>(static_cast<SNES>(parameters.solver), function, ctx);
  });
  PetscCheck(added, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "there is a rule '%s' already", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}
