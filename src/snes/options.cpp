#include <algorithm>
#include <array>
#include <sstream>

#include "snes/option_table.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// The options of one SNES: where they are, and how they are called there.
struct Source {
  MPI_Comm comm = MPI_COMM_NULL;
  PetscOptions database = nullptr;
  const char *prefix = nullptr;
  PetscErrorCode open(SNES snes) {
    PetscFunctionBeginUser;
    comm = PetscObjectComm(reinterpret_cast<PetscObject>(snes));
    PetscCall(PetscObjectGetOptions(reinterpret_cast<PetscObject>(snes), &database));
    PetscCall(SNESGetOptionsPrefix(snes, &prefix));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  [[nodiscard]] std::string full(const char *name) const {
    return std::string("-") + (prefix ? prefix : "") + name;
  }
};

/// As PETSc's readers want it, which add the prefix themselves.
std::string flag_of(const Option &option) {
  return std::string("-").append(option.name);
}

/// Refuses options that begin with our name and are none of ours, so that a typing error is not a
/// default in disguise.
PetscErrorCode refuse_misspelt(const Source &source, const std::vector<Option> &table) {
  char *copy = nullptr;
  PetscFunctionBeginUser;
  const std::string ours = source.full("snes_trefoil_");
  std::vector<std::string> names;
  for (const Option &option : table) {
    const std::string full = source.full(option.name);
    if (full.rfind(ours, 0) == 0) names.push_back(full.substr(ours.size()));
  }
  PetscCall(PetscOptionsGetAll(source.database, &copy));
  std::istringstream words(copy);
  PetscCall(PetscFree(copy));
  for (std::string word; words >> word;) {
    if (word.rfind(ours, 0) != 0) continue;
    const bool known =
        std::find(names.begin(), names.end(), word.substr(ours.size())) != names.end();
    PetscCheck(known, source.comm, PETSC_ERR_USER_INPUT,
               "there is no option %s; the options %s... are: %s", word.c_str(), ours.c_str(),
               join(names).c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// PETSc's own sentence about a name that is no choice does not list the choices.
PetscErrorCode check_choice(const Source &source, const Option &option, const NamedChoice &choice,
                            const std::string &name) {
  PetscFunctionBeginUser;
  PetscCheck(std::find(choice.names.begin(), choice.names.end(), name) != choice.names.end(),
             source.comm, PETSC_ERR_USER_INPUT, "there is no %s '%s' (%s); the %s%s are: %s",
             choice.noun, name.c_str(), source.full(option.name).c_str(), choice.noun,
             choice.noun == std::string("search") ? "es" : "s", join(choice.names).c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode read_choice(TrefoilOptionItems PetscOptionsObject, const Source &source,
                           const Option &option, const NamedChoice &choice, PetscBool *found) {
  std::array<char, PETSC_MAX_PATH_LEN> written{};
  std::vector<const char *> list;
  PetscInt chosen = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetString(source.database, source.prefix, flag_of(option).c_str(),
                                  written.data(), written.size(), found));
  if (*found) PetscCall(check_choice(source, option, choice, written.data()));
  for (const std::string &name : choice.names) list.push_back(name.c_str());
  PetscCall(PetscOptionsEList(flag_of(option).c_str(), option.help.c_str(), "", list.data(),
                              static_cast<PetscInt>(list.size()), name_in(choice).c_str(), &chosen,
                              found));
  if (*found) choose(choice, static_cast<std::size_t>(chosen));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode read_whole_number(TrefoilOptionItems PetscOptionsObject, const Source &source,
                                 const Option &option, const WholeNumber &number,
                                 PetscBool *found) {
  const std::string flag = flag_of(option);
  PetscInt value = *number.value;
  PetscReal written = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsInt(flag.c_str(), option.help.c_str(), "", value, &value, found));
  *number.value = static_cast<int>(value);
  // Of a whole number that is too large PETSc makes another one without a word.
  PetscCall(PetscOptionsGetReal(source.database, source.prefix, flag.c_str(), &written, nullptr));
  PetscCheck(!*found || written == *number.value, source.comm, PETSC_ERR_USER_INPUT,
             "%s is %.15g, which is too large or no whole number", source.full(option.name).c_str(),
             written);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode read_option(TrefoilOptionItems PetscOptionsObject, const Source &source,
                           const Option &option, bool *given) {
  const std::string flag = flag_of(option);
  const char *name = flag.c_str(), *help = option.help.c_str();
  PetscBool found = PETSC_FALSE;
  PetscFunctionBeginUser;
  if (auto *choice = std::get_if<NamedChoice>(&option.value)) {
    PetscCall(read_choice(PetscOptionsObject, source, option, *choice, &found));
  } else if (auto *whole = std::get_if<WholeNumber>(&option.value)) {
    PetscCall(read_whole_number(PetscOptionsObject, source, option, *whole, &found));
  } else if (auto *number = std::get_if<Number>(&option.value)) {
    PetscReal value = *number->value;
    PetscCall(PetscOptionsReal(name, help, "", value, &value, &found));
    *number->value = value;
  } else if (auto *flag_value = std::get_if<bool *>(&option.value)) {
    PetscBool value = **flag_value ? PETSC_TRUE : PETSC_FALSE;
    PetscCall(PetscOptionsBool(name, help, "", value, &value, &found));
    **flag_value = value == PETSC_TRUE;
  } else if (auto *string = std::get_if<std::string *>(&option.value)) {
    std::array<char, PETSC_MAX_PATH_LEN> value{};
    PetscCall(
        PetscOptionsString(name, help, "", (*string)->c_str(), value.data(), value.size(), &found));
    if (found) **string = value.data();
  }
  *given = found == PETSC_TRUE;
  if (option.given) *option.given = *option.given || found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A damping of zero would let no step move, and PETSc takes it without a word.
PetscErrorCode check_damping(const Source &source) {
  PetscReal damping = 1;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetReal(source.database, source.prefix, "-snes_linesearch_damping",
                                &damping, nullptr));
  PetscCheck(damping > 0, source.comm, PETSC_ERR_USER_INPUT,
             "-snes_linesearch_damping is %g; it is the first step length and must be positive",
             damping);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode check_options(SNES snes, SolverOptions &options) {
  Source source;
  PetscFunctionBeginUser;
  PetscCall(source.open(snes));
  for (const Option &option : table_of(options)) {
    const std::string name = source.full(option.name);
    if (auto *number = std::get_if<Number>(&option.value)) {
      PetscCheck(number->makes_sense(*number->value), source.comm, PETSC_ERR_USER_INPUT,
                 "%s is %g and %s", name.c_str(), *number->value, number->condition);
    } else if (auto *whole = std::get_if<WholeNumber>(&option.value)) {
      PetscCheck(whole->makes_sense(*whole->value), source.comm, PETSC_ERR_USER_INPUT,
                 "%s is %d and %s", name.c_str(), *whole->value, whole->condition);
    } else if (auto *choice = std::get_if<NamedChoice>(&option.value)) {
      PetscCall(check_choice(source, option, *choice, name_in(*choice)));
    }
  }
  PetscCheck(!options.weight_set || options.filter == "constant", source.comm, PETSC_ERR_USER_INPUT,
             "%s is for %s constant; the filter is '%s'",
             source.full("snes_trefoil_weight").c_str(), source.full("snes_trefoil_filter").c_str(),
             options.filter.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode read_options(SNES snes, SolverOptions *options, std::vector<std::string> *idle) {
  const std::vector<Option> table = table_of(*options);
  std::vector<const Option *> given;
  Source source;
  PetscFunctionBeginUser;
  PetscCall(source.open(snes));
  PetscCall(refuse_misspelt(source, table));
  // With a title of our own: -help lists only the first of several parts with the same title.
  PetscOptionsBegin(source.comm, source.prefix, "Trust-region eigenvalue filter (Trefoil)", "SNES");
  PetscOptionsObject->options = source.database;
  for (const Option &option : table) {
    bool is_given = false;
    PetscCall(read_option(PetscOptionsObject, source, option, &is_given));
    if (is_given) given.push_back(&option);
  }
  PetscOptionsEnd();
  PetscCall(check_damping(source));
  PetscCall(check_options(snes, *options));
  idle->clear();
  for (const Option *option : given) {
    const char *reason = option->idle ? option->idle(*options) : nullptr;
    if (reason) idle->push_back(source.full(option->name) + " has no effect with " + reason);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode view_options(SolverOptions options, PetscViewer viewer) {
  PetscFunctionBeginUser;
  for (const Option &option : table_of(options)) {
    const std::string value = text_of(option);
    if (value.empty()) continue;
    PetscCall(PetscViewerASCIIPrintf(viewer, "  %s: %s\n", option.name, value.c_str()));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
