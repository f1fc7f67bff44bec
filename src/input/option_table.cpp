#include "input/option_table.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// One value, from a text to what the row wants; each returns what is wrong with it, or nothing.
struct Parser {
  const OptionRow &row;
  std::string text;
  bool has_value;

  [[nodiscard]] std::string wrong(const std::string &why) const {
    return "-" + row.name + " is '" + text + "', " + why;
  }

  std::string number(double *value) const {
    std::istringstream words(text);
    double read = 0;
    words >> read;
    if (words.fail() || !(words >> std::ws).eof()) return wrong("which is not a number");
    *value = read;
    return "";
  }

  std::string operator()(std::string *value) const {
    if (!has_value || text.empty()) {
      return "-" + row.name +
             " is given without a value; one that begins with a minus sign and a letter needs "
             "brackets on the command line: \"-(x), 0, 0\"";
    }
    const auto &choices = row.choices;
    if (!choices.empty() && std::find(choices.begin(), choices.end(), text) == choices.end()) {
      std::string list;
      for (const std::string &choice : choices) list += (list.empty() ? "" : ", ") + choice;
      return "-" + row.name + " knows no '" + text + "'; it knows: " + list;
    }
    *value = text;
    return "";
  }

  std::string operator()(double *value) const { return number(value); }

  std::string operator()(std::optional<double> *value) const {
    double read = 0;
    const std::string problem = number(&read);
    if (problem.empty()) *value = read;
    return problem;
  }

  std::string operator()(PetscInt *value) const {
    double read = 0;
    const std::string problem = number(&read);
    if (!problem.empty()) return problem;
    if (read != std::floor(read) || std::abs(read) >= 2147483648.) {
      std::ostringstream sentence;
      sentence << "-" << row.name << " is " << read << ", which is not a whole number below 2^31";
      return sentence.str();
    }
    *value = static_cast<PetscInt>(read);
    return "";
  }

  std::string operator()(bool *value) const {
    std::string word = text;
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
    const bool yes = word.empty() || word == "true" || word == "yes" || word == "1" || word == "on";
    const bool no = word == "false" || word == "no" || word == "0" || word == "off";
    if (!yes && !no) return wrong("which is neither true nor false");
    *value = yes;
    return "";
  }

  /// Names, separated by commas or blanks.
  std::string operator()(std::vector<std::string> *value) const {
    std::string list = text;
    std::replace(list.begin(), list.end(), ',', ' ');
    std::istringstream words(list);
    std::vector<std::string> names;
    for (std::string word; words >> word;) names.push_back(word);
    if (names.empty()) return "-" + row.name + " is given without a value; name at least one";
    for (const std::string &name : names) {
      if (std::count(names.begin(), names.end(), name) > 1) {
        return "-" + row.name + " names '" + name + "' twice; give each its own name";
      }
      const auto &choices = row.choices;
      if (!choices.empty() && std::find(choices.begin(), choices.end(), name) == choices.end()) {
        std::string known;
        for (const std::string &choice : choices) known += (known.empty() ? "" : ", ") + choice;
        return "-" + row.name + " knows no '" + name + "'; it knows: " + known;
      }
    }
    *value = names;
    return "";
  }
};

struct DefaultText {
  std::string operator()(const std::string *value) const { return *value; }
  std::string operator()(const double *value) const {
    std::ostringstream text;
    text << *value;
    return text.str();
  }
  std::string operator()(const std::optional<double> *value) const {
    return *value ? (*this)(&**value) : "";
  }
  std::string operator()(const PetscInt *value) const { return std::to_string(*value); }
  std::string operator()(const bool *value) const { return *value ? "true" : "false"; }
  std::string operator()(const std::vector<std::string> *value) const {
    std::string list;
    for (const std::string &word : *value) list += (list.empty() ? "" : ",") + word;
    return list;
  }
};

std::string trimmed(const std::string &text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

}  // namespace

PetscErrorCode OptionReader::read(const OptionRow &row) {
  const char *given = nullptr;
  PetscBool is_set = PETSC_FALSE;
  PetscFunctionBeginUser;
  known_.insert(row.name);
  // Not PetscOptionsGetString: it cuts a long expression off without a word.
  PetscCall(PetscOptionsFindPair(nullptr, nullptr, ("-" + row.name).c_str(), &given, &is_set));
  if (!is_set) PetscFunctionReturn(PETSC_SUCCESS);
  const std::string text = trimmed(given ? given : "");
  const std::string problem = std::visit(Parser{row, text, given != nullptr}, row.target);
  PetscCheck(problem.empty(), comm_, PETSC_ERR_USER_INPUT, "%s", problem.c_str());
  given_[row.name] = text;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OptionReader::read(const std::vector<OptionRow> &rows) {
  PetscFunctionBeginUser;
  for (const OptionRow &row : rows) PetscCall(read(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::string default_text(const OptionTarget &target) {
  return std::visit(DefaultText{}, target);
}

}  // namespace trefoil
