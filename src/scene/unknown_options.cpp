#include "scene/unknown_options.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>

#include "scene/scene_options.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using Words = std::vector<std::string>;

/// What options of PETSc's classes begin with: read when the solver is set up.
const Words solver_families{
    "snes_",       "ksp_",   "pc_",      "mat_",        "vec_",
    "dm_",         "is_",    "sf_",      "sub_",        "mg_",
    "fieldsplit_", "npc_",   "matptap_", "matmatmult_", "mattransposematmult_",
    "guess_",      "inner_", "esteig_",  "redundant_",  "telescope_"};
/// Nested prefixes of the user's or of a preconditioner's: -prometheus_ksp_type.
const Words nested_families{"_snes_", "_ksp_", "_pc_", "_mat_"};
/// What PETSc reads when it begins, when it ends, or when it draws.
const Words other_families{"log",
                           "malloc",
                           "options_",
                           "info",
                           "objects_",
                           "memory",
                           "viewer",
                           "draw",
                           "display",
                           "x_",
                           "citations",
                           "get_total_flops",
                           "check",
                           "on_error",
                           "start_in_debugger",
                           "stop_for_debugger",
                           "debug",
                           "fp_trap",
                           "no_signal_handler",
                           "help",
                           "version",
                           "saws",
                           "python",
                           "dll_",
                           "cuda",
                           "hip",
                           "device",
                           "use_gpu",
                           "history",
                           "petsc",
                           "mpi",
                           "shared_tmp",
                           "not_shared_tmp",
                           "tmp",
                           "error_output",
                           "skip_petscrc",
                           "prefix_",
                           "vecscatter",
                           "root_device",
                           "default_device",
                           "kokkos",
                           "nox",
                           "geometry"};
const Words at_any_time{"view", "converged_reason", "draw_pause"};

/// What other programs call it.
const std::map<std::string, std::string> synonyms{{"E", "young"},
                                                  {"e", "young"},
                                                  {"youngs_modulus", "young"},
                                                  {"young_modulus", "young"},
                                                  {"modulus", "young"},
                                                  {"nu", "poisson"},
                                                  {"poisson_ratio", "poisson"},
                                                  {"poissons_ratio", "poisson"},
                                                  {"rho", "density"},
                                                  {"type", "model"},
                                                  {"displacement", "move"},
                                                  {"value", "move"},
                                                  {"nodes", "where"},
                                                  {"select", "where"},
                                                  {"selection", "where"},
                                                  {"tag", "group"},
                                                  {"physical_group", "group"},
                                                  {"surface", "group"},
                                                  {"fix", "constraints"},
                                                  {"fixed", "constraints"},
                                                  {"bcs", "constraints"},
                                                  {"boundary_conditions", "constraints"},
                                                  {"body_force", "gravity"},
                                                  {"mesh", "mesh_file"},
                                                  {"geometry", "mesh_file"},
                                                  {"output", "output_file"},
                                                  {"load_step", "load_steps"}};

bool begins_with_one_of(const Words &prefixes, const std::string &option) {
  return std::any_of(prefixes.begin(), prefixes.end(),
                     [&](const std::string &prefix) { return option.rfind(prefix, 0) == 0; });
}

bool has_one_of(const Words &parts, const std::string &option) {
  return std::any_of(parts.begin(), parts.end(), [&](const std::string &part) {
    return option.find(part) != std::string::npos;
  });
}

/// Names of the options that nothing has asked for so far.
PetscErrorCode find_unused(Words *unused) {
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  unused->assign(names, names + count);
  PetscCall(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

/// What may be meant by an option that there is not.
class Suggestion {
 public:
  explicit Suggestion(const std::set<std::string> &known) : known_(known.begin(), known.end()) {
    for (const OptionGroup &group : scene_option_groups()) {
      for (const OptionRow &row : group.rows) {
        if (!known.count(row.name)) known_.push_back(row.name);  // of parts that are not there
      }
    }
  }

  /// The tail of a sentence; empty where nothing comes to mind.
  [[nodiscard]] std::string of(const std::string &option) const {
    const std::string unlisted = part_that_is_not_listed(option);
    std::string name;
    for (const std::string &guess : {with_tail(option), by_synonym(option), nearest(option)}) {
      if (name.empty()) name = guess;
    }
    return (name.empty() ? "" : ", perhaps you mean -" + name + in_yaml(name)) + unlisted;
  }

  [[nodiscard]] bool is_misspelt(const std::string &option) const {
    constexpr std::size_t letters_an_error = 4, most_errors = 2;
    return std::any_of(known_.begin(), known_.end(), [&](const std::string &name) {
      return distance(name, option) <= std::min(name.size() / letters_an_error, most_errors);
    });
  }

 private:
  [[nodiscard]] bool is_known(const std::string &name) const {
    return std::find(known_.begin(), known_.end(), name) != known_.end();
  }

  [[nodiscard]] std::string nearest(const std::string &option) const {
    const std::string &best = *std::min_element(
        known_.begin(), known_.end(),
        [&](const auto &a, const auto &b) { return distance(a, option) < distance(b, option); });
    return distance(best, option) <= option.size() / 3 ? best : "";
  }

  /// `young` is the tail of material_young.
  [[nodiscard]] std::string with_tail(const std::string &option) const {
    const auto found = std::find_if(known_.begin(), known_.end(), [&](const std::string &name) {
      return name.ends_with("_" + option);
    });
    return found == known_.end() ? "" : *found;
  }

  [[nodiscard]] std::string by_synonym(const std::string &option) const {
    for (std::size_t begin = 0; begin != std::string::npos;) {
      const auto found = synonyms.find(option.substr(begin));
      if (found != synonyms.end()) {
        const std::string name = option.substr(0, begin) + found->second;
        return is_known(name) ? name : with_tail(found->second);
      }
      begin = option.find('_', begin);
      if (begin != std::string::npos) ++begin;
    }
    return "";
  }

  /// An option of a load, say, that no list names: -load_top_where without -loads top.
  [[nodiscard]] std::string part_that_is_not_listed(const std::string &option) const {
    const std::string mark = "NAME";
    for (const std::string &row : known_) {
      const std::size_t at = row.find(mark);
      if (at == std::string::npos) continue;
      const std::string before = row.substr(0, at), after = row.substr(at + mark.size());
      if (option.rfind(before, 0) != 0 || !option.ends_with(after)) continue;
      if (option.size() <= before.size() + after.size()) continue;
      const std::string part =
          option.substr(before.size(), option.size() - before.size() - after.size());
      const std::string one = before.substr(0, before.size() - 1);
      return "; the scene has no " + one + " '" + part + "': name it in -" + one + "s, or write " +
             one + "s: {" + part + ": {...}}";
    }
    for (const std::string one : {"constraint", "load", "region", "obstacle"}) {
      if (option.rfind(one + "_", 0) == 0) {
        return "; the names of the " + one + "s come from -" + one + "s";
      }
    }
    return "";
  }

  /// How a scene file writes it.
  static std::string in_yaml(const std::string &name) {
    for (const std::string one : {"constraint", "load", "region", "obstacle"}) {
      const std::size_t begin = one.size() + 1, end = name.find('_', begin);
      if (name.rfind(one + "_", 0) != 0 || end == std::string::npos) continue;
      return ", in a scene file " + one + "s: {" + name.substr(begin, end - begin) + ": {" +
             name.substr(end + 1) + ": ...}}";
    }
    for (const std::string section : {"mesh", "material", "output", "load", "contact"}) {
      if (name.rfind(section + "_", 0) != 0) continue;
      return ", in a scene file " + section + ": {" + name.substr(section.size() + 1) + ": ...}";
    }
    return "";
  }

  Words known_;
};

}  // namespace

PetscErrorCode refuse_unknown(MPI_Comm comm, const std::set<std::string> &known) {
  Words unused;
  PetscFunctionBeginUser;
  PetscCall(find_unused(&unused));
  const Suggestion suggestion(known);
  for (const std::string &option : unused) {
    const bool of_petsc = begins_with_one_of(solver_families, option) ||
                          begins_with_one_of(other_families, option) ||
                          has_one_of(nested_families, option);
    if (known.count(option) || (of_petsc && !suggestion.is_misspelt(option))) continue;
    SETERRQ(comm, PETSC_ERR_USER_INPUT, "there is no option -%s here%s; --help all lists all",
            option.c_str(), suggestion.of(option).c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode refuse_unused(MPI_Comm comm, const Words &prefixes) {
  Words unused;
  PetscFunctionBeginUser;
  PetscCall(find_unused(&unused));
  for (const std::string &option : unused) {
    PetscCheck(!begins_with_one_of(prefixes, option), comm, PETSC_ERR_USER_INPUT,
               "nothing here uses -%s; check its name, or leave it out", option.c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode refuse_unused_of_solver(MPI_Comm comm) {
  Words unused;
  PetscFunctionBeginUser;
  PetscCall(find_unused(&unused));
  for (const std::string &option : unused) {
    const bool of_guess = option.rfind("guess_", 0) == 0;  // asked for before the solve, if at all
    if (of_guess || begins_with_one_of(other_families, option) || has_one_of(at_any_time, option))
      continue;
    SETERRQ(comm, PETSC_ERR_USER_INPUT, "nothing here uses -%s; check its name, or leave it out",
            option.c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
