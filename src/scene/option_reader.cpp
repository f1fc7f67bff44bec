#include "scene/option_reader.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Number of single-letter changes from one word to the other (Levenshtein's distance).
std::size_t distance(const std::string &a, const std::string &b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
      diagonal = above;
    }
  }
  return row.back();
}

/// Names of the options that nothing has asked for so far.
PetscErrorCode find_unused(std::vector<std::string> *unused) {
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  unused->assign(names, names + count);
  PetscCall(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool begins_with_one_of(const std::vector<std::string> &prefixes, const std::string &option) {
  return std::any_of(prefixes.begin(), prefixes.end(),
                     [&](const std::string &prefix) { return option.rfind(prefix, 0) == 0; });
}

}  // namespace

OptionReader::OptionReader(MPI_Comm comm) : comm_(comm) {
  PetscBool help = PETSC_FALSE;
  static_cast<void>(PetscOptionsHasHelp(nullptr, &help));
  help_ = help == PETSC_TRUE;
}

PetscErrorCode OptionReader::find(const std::string &name, const std::string &help,
                                  const std::string &default_text, const char **value,
                                  bool *found) {
  PetscBool set = PETSC_FALSE;
  PetscFunctionBeginUser;
  known_.insert(name);
  // Not PetscOptionsGetString: it cuts a long expression off without a word.
  PetscCall(PetscOptionsFindPair(nullptr, nullptr, ("-" + name).c_str(), value, &set));
  *found = set == PETSC_TRUE;
  if (help_) {
    PetscCall(
        PetscPrintf(comm_, "  -%s: <%s> %s\n", name.c_str(), default_text.c_str(), help.c_str()));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::text(const std::string &name, const std::string &help,
                                  std::string *value) {
  const char *given = nullptr;
  bool found = false;
  PetscFunctionBeginUser;
  PetscCall(find(name, help, *value, &given, &found));
  if (!found) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(given && *given, comm_, PETSC_ERR_USER_INPUT,
             "-%s is given without a value; one that begins with a minus sign and a letter needs "
             "brackets on the command line: \"-(x), 0, 0\"",
             name.c_str());
  *value = given;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::find_number(const std::string &name, const std::string &help,
                                         const std::string &default_text, double *value,
                                         bool *found) {
  const char *given = nullptr;
  PetscFunctionBeginUser;
  PetscCall(find(name, help, default_text, &given, found));
  if (!*found) PetscFunctionReturn(PETSC_SUCCESS);
  std::istringstream words(given ? given : "");
  double read = 0;
  words >> read;
  PetscCheck(!words.fail() && (words >> std::ws).eof(), comm_, PETSC_ERR_USER_INPUT,
             "-%s is '%s', which is not a number", name.c_str(), given ? given : "");
  *value = read;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::number(const std::string &name, const std::string &help,
                                    double *value) {
  std::ostringstream default_text;
  bool found = false;
  PetscFunctionBeginUser;
  default_text << *value;
  PetscCall(find_number(name, help, default_text.str(), value, &found));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::number(const std::string &name, const std::string &help,
                                    std::optional<double> *value) {
  double read = 0;
  bool found = false;
  PetscFunctionBeginUser;
  PetscCall(find_number(name, help, "", &read, &found));
  if (found) *value = read;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::integer(const std::string &name, const std::string &help,
                                     PetscInt *value) {
  auto read = static_cast<double>(*value);
  PetscFunctionBeginUser;
  PetscCall(number(name, help, &read));
  PetscCheck(read == std::floor(read) && std::abs(read) < 2147483648., comm_, PETSC_ERR_USER_INPUT,
             "-%s is %g, which is not a whole number below 2^31", name.c_str(), read);
  *value = static_cast<PetscInt>(read);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::flag(const std::string &name, const std::string &help, bool *value) {
  const char *given = nullptr;
  bool found = false;
  PetscFunctionBeginUser;
  PetscCall(find(name, help, *value ? "true" : "false", &given, &found));
  if (!found) PetscFunctionReturn(PETSC_SUCCESS);
  std::string word = given ? given : "";
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  const bool yes = word.empty() || word == "true" || word == "yes" || word == "1" || word == "on";
  const bool no = word == "false" || word == "no" || word == "0" || word == "off";
  PetscCheck(yes || no, comm_, PETSC_ERR_USER_INPUT, "-%s is '%s', which is neither true nor false",
             name.c_str(), word.c_str());
  *value = yes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::names(const std::string &name, const std::string &help,
                                   std::vector<std::string> *value) {
  std::string list;
  PetscFunctionBeginUser;
  PetscCall(text(name, help, &list));
  std::replace(list.begin(), list.end(), ',', ' ');
  std::istringstream words(list);
  for (std::string word; words >> word;) value->push_back(word);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const std::string &OptionReader::nearest(const std::string &option) const {
  return *std::min_element(known_.begin(), known_.end(), [&](const auto &a, const auto &b) {
    return distance(a, option) < distance(b, option);
  });
}

bool OptionReader::is_misspelt(const std::string &option,
                               const std::vector<std::string> &prefixes) const {
  if (known_.count(option)) return false;
  // A prefix may be misspelt as well. Names of PETSc are farther from ours than that.
  constexpr std::size_t letters_an_error = 4, most_errors = 2;
  const std::string &name = nearest(option);
  return begins_with_one_of(prefixes, option) ||
         distance(name, option) <= std::min(name.size() / letters_an_error, most_errors);
}

PetscErrorCode OptionReader::refuse_unknown(const std::vector<std::string> &prefixes) const {
  std::vector<std::string> unused;
  PetscFunctionBeginUser;
  PetscCall(find_unused(&unused));
  const auto found = std::find_if(unused.begin(), unused.end(), [&](const std::string &option) {
    return is_misspelt(option, prefixes);
  });
  if (found == unused.end()) PetscFunctionReturn(PETSC_SUCCESS);
  const std::string &culprit = *found;
  const std::string suggestion = nearest(culprit);
  const bool near = distance(suggestion, culprit) <= culprit.size() / 3;
  const bool of_constraint = culprit.rfind("constraint_", 0) == 0;
  SETERRQ(comm_, PETSC_ERR_USER_INPUT, "there is no option -%s here%s%s%s; -help lists all",
          culprit.c_str(), near ? ", perhaps you mean -" : "", near ? suggestion.c_str() : "",
          of_constraint ? "; the names of the constraints come from -constraints" : "");
}

PetscErrorCode refuse_unused(MPI_Comm comm, const std::vector<std::string> &prefixes) {
  std::vector<std::string> unused;
  PetscFunctionBeginUser;
  PetscCall(find_unused(&unused));
  for (const std::string &option : unused) {
    PetscCheck(!begins_with_one_of(prefixes, option), comm, PETSC_ERR_USER_INPUT,
               "nothing here uses -%s; check its name, or leave it out", option.c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode print_unused_options(MPI_Comm comm) {
  const std::set<std::string> asked_at_end{"citations", "get_total_flops", "options_left",
                                           "options_view"};
  std::vector<std::string> unused;
  std::string list;
  PetscFunctionBeginUser;
  PetscCall(find_unused(&unused));
  for (const std::string &option : unused) {
    if (!asked_at_end.count(option)) list += (list.empty() ? "-" : ", -") + option;
  }
  if (!list.empty()) PetscCall(PetscPrintf(comm, "nothing here used %s\n", list.c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
