#include "scene/scene_option_rows.hpp"

#include "scene/fields.hpp"

namespace trefoil {
namespace {

const bool essential = true;
const char *const length = "length";

}  // namespace

std::vector<OptionRow> mesh_rows(SceneOptions &options) {
  return {
      {"mesh_file",
       &options.mesh_file,
       "Medit .mesh, Gmsh .msh 2.2 or 4.1, or HDF5 of -mesh_write",
       "",
       {},
       essential},
      {"mesh_files", &options.mesh_files,
       "Instead: files of several bodies, which are called by their names without ending"},
      {"mesh_generate",
       &options.generate,
       "Instead: a body made here",
       "",
       {"knot", "box", "cylinder", "ball", "square"},
       essential},
      {"mesh_resolution", &options.resolution, "Cells across it; 0: 2-5 thousand cells"},
      {"mesh_refine", &options.refine, "How often to halve all edges"},
      {"mesh_normalize", &options.normalize, "Centre the vertices, scale the farthest to norm 1"},
      {"mesh_repair",
       &options.repair,
       "What to do with cells without positive volume",
       "",
       {"none", "drop"}},
      {"mesh_partitioner", &options.partitioner, "metis, or one of PETSc's such as ptscotch"},
      {"mesh_write", &options.mesh_write,
       "Write the mesh here, in HDF5 that all ranks read together; solve nothing"},
      {"order",
       &options.order,
       "Elements: 1 linear, 2 quadratic, 0 as the mesh has them",
       "",
       {},
       essential},
      {"element_pressure",
       &options.element_pressure,
       "Quadratic elements take the volume pointwise, or at the element's mean (constant); auto: "
       "the latter where a material is nearly incompressible",
       "",
       {"auto", "pointwise", "constant"}},
  };
}

OptionRow names_row(const std::string &list, std::vector<std::string> &names) {
  return {list, &names, "Names of the " + list + " where they are not written as keys"};
}

std::vector<OptionRow> region_rows(RegionOptions &region) {
  const std::string option = "region_" + region.name;
  return {
      {option + "_where", &region.where, "Cells: formula at their centroids, x y z xmin..zmax"},
      {option + "_group", &region.group, "Instead: group of the mesh file, by name or number"},
  };
}

std::vector<OptionRow> constraint_rows(ConstraintOptions &constraint) {
  const std::string option = "constraint_" + constraint.name;
  return {
      {option + "_where",
       &constraint.where,
       "Vertices: formula in x y z xmin..zmax",
       "",
       {},
       essential},
      {option + "_group",
       &constraint.group,
       "Those of a group of the mesh file, by name or number",
       "",
       {},
       essential},
      {option + "_move",
       &constraint.move,
       "Displacement, or free, of each direction; 0 without",
       length,
       {},
       essential},
      {option + "_slide", &constraint.slide,
       "Instead: normal of the plane in which they slide, a value a direction"},
  };
}

std::vector<OptionRow> gravity_rows(LoadsOptions &loads) {
  return {{"load_gravity",
           &loads.gravity,
           "Acceleration; needs -material_density",
           "length per time squared",
           {},
           essential}};
}

std::vector<OptionRow> load_rows(LoadOptions &load) {
  const std::string option = "load_" + load.name;
  return {
      {option + "_where",
       &load.where,
       "Facets of the surface: formula at all their corners",
       "",
       {},
       essential},
      {option + "_group",
       &load.group,
       "Those of a group of the mesh file, by name or number",
       "",
       {},
       essential},
      {option + "_traction",
       &load.traction,
       "Force per rest area, one formula a direction",
       "force per area",
       {},
       essential},
      {option + "_force", &load.force, "Whole force, spread by area", "force", {}, essential},
      {option + "_pressure",
       &load.pressure,
       "Pressure, positive into the body",
       "force per area",
       {},
       essential},
      {option + "_follower", &load.follower,
       "The pressure follows the body: on its current area and normal"},
      {option + "_spring", &load.spring, "Elastic foundation: stiffness of springs to rest",
       "force per area and displacement"},
      {option + "_spring_normal", &load.spring_normal,
       "The springs hold along the normal at rest only"},
  };
}

std::vector<OptionRow> solve_rows(SceneOptions &options) {
  return {
      {"load_steps",
       &options.load_steps,
       "Solves on the way of t from 0 to 1: a number, or auto",
       "",
       {},
       essential},
      {"load_steps_first", &options.first_load_step, "Length of the first one of -load_steps auto"},
      {"load_steps_least", &options.least_load_step, "Length below which it halves none"},
      {"initial",
       &options.initial,
       "Start: at rest; prescribed displacements spread (harmonic), then as rigid as possible "
       "(arap); auto: arap, but harmonic where a material is nearly incompressible and "
       "-element_pressure pointwise",
       "",
       {"auto", "rest", "harmonic", "arap", "expression", "file"}},
      {"initial_steps", &options.initial_steps, "Local/global steps of -initial arap"},
      {"initial_displacement", &options.initial_displacement,
       "What -initial expression starts from, in x y z xmin..zmax", length},
      {"initial_file", &options.initial_file,
       "What -initial file starts from: output of Trefoil (.xdmf, .h5, .vtu), or a checkpoint"},
      {"where_tolerance", &options.where_tolerance,
       "What ==, <= and >= of every `where` may be off", "share of the box's diagonal"},
      {"check", &options.check, "Build the scene, say what it holds, solve nothing; also --check"},
      {"solver",
       &options.solver,
       "Of linear systems: by size, memory and Poisson's ratio (auto), Cholesky factors (direct), "
       "or conjugate gradients with multigrid (iterative); -ksp_* and -pc_* win",
       "",
       {"auto", "direct", "iterative"}},
      {"assembly",
       &options.assembly,
       "H and N at once, in batches; plain: by LAPACK and MatSetValues; hook: as a code that "
       "knows nothing of Trefoil",
       "",
       {"split", "plain", "hook"}},
  };
}

std::vector<OptionRow> time_rows(TimeOptions &time) {
  return {
      {"time_end",
       &time.end,
       "Instead: steps in time, up to here, of -time_step",
       "time",
       {},
       essential},
      {"time_step", &time.step, "Length of a step", "time"},
      {"time_step_min", &time.least_step,
       "Steps that fail are halved down to here (a 1024th of -time_step)", "time"},
      {"time_integrator", &time.integrator, "Scheme", "", {"backward_euler", "bdf2", "newmark"}},
      {"time_beta", &time.beta, "Of newmark"},
      {"time_gamma", &time.gamma, "Of newmark"},
      {"time_velocity_tolerance", &time.velocity_tolerance,
       "A step ends where the direction over its length is less; 0: off",
       "the box's diagonal per time"},
      {"time_velocity_tolerance_absolute", &time.absolute_velocity_tolerance,
       "Instead: the same in units of the mesh; 0: off", "length per time"},
      {"time_mass",
       &time.mass,
       "Of linear cells: row sums are lumped",
       "",
       {"consistent", "lumped"}},
      {"time_damping_mass", &time.damping_mass, "Rayleigh damping, times the mass", "1 per time"},
      {"time_damping_stiffness", &time.damping_stiffness,
       "Rayleigh damping, times the clamped stiffness at the start of a step", "time"},
      {"initial_velocity", &time.initial_velocity, "In x y z xmin..zmax", "length per time"},
  };
}

std::vector<OptionRow> probe_rows(ProbeOptions &probe) {
  return {{"probe_" + probe.name,
           &probe.place,
           "Place at rest whose displacement is told",
           length,
           {},
           essential}};
}

std::vector<OptionRow> output_rows(SceneOptions &options) {
  return {
      {"output_file",
       &options.output_file,
       "Fields for ParaView, .xdmf or .vtu",
       "",
       {},
       essential},
      {"output_fields", &options.output_fields, "Which, where not a good few", "",
       names_of_fields(), essential},
      {"output_every", &options.output_every, "Each so many states of a series, and the last"},
      {"output_csv", &options.csv_file, "Table of the results, a line for each step"},
      {"progress_seconds", &options.progress_seconds,
       "Between lines about work that takes long, on stderr; 0: none", "seconds"},
  };
}

std::vector<OptionRow> checkpoint_rows(CheckpointOptions &checkpoint) {
  return {
      {"checkpoint", &checkpoint.file,
       "File (HDF5) that a run can go on from, also written at the end, on SIGUSR1, and on "
       "SIGTERM, "
       "which ends the run"},
      {"checkpoint_every", &checkpoint.every, "Written each so many iterations, in time steps"},
      {"checkpoint_seconds", &checkpoint.seconds,
       "Written each so many seconds; 0: never (60 where -checkpoint_every is not given)",
       "seconds"},
      {"restart", &checkpoint.restart_file,
       "Go on from a checkpoint of the same scene, on any number of ranks"},
  };
}

std::vector<OptionRow> solver_rows(SceneOptions &options) {
  return {
      {"snes_trefoil_space",
       &options.filter_space,
       "What is filtered",
       "",
       {"element", "deformation"}},
      {"snes_trefoil_record", &options.record_file, "JSON record of the run"},
  };
}

std::vector<OptionGroup> scene_option_groups() {
  // Rows point to where their defaults stand, for as long as the program runs.
  static SceneOptions options;
  static RegionOptions region{"NAME"};
  static ConstraintOptions constraint{"NAME"};
  static LoadOptions load{"NAME"};
  static ProbeOptions probe{"NAME"};
  static ObstacleOptions obstacle{"NAME"};
  static BodyOptions body{"NAME"};
  static MaterialInput material, region_material;
  static std::vector<std::string> none;
  material.model = options.material.model;

  const auto joined = [](std::vector<std::vector<OptionRow>> parts) {
    std::vector<OptionRow> all;
    for (const auto &part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
  };
  std::vector<OptionRow> of_region = material_rows("region_NAME_material", region_material);
  for (OptionRow &row : of_region) row.is_essential = false;
  return {
      {"Mesh", joined({mesh_rows(options), {names_row("bodies", none)}, body_rows(body)})},
      {"Material", material_rows("material", material)},
      {"Regions with a material of their own",
       joined({{names_row("regions", none)}, region_rows(region), of_region})},
      {"Constraints", joined({{names_row("constraints", none)}, constraint_rows(constraint)})},
      {"Loads", joined({gravity_rows(options.loads), {names_row("loads", none)}, load_rows(load)})},
      {"Contact", joined({contact_rows(options.contact),
                          {names_row("obstacles", none)},
                          obstacle_rows(obstacle)})},
      {"Solve", joined({solve_rows(options), time_rows(options.time)})},
      {"Output", joined({output_rows(options), {names_row("probes", none)}, probe_rows(probe)})},
      {"Checkpoints", checkpoint_rows(options.checkpoint)},
  };
}

}  // namespace trefoil
