#include "program/program_errors.hpp"

#include <dlfcn.h>
#include <mpi.h>
#include <petscsys.h>
#include <strings.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

namespace trefoil {
namespace {

std::string kept_sentence;

/// PETSc breaks long sentences into lines.
std::string one_line(const std::string &text) {
  std::string line;
  for (char letter : text) {
    const bool blank = letter == '\n' || letter == '\r' || letter == '\t' || letter == ' ';
    if (!blank) {
      line += letter;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  if (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

void print_kept_error() {
  std::fflush(stdout);
  std::fprintf(stderr, "trefoil: %s\n", one_line(kept_sentence).c_str());
}

/// The last error counts: earlier ones have been recovered from.
PetscErrorCode keep(MPI_Comm, int, const char *, const char *, PetscErrorCode code,
                    PetscErrorType type, const char *message, void *) {
  if (type == PETSC_ERROR_INITIAL) {
    const char *known = nullptr;
    static_cast<void>(PetscErrorMessage(code, &known, nullptr));
    kept_sentence = "PETSc failed with error " + std::to_string(code);
    if (known && *known) kept_sentence += ", " + std::string(known);
    if (message && *message) kept_sentence = message;
  }
  return code;
}

/// PETSc's own handler says what happened through print_nothing, and aborts all ranks.
PetscErrorCode announce(int signal, void *context) {
  std::fprintf(stderr, "trefoil: stopped by signal %d, %s\n", signal, strsignal(signal));
  return PetscSignalHandlerDefault(signal, context);
}

/// PETSc prints errors that come before its own start through this hook as well.
PetscErrorCode print_nothing(const char *, ...) {
  return static_cast<PetscErrorCode>(0);
}

bool ends_in(const std::string &text, const std::string &end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool is_option(const std::string &word) {
  PetscBool valid = PETSC_FALSE;
  static_cast<void>(PetscOptionsValidKey(word.c_str(), &valid));
  return valid == PETSC_TRUE;
}

// How PETSc tells YAML from its own format: by the file's name, or else by how it begins.
bool is_named_as_yaml(const std::string &name) {
  return ends_in(name, ".yaml") || ends_in(name, ".yml") || ends_in(name, ".json");
}

bool begins_as_yaml(std::istream &file) {
  std::array<char, 7> begin{};
  file.read(begin.data(), 6);
  file.clear();
  file.seekg(0);
  const std::string text = begin.data();
  return text.rfind("---", 0) == 0 || text == "%YAML ";
}

/// The words of a line of options as PETSc counts them: a text in quotes is one.
std::vector<std::string> words_of(const std::string &line) {
  constexpr const char *blanks = " \t\r";
  const std::string text = line.substr(0, line.find('#'));
  std::vector<std::string> words;
  for (std::size_t begin = 0; (begin = text.find_first_not_of(blanks, begin)) != text.npos;) {
    const bool is_quoted = text[begin] == '"' || text[begin] == '\'';
    const std::size_t end =
        is_quoted ? text.find(text[begin], begin + 1) : text.find_first_of(blanks, begin);
    words.push_back(text.substr(begin, end == text.npos ? end : end - begin));
    if (end == text.npos) break;
    begin = end + 1;
  }
  return words;
}

/// What is wrong with a file in PETSc's own format, one option a line; or nothing.
std::string problem_of_lines(std::istream &file) {
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::vector<std::string> words = words_of(line);
    if (words.empty() || strcasecmp(words[0].c_str(), "alias") == 0) continue;
    const bool has_value = words.size() == 2 && !is_option(words[1]);
    if (!is_option(words[0]) || (words.size() > 1 && !has_value)) {
      return "line " + std::to_string(number) +
             " is not one option and its value, \"-name value\"; a file in YAML needs a name "
             "that ends in .yaml";
    }
  }
  return "";
}

std::string problem_of_yaml(std::istream &file) {
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  PetscOptions scratch = nullptr;
  PetscErrorCode error = PetscOptionsCreate(&scratch);
  if (!error) error = PetscOptionsInsertStringYAML(scratch, text.c_str());
  static_cast<void>(PetscOptionsDestroy(&scratch));
  return error ? kept_sentence + "; check its indentation (no tabulators), brackets and quotes"
               : "";
}

/// On one rank: what keeps PETSc from reading a file of options, or nothing.
std::string problem_of_options_file(std::string name, bool is_yaml) {
  constexpr const char *mark_of_yaml = ":yaml";
  if (name.find("${") != std::string::npos) return "";  // PETSc replaces names of its environment
  if (ends_in(name, mark_of_yaml)) {
    name.resize(name.size() - std::string(mark_of_yaml).size());
    is_yaml = true;
  }
  std::error_code ignored;
  std::ifstream file(name);
  std::string problem;
  if (std::filesystem::is_directory(name, ignored)) {
    problem = "it is a directory; name a file in it";
  } else if (!file) {
    problem = std::string(std::strerror(errno)) + "; check its name";
  } else if (is_yaml || is_named_as_yaml(name) || begins_as_yaml(file)) {
    problem = problem_of_yaml(file);
  } else {
    problem = problem_of_lines(file);
  }
  return problem.empty() ? "" : "cannot read the options file '" + name + "': " + problem;
}

/// On one rank: what is wrong with the words of the command line, or nothing.
std::string problem_of_arguments(const std::vector<std::string> &words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    // PETSc passes over such words in silence.
    if (!is_option(words[i])) {
      return "'" + words[i] + "' follows no option; a file of options is given as -options_file " +
             "scene.yaml, and a value with blanks is put in quotes";
    }
    if (i + 1 == words.size() || is_option(words[i + 1])) continue;
    const std::string &value = words[++i];
    const bool is_yaml = strcasecmp(words[i - 1].c_str(), "-options_file_yaml") == 0;
    if (!is_yaml && strcasecmp(words[i - 1].c_str(), "-options_file") != 0) continue;
    const std::string problem = problem_of_options_file(value, is_yaml);
    if (!problem.empty()) return problem;
  }
  return "";
}

/// Counts the ranks that are here; the lowest that has failed, or the number of ranks.
/// @return false where a failed rank has waited in vain for the others
bool find_first_failed(bool failed, int *first) {
  constexpr int patience = 1000;  // times 10 ms
  int rank = 0, ranks = 0, arrived = 0;
  MPI_Request all_here = MPI_REQUEST_NULL;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int mine = failed ? rank : ranks;
  MPI_Iallreduce(&mine, first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD, &all_here);
  MPI_Test(&all_here, &arrived, MPI_STATUS_IGNORE);
  for (int waited = 0; !arrived && !(failed && waited == patience); ++waited) {
    usleep(10000);
    MPI_Test(&all_here, &arrived, MPI_STATUS_IGNORE);
  }
  return arrived;
}

}  // namespace

void keep_errors() {
  PetscErrorPrintf = print_nothing;
  static_cast<void>(PetscPushErrorHandler(keep, nullptr));
}

void announce_signals() {
  static_cast<void>(PetscPushSignalHandler(announce, nullptr));
  std::signal(SIGPIPE, SIG_DFL);  // who reads no further, `| head`, wants to hear no more
}

void keep_error(const std::string &sentence) {
  kept_sentence = sentence;
}

bool can_read_arguments(int argc, char **argv) {
  int rank = 0, readable = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) {
    const std::string problem = problem_of_arguments({argv + 1, argv + argc});
    readable = problem.empty();
    if (!readable) keep_error(problem);
  }
  MPI_Bcast(&readable, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return readable;
}

void use_one_thread_a_rank() {
  for (const char *name : {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"}) {
    const char *wish = std::getenv(name);
    // One thread is what is wanted; but CHOLMOD opens its parallel regions all the same.
    if (wish && std::string(wish) != "1") return;
  }
  // Both libraries have read their environment by now, and CHOLMOD asks OpenMP for threads itself;
  // only calls help. They exist where these libraries do.
  if (auto *set =
          reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))) {
    set(1);
  }
  if (auto *set =
          reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"))) {
    set(0);
  }
}

int finish_ranks(int status) {
  int rank = 0, ranks = 0, first_failed = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const bool failed = status == 1;
  if (!find_first_failed(failed, &first_failed)) {
    print_kept_error();
    MPI_Abort(MPI_COMM_WORLD, status);
  }
  if (first_failed == rank) print_kept_error();
  if (first_failed < ranks) {
    status = 1;
  } else {
    static_cast<void>(PetscFinalize());
  }
  MPI_Finalize();
  return status;
}

}  // namespace trefoil
