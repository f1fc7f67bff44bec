#pragma once

#include <petscsys.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace trefoil {

/// Where the value of an option goes; what stands there before is its default.
using OptionTarget = std::variant<std::string *, double *, std::optional<double> *, PetscInt *,
                                  bool *, std::vector<std::string> *>;

/// One option of a scene: parsing, the check of names and the help all come from this row.
struct OptionRow {
  std::string name;  ///< without the dash, for example "mesh_file"
  OptionTarget target;
  std::string help;                       ///< one line; what it is
  std::string unit = {};                  ///< of a number, in words; empty: none
  std::vector<std::string> choices = {};  ///< the words that a text may be; empty: any
  bool is_essential = false;              ///< listed in the short help as well
};

/// Rows that belong together, under a heading of the help.
struct OptionGroup {
  std::string title;
  std::vector<OptionRow> rows;
};

/// Reads a scene's options from PETSc's database by their rows, and remembers the names.
class OptionReader {
 public:
  explicit OptionReader(MPI_Comm comm) : comm_(comm) {}

  /// PETSC_ERR_USER_INPUT, with a sentence, where a value cannot be read or is none of the choices.
  PetscErrorCode read(const OptionRow &row);
  PetscErrorCode read(const std::vector<OptionRow> &rows);
  [[nodiscard]] const std::set<std::string> &known() const { return known_; }
  /// Texts of those that were given, by name.
  [[nodiscard]] const std::map<std::string, std::string> &given() const { return given_; }

 private:
  MPI_Comm comm_;
  std::set<std::string> known_;
  std::map<std::string, std::string> given_;
};

/// A default as the help shows it: a text, a number, true, a list; empty where there is none.
std::string default_text(const OptionTarget &target);

}  // namespace trefoil
