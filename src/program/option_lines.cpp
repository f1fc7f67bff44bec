#include "program/option_lines.hpp"

#include <petscsys.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

bool is_option(const std::string &word) {
  PetscBool valid = PETSC_FALSE;
  static_cast<void>(PetscOptionsValidKey(word.c_str(), &valid));
  return valid == PETSC_TRUE;
}

/// The words of a line as PETSc counts them: a text in quotes is one.
std::vector<std::string> words_of(const std::string &line) {
  constexpr const char *blanks = " \t\r";
  const std::string text = line.substr(0, line.find('#'));
  std::vector<std::string> words;
  for (std::size_t begin = 0; (begin = text.find_first_not_of(blanks, begin)) != text.npos;) {
    const bool is_quoted = text[begin] == '"' || text[begin] == '\'';
    const std::size_t end =
        is_quoted ? text.find(text[begin], begin + 1) : text.find_first_of(blanks, begin);
    const std::size_t first = is_quoted ? begin + 1 : begin;
    words.push_back(text.substr(first, end == text.npos ? end : end - first));
    if (end == text.npos) break;
    begin = end + 1;
  }
  return words;
}

}  // namespace

std::vector<std::string> read_option_lines(const std::string &path) {
  const auto refuse = [&](const std::string &why) {
    throw InputError("cannot read the options file '" + path + "': " + why);
  };
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) refuse("it is a directory; name a file in it");
  std::ifstream file(path);
  if (!file) refuse(std::string(std::strerror(errno)) + "; check its name");
  std::vector<std::string> options;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) continue;
    const bool has_value = words.size() == 2 && !is_option(words[1]);
    if (!is_option(words[0]) || (words.size() > 1 && !has_value)) {
      refuse("line " + std::to_string(number) +
             " is not one option and its value, \"-name value\"; a file in YAML needs a name that "
             "ends in .yaml");
    }
    options.insert(options.end(), words.begin(), words.end());
  }
  return options;
}

}  // namespace trefoil
