#include "program/arguments.hpp"

#include <mpi.h>
#include <petscsys.h>
#include <strings.h>

#include <array>
#include <cstdlib>
#include <fstream>

#include "input/scene_file.hpp"
#include "program/option_lines.hpp"
#include "program/program_errors.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

bool is_option(const std::string &word) {
  PetscBool valid = PETSC_FALSE;
  static_cast<void>(PetscOptionsValidKey(word.c_str(), &valid));
  return valid == PETSC_TRUE;
}

bool is_called(const std::string &word, const char *name) {
  return strcasecmp(word.c_str(), name) == 0;  // as PETSc compares options
}

/// How PETSc tells YAML from its own format: by the file's name, or else by how it begins.
bool is_yaml(const std::string &path) {
  for (const std::string end : {".yaml", ".yml", ".json"}) {
    if (path.size() >= end.size() && path.ends_with(end)) return true;
  }
  std::array<char, 7> begin{};
  std::ifstream(path).read(begin.data(), 6);
  const std::string text = begin.data();
  return text.rfind("---", 0) == 0 || text == "%YAML ";
}

/// One walk through the command line.
class Reader {
 public:
  explicit Reader(Arguments &arguments) : arguments_(arguments) {}

  /// @throws InputError
  void read(const std::vector<std::string> &words) {
    bool may_be_scene = true;  // scene files come first, or right after --check
    for (std::size_t i = 0; i < words.size(); ++i) {
      const std::string &word = words[i];
      const bool has_value = i + 1 < words.size() && !is_option(words[i + 1]);
      if (word == "--help" || word == "-h") {
        const std::string kind = has_value ? words[i + 1] : "";
        if (kind == "all") {
          arguments_.words = {"-help"};
        } else if (kind == "keys") {
          arguments_.task = Arguments::Task::keys;
        } else {
          arguments_.task = kind == "man" ? Arguments::Task::manual : Arguments::Task::help;
        }
        return;
      }
      if (word == "--version") {
        arguments_.task = Arguments::Task::version;
        return;
      }
      if (word == "--check") {
        arguments_.words.insert(arguments_.words.end(), {"-check", "true"});
        may_be_scene = true;
      } else if (is_option(word)) {
        may_be_scene = false;
        add_option(word, has_value ? &words[++i] : nullptr);
      } else if (may_be_scene) {
        add_file(word, false);
      } else {
        throw InputError("'" + word +
                         "' follows no option; scene files come first, trefoil scene.yaml -option "
                         "value, and a value with blanks is put in quotes");
      }
    }
  }

 private:
  void add_option(const std::string &name, const std::string *value) {
    const bool as_yaml = is_called(name, "-options_file_yaml");
    if (as_yaml || is_called(name, "-options_file")) {
      if (!value) throw InputError(name + " is given without a file");
      add_file(*value, as_yaml);
      return;
    }
    arguments_.words.push_back(name);
    if (value) arguments_.words.push_back(*value);
  }

  void add_file(std::string path, bool as_yaml) {
    const std::string mark = ":yaml";
    if (path.size() > mark.size() && path.ends_with(mark)) {
      path.resize(path.size() - mark.size());
      as_yaml = true;
    }
    arguments_.scene_files.push_back(path);
    const std::vector<std::string> words =
        as_yaml || is_yaml(path) ? scenes_.read(path) : read_option_lines(path);
    arguments_.words.insert(arguments_.words.end(), words.begin(), words.end());
  }

  Arguments &arguments_;
  SceneFileReader scenes_;
};

/// Sends the first rank's words to all.
void share(std::vector<std::string> *words) {
  std::string all;
  for (const std::string &word : *words) all += word + '\0';
  int length = static_cast<int>(all.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, MPI_COMM_WORLD);
  all.resize(static_cast<std::size_t>(length));
  MPI_Bcast(all.data(), length, MPI_CHAR, 0, MPI_COMM_WORLD);
  words->clear();
  for (std::size_t begin = 0; begin < all.size(); begin += words->back().size() + 1) {
    words->emplace_back(all.c_str() + begin);
  }
}

}  // namespace

char **Arguments::argv() {
  static char name[] = "trefoil";
  pointers_.assign(1, name);
  for (std::string &word : words) pointers_.push_back(word.data());
  pointers_.push_back(nullptr);
  return pointers_.data();
}

bool read_arguments(int argc, char **argv, Arguments *arguments) {
  int rank = 0;
  int state[2] = {1, 0};  // whether all is well, and the task
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) {
    const bool has_none = argc < 2 && !std::getenv("PETSC_OPTIONS");
    if (has_none) arguments->task = Arguments::Task::usage;
    try {
      Reader(*arguments).read({argv + 1, argv + argc});
    } catch (const InputError &error) {
      keep_error(error.what());
      state[0] = 0;
    }
    state[1] = static_cast<int>(arguments->task);
  }
  MPI_Bcast(state, 2, MPI_INT, 0, MPI_COMM_WORLD);
  arguments->task = static_cast<Arguments::Task>(state[1]);
  share(&arguments->words);
  share(&arguments->scene_files);
  return state[0] == 1;
}

}  // namespace trefoil
