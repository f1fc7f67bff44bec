#include "program/help.hpp"

#include <petscsys.h>

#include <sstream>

#include "scene/scene_options.hpp"
#include "trefoil/instruction_set.hpp"

namespace trefoil {
namespace {

constexpr std::size_t name_width = 28;

/// "  -name      ", as wide as a column.
std::string column(const std::string &name) {
  std::string text = "  -" + name + " ";
  if (text.size() < name_width) text.resize(name_width, ' ');
  return text;
}

std::string joined(const std::vector<std::string> &words) {
  std::string list;
  for (const std::string &word : words) list += (list.empty() ? "" : ", ") + word;
  return list;
}

/// What it is, and the choices there are.
std::string meaning_of(const OptionRow &row) {
  return row.choices.empty() ? row.help : row.help + ": " + joined(row.choices);
}

const char *name_of_kernels() {
  switch (chosen_instruction_set()) {
    case InstructionSet::avx512:
      return "AVX-512";
    case InstructionSet::avx2:
      return "AVX2";
    case InstructionSet::baseline:
      break;
  }
  return "any processor";
}

}  // namespace

std::string help_of(const OptionRow &row) {
  std::string text = meaning_of(row);
  if (!row.unit.empty()) text += ", " + row.unit;
  const std::string value = default_text(row.target);
  if (!value.empty()) text += " (" + value + ")";
  return text;
}

std::string short_help() {
  std::string text =
      "Trefoil: the equilibrium of an elastic body, held here, moved or loaded there\n"
      "usage: [mpirun -n 4] trefoil [--check] [scene.yaml ...] [-option value ...]\n"
      "  trefoil examples/knot.yaml -output_file knot.xdmf\n"
      "  mpirun -n 4 trefoil examples/knot.yaml -mesh_refine 1 -snes_trefoil_record knot.json\n"
      "  trefoil --check examples/knot.yaml              builds the scene and solves nothing\n"
      "-mesh_file a.msh is mesh: {file: a.msh} in a scene file; what comes later wins\n";
  for (const OptionGroup &group : scene_option_groups()) {
    std::string rows;
    for (const OptionRow &row : group.rows) {
      if (row.is_essential) rows += column(row.name) + row.help + "\n";
    }
    if (!rows.empty()) text += group.title + "\n" + rows;
  }
  return text + "Solver: any -snes_*, -ksp_* and -pc_* of PETSc, and\n" +
         column("snes_trefoil_filter") + "Rule of the filter's weight (adaptive)\n" +
         column("snes_trefoil_energy_tolerance") + "Where to stop, share of the energy (1e-8)\n" +
         column("snes_trefoil_record") + "JSON record of the run\n" +
         "--help all lists every option, --version what this is; examples/README.md explains\n";
}

std::string scene_help() {
  std::ostringstream text;
  for (const OptionGroup &group : scene_option_groups()) {
    text << group.title << "\n";
    for (const OptionRow &row : group.rows) {
      text << column(row.name) << help_of(row) << "\n";
    }
  }
  return text.str();
}

std::string scene_keys() {
  std::string text;
  for (const OptionGroup &group : scene_option_groups()) {
    for (const OptionRow &row : group.rows) {
      text += group.title + "\t" + row.name + "\t" + meaning_of(row) + "\t" + row.unit + "\t" +
              default_text(row.target) + "\n";
    }
  }
  return text;
}

std::string version_text(int ranks) {
  char petsc[256] = "";
  static_cast<void>(PetscGetVersion(petsc, sizeof petsc));
  std::string petsc_version = petsc;
  petsc_version = petsc_version.substr(0, petsc_version.find(','));
  return "Trefoil " TREFOIL_VERSION "\n" + petsc_version + "\n" + std::to_string(ranks) +
         (ranks == 1 ? " rank" : " ranks") + ", kernels for " + name_of_kernels() + "\n";
}

}  // namespace trefoil
