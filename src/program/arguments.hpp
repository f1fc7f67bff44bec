#pragma once

#include <string>
#include <vector>

namespace trefoil {

/// What the command line asks for.
struct Arguments {
  enum class Task {
    run,      ///< a scene, or PETSc's -help
    usage,    ///< nothing: no arguments at all
    help,     ///< --help, -h
    version,  ///< --version
    manual,   ///< --help man
    keys,     ///< --help keys
  };
  Task task = Task::run;
  std::vector<std::string> words;        ///< options and values for PETSc, those of files included
  std::vector<std::string> scene_files;  ///< files that are read, so that none is written over

  /// The words as main() would get them, behind a program's name and a null pointer at the end;
  /// valid as long as this object is.
  char **argv();

 private:
  std::vector<char *> pointers_;
};

/// Reads the command line and the files that it names, on the first rank, and tells the others:
///
///   trefoil [--check] [scene.yaml ...] [-option value ...]
///
/// Scene files in YAML and files of options in PETSc's own format, given by name or by
/// -options_file, become options in their place. Collective; works before PetscInitialize.
/// @return whether all is well; otherwise an error is kept, see keep_error()
bool read_arguments(int argc, char **argv, Arguments *arguments);

}  // namespace trefoil
