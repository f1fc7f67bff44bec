#include "scene/scene.hpp"

#include <petsctime.h>

#include <algorithm>
#include <cmath>

#include "mesh/io/hdf5_mesh.hpp"
#include "mesh/io/load_mesh.hpp"
#include "scene/bent_cells_check.hpp"
#include "scene/body_materials.hpp"
#include "scene/constraints.hpp"
#include "scene/contact_scene.hpp"
#include "scene/element_pressure.hpp"
#include "scene/initial_displacement.hpp"
#include "scene/loads.hpp"
#include "scene/locking.hpp"
#include "scene/regions.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

MeshOptions mesh_options(const SceneOptions &options) {
  return {.file = options.mesh_file,
          .generate = options.generate,
          .bodies = options.bodies,
          .resolution = options.resolution,
          .refine = options.refine,
          .order = options.order,
          .normalize = options.normalize,
          .drops_bad_cells = options.repair == "drop",
          .partitioner = options.partitioner};
}

/// Whether all cells are in regions. Collective.
PetscErrorCode find_all_regions(MPI_Comm comm, const std::vector<int> &region_of_cell, bool *all) {
  PetscMPIInt any_left = std::count(region_of_cell.begin(), region_of_cell.end(), 0) > 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &any_left, 1, MPI_INT, MPI_MAX, comm));
  *all = any_left == 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The elastic term of the materials that the options name.
PetscErrorCode add_elastic_term(const std::vector<int> &region_of_cell, Scene *scene) {
  const SceneOptions &options = scene->options;
  const Mesh &mesh = scene->mesh;
  PetscFunctionBeginUser;
  const auto space =
      options.filter_space == "deformation" ? FilterSpace::deformation : FilterSpace::element;
  auto term =
      std::make_unique<ElasticTerm>(mesh, body_materials(options, mesh, region_of_cell, INFINITY),
                                    space, element_pressure(options));
  scene->elastic = term.get();
  scene->functional->add_term(std::move(term));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The term of the loads, where the options name any. Keeps `scene`, whose functional owns it.
PetscErrorCode add_loads(const std::vector<int> &region_of_cell, Scene *scene) {
  const SceneOptions &options = scene->options;
  std::vector<double> densities{options.material.density}, density_of_cell;
  PetscFunctionBeginUser;
  for (const RegionOptions &region : options.regions) densities.push_back(region.material.density);
  for (const int region : region_of_cell) {
    density_of_cell.push_back(densities[static_cast<std::size_t>(region)]);
  }
  PetscCall(scene->loads.choose(scene->mesh, options.loads, options.where_tolerance,
                                std::move(density_of_cell)));
  for (auto &term : scene->loads.make_terms()) scene->functional->add_term(std::move(term));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What is to be known of the materials: that one is nobody's choice, and where elements lock.
PetscErrorCode tell_materials(MPI_Comm comm, Scene *scene) {
  const SceneOptions &options = scene->options;
  double largest = -1;
  PetscFunctionBeginUser;
  for (const MaterialOptions &material : materials_of_cells(options)) {
    largest = std::max(largest, poisson_at_rest(material));
  }
  if (!options.is_all_regions && !options.material.is_named) {
    PetscCall(PetscPrintf(comm,
                          "material: none is named, so the default: %s, Young's modulus %g, "
                          "Poisson's ratio %g\n",
                          options.material.model.c_str(),
                          options.material.parameters.constants.young,
                          options.material.parameters.constants.poisson));
  }
  if (is_nearly_incompressible(options) && !is_quadratic(*scene->mesh.shape)) {
    scene->warnings.push_back(
        warn_of_locking(scene->mesh.dimension(), largest, options.contact.is_on));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where vertices are held along axes of their own, each on one rank.
void add_supports(const Mesh &mesh, const HeldDofs &held, std::vector<Support> *supports) {
  for (const TurnedVertex &turned : held.turned) {
    if (!mesh.owned[static_cast<std::size_t>(turned.vertex)]) continue;
    for (int k = 0; k < turned.held; ++k) {
      supports->push_back({turned.vertex, turned.axes[static_cast<std::size_t>(k)]});
    }
  }
}

/// One line for each constraint and load: what it takes.
PetscErrorCode print_choices(MPI_Comm comm, Scene *scene) {
  const bool plane = scene->mesh.dimension() == 2;
  const char *size = plane ? "length" : "area";
  std::vector<LoadReport> &loads = scene->load_reports;
  PetscFunctionBeginUser;
  for (const ConstraintReport &report : scene->constraints.reports()) {
    PetscCall(PetscPrintf(comm, "%s: %lld %s, %s %.6g\n", report.name.c_str(),
                          static_cast<long long>(report.vertices),
                          report.vertices == 1 ? "vertex" : "vertices", size, report.area));
  }
  const std::vector<double> rest(scene->mesh.coordinates.size(), 0);
  PetscCall(scene->loads.report(scene->options.time.is_on ? 0 : 1, rest.data(), &loads));
  for (const LoadReport &report : loads) {
    const auto &force = report.resultant.force;
    PetscCall(PetscPrintf(comm, "%s: ", report.name.c_str()));
    if (report.facets > 0) {
      PetscCall(PetscPrintf(comm, "%lld %s, %s %.6g, ", static_cast<long long>(report.facets),
                            report.facets == 1 ? "facet" : "facets", size, report.area));
    }
    PetscCall(PetscPrintf(comm, "total force (%.6g, %.6g, %.6g)\n", force[0], force[1], force[2]));
  }
  for (const auto *warnings : {&scene->constraints.warnings(), &scene->loads.warnings()}) {
    scene->warnings.insert(scene->warnings.end(), warnings->begin(), warnings->end());
  }
  for (const std::string &warning : scene->warnings) {
    PetscCall(PetscPrintf(comm, "WARNING: %s\n", warning.c_str()));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

Scene::~Scene() {
  static_cast<void>(VecDestroy(&displacement));  // errors have nowhere to go from here
  static_cast<void>(MatDestroy(&hessian));
  static_cast<void>(MatDestroy(&spreading));
}

PetscErrorCode write_mesh(MPI_Comm comm, const SceneOptions &options) {
  Mesh mesh;
  PetscFunctionBeginUser;
  PetscCall(load_mesh(comm, mesh_options(options), check_bent_cells, &mesh));
  PetscCall(write_hdf5_mesh(comm, options.mesh_write, mesh));
  PetscCall(PetscPrintf(comm, "wrote %s\n", options.mesh_write.c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode build_scene(MPI_Comm comm, const SceneOptions &given, Scene *scene) {
  const SceneOptions &options = scene->options;  // with what is chosen below
  const double first_time = given.time.is_on ? 0 : 1;
  HeldDofs held;
  std::vector<int> region_of_cell;
  PetscLogDouble begin = 0, loaded = 0, end = 0;
  PetscFunctionBeginUser;
  scene->options = given;
  PetscCall(PetscTime(&begin));
  PetscCall(scene->progress.begin(comm, options.progress_seconds));
  PetscCall(load_mesh(comm, mesh_options(options), check_bent_cells, &scene->mesh));
  PetscCall(PetscTime(&loaded));
  PetscCall(scene->progress.pass("the mesh is distributed"));
  PetscCall(assign_regions(scene->mesh, options.regions, options.where_tolerance, &region_of_cell));
  PetscCall(find_all_regions(comm, region_of_cell, &scene->options.is_all_regions));
  PetscCall(choose_element_pressure(scene->mesh, &scene->options, &scene->warnings));
  PetscCall(check_initial_steps(comm, options));
  PetscCall(scene->constraints.choose(scene->mesh, options));
  if (options.time.is_on) PetscCall(scene->constraints.warn_of_jumps());
  PetscCall(scene->constraints.hold(first_time, &held));
  PetscCall(scene->discretization.set_up(scene->mesh, held));
  PetscCheck(scene->discretization.total_dofs() > 0, comm, PETSC_ERR_USER_INPUT,
             "the constraints hold every vertex; nothing is left to solve for");
  if (!scene->discretization.has_whole_blocks()) {
    PetscCall(PetscPrintf(comm,
                          "some vertices are held in single components: matrix block size "
                          "1, with which algebraic multigrid is slower\n"));
  }
  scene->functional = std::make_unique<EnergyFunctional>(scene->discretization);
  PetscCall(add_elastic_term(region_of_cell, scene));
  PetscCall(add_loads(region_of_cell, scene));
  PetscCheck(
      !scene->discretization.any_turned() || (options.assembly != "hook" && !options.time.is_on),
      comm, PETSC_ERR_USER_INPUT,
      "vertices slide in a plane that is not parallel to the axes, which %s cannot do; turn "
      "the mesh, or leave that out",
      options.time.is_on ? "a scene in time" : "-assembly hook");
  // In time a body that nothing holds has inertia.
  if (!options.time.is_on) {
    std::vector<Support> supports = scene->loads.supports();
    add_supports(scene->mesh, held, &supports);
    PetscCall(check_rigid_body_modes(scene->mesh, held, supports, options.contact.is_on));
  } else {
    PetscCheck(options.assembly != "hook", comm, PETSC_ERR_USER_INPUT,
               "-assembly hook watches element blocks, and masses are added as a whole matrix: "
               "leave it out in a scene in time");
    scene->motion = std::make_unique<MovingBody>(*scene);
    PetscCall(scene->motion->set_up(region_of_cell));
  }
  if (options.contact.is_on) PetscCall(add_contact(region_of_cell, scene));
  PetscCall(scene->probes.find(scene->mesh, options.probes));
  scene->cells = std::make_unique<CellStates>(scene->mesh, options, std::move(region_of_cell));
  PetscCall(measure_regions(scene->mesh, options, *scene->cells, &scene->regions));
  PetscCall(scene->functional->set_time(first_time));
  PetscCall(tell_materials(comm, scene));
  PetscCall(print_choices(comm, scene));
  PetscCall(scene->discretization.create_vector(&scene->displacement));
  PetscCall(scene->discretization.create_matrix(&scene->hessian));
  if (scene->contact) PetscCall(scene->discretization.create_matrix(&scene->spreading));
  if (options.assembly == "split") PetscCall(scene->functional->prepare(scene->hessian));
  PetscCall(PetscTime(&end));
  PetscCall(scene->progress.pass("the scene is built"));
  scene->read_seconds = loaded - begin;
  scene->setup_seconds = end - loaded;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
