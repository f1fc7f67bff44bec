#include "scene/scene_options.hpp"

#include <petscpartitioner.h>

#include <algorithm>
#include <filesystem>

#include "scene/initial_displacement.hpp"
#include "scene/option_reader.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

PetscErrorCode read_constraints(MPI_Comm comm, OptionReader &reader, SceneOptions *options) {
  std::vector<std::string> names;
  PetscFunctionBeginUser;
  PetscCall(reader.names("constraints", "Names of the constraints, separated by commas", &names));
  for (const std::string &name : names) {
    PetscCheck(std::count(names.begin(), names.end(), name) == 1, comm, PETSC_ERR_USER_INPUT,
               "-constraints names '%s' twice; give each constraint its own name", name.c_str());
    ConstraintOptions constraint{name, "", ""};
    PetscCall(reader.text("constraint_" + name + "_where",
                          "Which vertices: an expression in x y z t xmin..zmax",
                          &constraint.where));
    PetscCall(
        reader.text("constraint_" + name + "_move",
                    "Their displacement: an expression for each dimension, or free; zero without",
                    &constraint.move));
    PetscCheck(!constraint.where.empty(), comm, PETSC_ERR_USER_INPUT,
               "constraint '%s' has no -constraint_%s_where: say which vertices it takes",
               name.c_str(), name.c_str());
    options->constraints.push_back(constraint);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_choice(MPI_Comm comm, const char *option, const std::string &value,
                            std::initializer_list<const char *> choices) {
  std::string list;
  PetscFunctionBeginUser;
  for (const char *choice : choices) {
    if (value == choice) PetscFunctionReturn(PETSC_SUCCESS);
    list += (list.empty() ? "" : ", ") + std::string(choice);
  }
  SETERRQ(comm, PETSC_ERR_USER_INPUT, "-%s knows no '%s'; it knows: %s", option, value.c_str(),
          list.c_str());
}

/// Checked here and not only where a mesh is partitioned, which on one rank none is.
PetscErrorCode check_partitioner(MPI_Comm comm, const std::string &name) {
  PetscErrorCode (*create)(PetscPartitioner) = nullptr;
  PetscFunctionBeginUser;
  if (name == "metis") PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPartitionerInitializePackage());
  PetscCall(PetscFunctionListFind(PetscPartitionerList, name.c_str(), &create));
  PetscCheck(create, comm, PETSC_ERR_USER_INPUT,
             "there is no partitioner '%s' (-mesh_partitioner); use metis or ptscotch",
             name.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool is_same_file(const std::string &one, const std::string &other) {
  const auto normal = [](const std::string &path) {
    std::error_code ignored;
    const auto whole = std::filesystem::weakly_canonical(std::filesystem::absolute(path), ignored);
    return ignored ? std::filesystem::path(path) : whole;
  };
  return !one.empty() && !other.empty() && normal(one) == normal(other);
}

/// No file is written over another that is read or written.
PetscErrorCode check_files(MPI_Comm comm, const SceneOptions &options) {
  PetscFunctionBeginUser;
  const std::string data =
      options.output_file.empty()
          ? ""
          : std::filesystem::path(options.output_file).replace_extension(".h5").string();
  for (const std::string &other : {options.mesh_file, options.output_file, data}) {
    PetscCheck(!is_same_file(options.record_file, other), comm, PETSC_ERR_USER_INPUT,
               "-snes_trefoil_record would write over '%s'; give the record another name",
               other.c_str());
  }
  for (const std::string &written : {options.output_file, data}) {
    PetscCheck(!is_same_file(written, options.mesh_file), comm, PETSC_ERR_USER_INPUT,
               "-output_file would write over the mesh '%s'; give the output another name",
               written.c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_values(MPI_Comm comm, const SceneOptions &options) {
  PetscBool has_steps = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCheck(options.mesh_file.empty() != options.generate.empty(), comm, PETSC_ERR_USER_INPUT,
             options.mesh_file.empty()
                 ? "there is no mesh: give -mesh_file or -mesh_generate"
                 : "a scene has one mesh: give either -mesh_file or -mesh_generate, not both");
  PetscCall(check_partitioner(comm, options.partitioner));
  PetscCall(check_choice(comm, "mesh_repair", options.repair, {"none", "drop"}));
  PetscCheck(options.refine >= 0 && options.resolution >= 0, comm, PETSC_ERR_USER_INPUT,
             "-mesh_refine and -mesh_resolution must not be negative");
  PetscCheck(options.resolution == 0 || options.mesh_file.empty(), comm, PETSC_ERR_USER_INPUT,
             "-mesh_resolution is for generated meshes; use -mesh_refine for a mesh from a file");
  PetscCheck(options.load_steps > 0, comm, PETSC_ERR_USER_INPUT,
             "-load_steps is %" PetscInt_FMT "; give 1 or more", options.load_steps);
  PetscCall(check_files(comm, options));
  PetscCall(check_choice(comm, "initial", options.initial,
                         {"auto", "rest", "harmonic", "arap", "expression"}));
  PetscCheck((options.initial == "expression") == !options.initial_displacement.empty(), comm,
             PETSC_ERR_USER_INPUT,
             options.initial == "expression"
                 ? "-initial expression needs -initial_displacement: three expressions"
                 : "-initial_displacement is for -initial expression");
  PetscCheck(options.initial_steps >= 0, comm, PETSC_ERR_USER_INPUT,
             "-initial_steps must not be negative");
  PetscCall(PetscOptionsHasName(nullptr, nullptr, "-initial_steps", &has_steps));
  const std::string initial = choose_initial(options);
  PetscCheck(!has_steps || initial == "arap", comm, PETSC_ERR_USER_INPUT,
             "-initial_steps is for -initial arap; the start is '%s'", initial.c_str());
  PetscCheck(options.order >= 0 && options.order <= 2, comm, PETSC_ERR_USER_INPUT,
             "-order is %" PetscInt_FMT
             "; elements are linear (1), quadratic (2), or as the mesh has them (0)",
             options.order);
  PetscCall(
      check_choice(comm, "snes_trefoil_space", options.filter_space, {"element", "deformation"}));
  PetscCall(check_choice(comm, "assembly", options.assembly, {"split", "plain", "hook"}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode read_scene_options(MPI_Comm comm, SceneOptions *options) {
  OptionReader reader(comm);
  PetscFunctionBeginUser;
  PetscCall(reader.text("mesh_file", "Tetrahedra or triangles: Medit .mesh, Gmsh .msh 2.2 or 4.1",
                        &options->mesh_file));
  PetscCall(reader.text("mesh_generate", "A generated mesh: knot, box, cylinder, ball, square",
                        &options->generate));
  PetscCall(reader.integer("mesh_resolution", "Cells across a generated mesh; 0: 2-5 thousand",
                           &options->resolution));
  PetscCall(reader.integer("mesh_refine", "How often to halve all edges", &options->refine));
  PetscCall(reader.flag("mesh_normalize", "Centre the vertices and scale the farthest to norm 1",
                        &options->normalize));
  PetscCall(reader.text("mesh_repair", "Tetrahedra without positive volume: none, or drop",
                        &options->repair));
  PetscCall(reader.text("mesh_partitioner", "metis, or a partitioner of PETSc such as ptscotch",
                        &options->partitioner));
  PetscCall(read_material(comm, reader, "material", &options->material));
  PetscCall(read_regions(comm, reader, options->material, &options->regions));
  PetscCall(read_loads(comm, reader, &options->loads));
  PetscCall(
      reader.integer("load_steps", "Solves on the way of t from 0 to 1", &options->load_steps));
  PetscCall(read_constraints(comm, reader, options));
  PetscCall(
      reader.text("initial",
                  "Start: rest, prescribed vertices already moved; harmonic: their displacement "
                  "spread over the body; arap: then as rigid as possible; auto: arap, but "
                  "harmonic where a material is nearly incompressible; expression: "
                  "-initial_displacement",
                  &options->initial));
  PetscCall(reader.integer("initial_steps", "Local/global steps of -initial arap",
                           &options->initial_steps));
  PetscCall(reader.text("initial_displacement",
                        "Displacement that -initial expression starts from: three expressions in "
                        "x y z xmin..zmax",
                        &options->initial_displacement));
  PetscCall(reader.integer("order", "Order of the elements: 1, 2; 0: as the mesh has it",
                           &options->order));
  PetscCall(reader.text("snes_trefoil_space", "What is filtered: element, deformation",
                        &options->filter_space));
  PetscCall(reader.text("assembly",
                        "split: H and N at once, in batches; plain: the same by LAPACK and "
                        "MatSetValues; hook: as a code that knows nothing of Trefoil",
                        &options->assembly));
  PetscCall(
      reader.text("output_file", "Result for ParaView, an .xdmf file", &options->output_file));
  PetscCall(reader.text("snes_trefoil_record", "JSON record of the run", &options->record_file));
  if (reader.prints_help()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(reader.refuse_unknown({"mesh_", "material_", "region", "load", "constraint", "initial",
                                   "order", "assembly", "output_"}));
  PetscCall(check_values(comm, *options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
