#pragma once

#include <petscsys.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace trefoil {

/// Reads a scene's options from PETSc's database, prints them for -help, and remembers which names
/// exist, so that a misspelt one can be told from a right one.
class OptionReader {
 public:
  explicit OptionReader(MPI_Comm comm);

  [[nodiscard]] bool prints_help() const { return help_; }

  /// Each returns PETSC_ERR_USER_INPUT with a sentence where the value cannot be read.
  /// @param name without the leading dash, for example "mesh_file"
  /// @param value the default, replaced where the option is given
  PetscErrorCode text(const std::string &name, const std::string &help, std::string *value);
  PetscErrorCode number(const std::string &name, const std::string &help, double *value);
  /// A number that has no default: left alone where the option is not given.
  PetscErrorCode number(const std::string &name, const std::string &help,
                        std::optional<double> *value);
  PetscErrorCode integer(const std::string &name, const std::string &help, PetscInt *value);
  PetscErrorCode flag(const std::string &name, const std::string &help, bool *value);
  /// Names, separated by commas or spaces.
  PetscErrorCode names(const std::string &name, const std::string &help,
                       std::vector<std::string> *value);

  /// Refuses options that begin with one of `prefixes`, or nearly have a known name, and were never
  /// asked for; suggests the nearest name. Call it when all have been read.
  PetscErrorCode refuse_unknown(const std::vector<std::string> &prefixes) const;

 private:
  PetscErrorCode find(const std::string &name, const std::string &help,
                      const std::string &default_text, const char **value, bool *found);
  PetscErrorCode find_number(const std::string &name, const std::string &help,
                             const std::string &default_text, double *value, bool *found);
  /// The known name that is most like `option`.
  const std::string &nearest(const std::string &option) const;
  bool is_misspelt(const std::string &option, const std::vector<std::string> &prefixes) const;

  MPI_Comm comm_;
  bool help_ = false;
  std::set<std::string> known_;
};

/// Refuses options that begin with one of `prefixes` and that nothing has asked for, where all that
/// may have done so is set up. Collective.
PetscErrorCode refuse_unused(MPI_Comm comm, const std::vector<std::string> &prefixes);

/// One line with the options that nothing has asked for, most of them misspelt ones of PETSc; call
/// it when all is done. Collective.
PetscErrorCode print_unused_options(MPI_Comm comm);

}  // namespace trefoil
