#include <petsc/private/petscimpl.h>

#include <array>
#include <cstring>
#include <sstream>

#include "snes/solve_context.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

// Every option of ours; what is not here is misspelt.
constexpr std::array<const char *, 16> known_options{
    "filter",      "rho_tolerance",  "weight", "search", "decrement_tolerance", "energy_tolerance",
    "monitor",     "record",         "strict", "fields", "corrections",         "correction_gain",
    "trust_start", "verify_minimum", "space",  "floor"};

std::string join(const std::vector<std::string> &words) {
  std::ostringstream text;
  for (std::size_t i = 0; i < words.size(); ++i) text << (i ? ", " : "") << words[i];
  return text.str();
}

/// Refuses options that begin with our name and are none of ours, so that a typing error is not a
/// default in disguise.
PetscErrorCode refuse_misspelt(SNES snes) {
  PetscOptions database = nullptr;
  const char *prefix = nullptr;
  char *copy = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectGetOptions(reinterpret_cast<PetscObject>(snes), &database));
  PetscCall(SNESGetOptionsPrefix(snes, &prefix));
  const std::string ours = std::string("-") + (prefix ? prefix : "") + "snes_trefoil_";
  PetscCall(PetscOptionsGetAll(database, &copy));
  std::istringstream words(copy);
  PetscCall(PetscFree(copy));
  for (std::string word; words >> word;) {
    if (word.rfind(ours, 0) != 0) continue;
    const std::string name = word.substr(ours.size());
    bool known = false;
    for (const char *option : known_options) known = known || name == option;
    std::vector<std::string> names(known_options.begin(), known_options.end());
    PetscCheck(known, PetscObjectComm(reinterpret_cast<PetscObject>(snes)), PETSC_ERR_USER_INPUT,
               "there is no option %s; the options %s... are: %s", word.c_str(), ours.c_str(),
               join(names).c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Values that PETSc takes without a word: of a whole number that is too large it makes another
/// one, and a damping of zero would let no step move.
PetscErrorCode check_unchecked(PetscOptions database, const char *prefix, int corrections,
                               MPI_Comm comm) {
  PetscReal written = 0, damping = 1;
  PetscBool found = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetReal(database, prefix, "-snes_trefoil_corrections", &written, &found));
  PetscCheck(!found || written == corrections, comm, PETSC_ERR_USER_INPUT,
             "-snes_trefoil_corrections is %.15g, which is too large or no whole number", written);
  PetscCall(PetscOptionsGetReal(database, prefix, "-snes_linesearch_damping", &damping, nullptr));
  PetscCheck(damping > 0, comm, PETSC_ERR_USER_INPUT,
             "-snes_linesearch_damping is %g; it is the first step length and must be positive",
             damping);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_values(const SolverOptions &options, MPI_Comm comm) {
  PetscFunctionBeginUser;
  PetscCheck(make_rule(options.filter, options.rule), comm, PETSC_ERR_USER_INPUT,
             "there is no filter '%s' (-snes_trefoil_filter); the filters are: %s",
             options.filter.c_str(), join(rule_names()).c_str());
  PetscCheck(options.search == "armijo" || options.search == "subspace", comm, PETSC_ERR_USER_INPUT,
             "there is no search '%s' (-snes_trefoil_search); the searches are: armijo, subspace",
             options.search.c_str());
  PetscCheck(options.space == "element" || options.space == "deformation", comm,
             PETSC_ERR_USER_INPUT,
             "there is no space '%s' (-snes_trefoil_space); the spaces are: element, deformation",
             options.space.c_str());
  PetscCheck(options.shrink > 0 && options.shrink < 1, comm, PETSC_ERR_USER_INPUT,
             "-snes_linesearch_shrink is %g and must lie between 0 and 1", options.shrink);
  PetscCheck(options.armijo >= 0 && options.armijo < 0.5, comm, PETSC_ERR_USER_INPUT,
             "-snes_linesearch_armijo is %g and must be at least 0 and below 0.5", options.armijo);
  PetscCheck(options.rule.rho_tolerance >= 0, comm, PETSC_ERR_USER_INPUT,
             "-snes_trefoil_rho_tolerance is %g and must not be negative",
             options.rule.rho_tolerance);
  PetscCheck(options.rule.weight >= 0, comm, PETSC_ERR_USER_INPUT,
             "-snes_trefoil_weight is %g and must not be negative", options.rule.weight);
  PetscCheck(
      options.corrections >= -1 && options.correction_gain >= 0, comm, PETSC_ERR_USER_INPUT,
      "-snes_trefoil_corrections (%d) must be at least -1 and -snes_trefoil_correction_gain (%g) "
      "not negative",
      options.corrections, options.correction_gain);
  PetscCheck(options.floor < 1, comm, PETSC_ERR_USER_INPUT,
             "-snes_trefoil_floor is %g, a share of the largest eigenvalue that must be below 1",
             options.floor);
  PetscCheck(options.decrement_tolerance >= 0 && options.energy_tolerance >= 0, comm,
             PETSC_ERR_USER_INPUT,
             "the tolerances -snes_trefoil_decrement_tolerance (%g) and "
             "-snes_trefoil_energy_tolerance (%g) must not be negative",
             options.decrement_tolerance, options.energy_tolerance);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A factorisation that fails is an answer to a rule that may be rejected, not the end of the
/// solve; to any other it is what the SNES says it is.
PetscErrorCode allow_linear_failures(SolveContext &context) {
  PetscOptions database = nullptr;
  const char *prefix = nullptr;
  PetscBool given = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectGetOptions(reinterpret_cast<PetscObject>(context.snes), &database));
  PetscCall(SNESGetOptionsPrefix(context.snes, &prefix));
  PetscCall(PetscOptionsHasName(database, prefix, "-snes_max_linear_solve_fail", &given));
  if (given) PetscFunctionReturn(PETSC_SUCCESS);
  if (context.rule->may_be_rejected() && !context.linear_failures) {
    PetscInt failures = 0;
    PetscCall(SNESGetMaxLinearSolveFailures(context.snes, &failures));
    PetscCall(SNESSetMaxLinearSolveFailures(context.snes, PETSC_MAX_INT));
    context.linear_failures = failures;
  } else if (!context.rule->may_be_rejected() && context.linear_failures) {
    PetscCall(SNESSetMaxLinearSolveFailures(context.snes, *context.linear_failures));
    context.linear_failures.reset();
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode set_options(SolveContext &context) {
  SolverOptions &options = context.options;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(context.snes));
  std::array<char, PETSC_MAX_PATH_LEN> filter{}, search{}, file{}, fields{}, space{};
  PetscBool found = PETSC_FALSE, constant_weight = PETSC_FALSE;
  PetscBool monitor = options.monitor ? PETSC_TRUE : PETSC_FALSE;
  PetscBool strict = options.strict ? PETSC_TRUE : PETSC_FALSE;
  PetscReal rho_tolerance = options.rule.rho_tolerance, weight = options.rule.weight;
  PetscReal decrement = options.decrement_tolerance, energy = options.energy_tolerance;
  PetscReal gain = options.correction_gain, floor = options.floor;
  PetscInt corrections = options.corrections;
  PetscBool verify_minimum = options.verify_minimum ? PETSC_TRUE : PETSC_FALSE;
  PetscBool trust_start = options.trust_start ? PETSC_TRUE : PETSC_FALSE;
  PetscReal shrink = options.shrink, armijo = options.armijo;
  PetscOptions database = nullptr;
  const char *prefix = nullptr;

  PetscFunctionBeginUser;
  PetscCall(refuse_misspelt(context.snes));
  const std::string filter_help = "Filter of the element Hessians: " + join(rule_names());
  PetscCall(PetscObjectGetOptions(reinterpret_cast<PetscObject>(context.snes), &database));
  PetscCall(SNESGetOptionsPrefix(context.snes, &prefix));
  // With a title of our own: -help lists only the first of several parts with the same title.
  PetscOptionsBegin(comm, prefix, "Trust-region eigenvalue filter (Trefoil)", "SNES");
  PetscOptionsObject->options = database;
  PetscCall(PetscOptionsString("-snes_trefoil_filter", filter_help.c_str(), "",
                               options.filter.c_str(), filter.data(), filter.size(), &found));
  if (found) options.filter = filter.data();
  PetscCall(PetscOptionsReal("-snes_trefoil_rho_tolerance",
                             "adaptive: clamp while |rho - 1| is below this (dimensionless)", "",
                             rho_tolerance, &rho_tolerance, nullptr));
  PetscCall(PetscOptionsReal("-snes_trefoil_weight",
                             "constant: w of H + 2 w N; 0 Newton, 0.5 clamp, 1 absolute", "",
                             weight, &weight, &constant_weight));
  PetscCall(PetscOptionsString("-snes_trefoil_search",
                               "Search: armijo, along the direction; subspace, in the plane of it "
                               "and the previous step, with corrections",
                               "", options.search.c_str(), search.data(), search.size(), &found));
  if (found) options.search = search.data();
  PetscCall(PetscOptionsInt("-snes_trefoil_corrections",
                            "subspace: most further directions an iteration, by the same linear "
                            "solver; -1: 8 where it is direct, else 0",
                            "", corrections, &corrections, nullptr));
  PetscCall(PetscOptionsReal("-snes_trefoil_floor",
                             "Least eigenvalue of a filtered element, as a share of its largest; "
                             "0 none; negative: the filter's own (tikhonov 1e-3, others none)",
                             "", floor, &floor, nullptr));
  PetscCall(PetscOptionsReal("-snes_trefoil_correction_gain",
                             "subspace: least share of the first step's decrease to go on", "",
                             gain, &gain, nullptr));
  PetscCall(PetscOptionsBool("-snes_trefoil_trust_start",
                             "subspace: from the first iteration; false: once |rho - 1| is small",
                             "", trust_start, &trust_start, nullptr));
  PetscCall(
      PetscOptionsReal("-snes_trefoil_decrement_tolerance",
                       "Stop when the Newton decrement |g'd|/2 is below (energy units, 0 off)", "",
                       decrement, &decrement, nullptr));
  PetscCall(PetscOptionsReal("-snes_trefoil_energy_tolerance",
                             "Stop when the decrement over the energy scale is below "
                             "(dimensionless, 0 off; off where decrement_tolerance is set)",
                             "", energy, &energy, &found));
  options.energy_tolerance_set = options.energy_tolerance_set || found;
  PetscCall(PetscOptionsBool("-snes_trefoil_verify_minimum",
                             "Where the stop test is met, look for negative curvature of the "
                             "unfiltered Hessian, and leave a saddle along it (off where "
                             "decrement_tolerance is set)",
                             "", verify_minimum, &verify_minimum, &found));
  options.verify_minimum_set = options.verify_minimum_set || found;
  PetscCall(PetscOptionsReal("-snes_linesearch_shrink", "Factor from a step length to the next", "",
                             shrink, &shrink, nullptr));
  PetscCall(PetscOptionsReal("-snes_linesearch_armijo", "Share of the predicted decrease to reach",
                             "", armijo, &armijo, nullptr));
  PetscCall(PetscOptionsBool("-snes_trefoil_monitor", "One line an iteration", "", monitor,
                             &monitor, nullptr));
  PetscCall(PetscOptionsString("-snes_trefoil_record", "Write a JSON record of the solve to a file",
                               "", options.record_file.c_str(), file.data(), file.size(), &found));
  if (found) {
    options.record_file = file.data();
    PetscCall(check_text_file(comm, options.record_file));
  }
  PetscCall(PetscOptionsBool("-snes_trefoil_strict",
                             "A Jacobian that cannot be filtered is an error; false: pass it "
                             "unfiltered and count it in the record",
                             "", strict, &strict, nullptr));
  PetscCall(PetscOptionsString("-snes_trefoil_fields",
                               "Fields to filter, by name or number, separated by commas", "",
                               options.fields.c_str(), fields.data(), fields.size(), &found));
  if (found && options.fields != fields.data()) {
    options.fields = fields.data();
    PetscCall(release_host_matrix(context));  // it knows the unknowns of the old fields
  }
  PetscCall(
      PetscOptionsString("-snes_trefoil_space",
                         "What is filtered: element, the element's Hessian; deformation, dP/dF "
                         "at its quadrature points",
                         "", options.space.c_str(), space.data(), space.size(), &found));
  if (found) options.space = space.data();
  PetscOptionsEnd();

  options.strict = strict == PETSC_TRUE;
  options.rule = {rho_tolerance, weight, context.snes};
  options.decrement_tolerance = decrement;
  options.energy_tolerance = energy;
  options.shrink = shrink;
  options.armijo = armijo;
  options.corrections = static_cast<int>(corrections);
  options.correction_gain = gain;
  options.floor = floor;
  options.trust_start = trust_start == PETSC_TRUE;
  options.verify_minimum = verify_minimum == PETSC_TRUE;
  options.monitor = monitor == PETSC_TRUE;
  PetscCall(check_unchecked(database, prefix, options.corrections, comm));
  PetscCall(check_values(options, comm));
  PetscCheck(!constant_weight || options.filter == "constant", comm, PETSC_ERR_USER_INPUT,
             "-snes_trefoil_weight is for -snes_trefoil_filter constant; the filter is '%s'",
             options.filter.c_str());
  context.rule = make_rule(options.filter, options.rule);
  PetscCall(allow_linear_failures(context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode view_options(const SolveContext &context, PetscViewer viewer) {
  const SolverOptions &options = context.options;
  PetscFunctionBeginUser;
  std::ostringstream tuning;
  if (options.filter == "adaptive") tuning << ", rho tolerance " << options.rule.rho_tolerance;
  if (options.filter == "constant") tuning << ", weight " << options.rule.weight;
  PetscCall(PetscViewerASCIIPrintf(viewer, "  eigenvalue filter: %s%s\n", options.filter.c_str(),
                                   tuning.str().c_str()));
  PetscCall(PetscViewerASCIIPrintf(viewer, "  search: %s, shrink %g, armijo %g\n",
                                   options.search.c_str(), options.shrink, options.armijo));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, "  decrement tolerance: %g, energy tolerance: %g%s\n", options.decrement_tolerance,
      options.energy_tolerance,
      options.decrement_tolerance > 0 && !options.energy_tolerance_set ? " (off)" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
