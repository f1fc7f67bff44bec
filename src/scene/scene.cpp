#include "scene/scene.hpp"

#include <petsctime.h>

#include <cmath>

#include "mesh/check_mesh.hpp"
#include "mesh/generate.hpp"
#include "mesh/io/read_mesh.hpp"
#include "mesh/locality.hpp"
#include "mesh/quadratic.hpp"
#include "scene/constraints.hpp"
#include "scene/loads.hpp"
#include "scene/regions.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/dead_load_term.hpp"
#include "term/elastic_term.hpp"

namespace trefoil {
namespace {

std::string mesh_name(const SceneOptions &options) {
  return options.mesh_file.empty() ? "generated " + options.generate : options.mesh_file;
}

/// Refines, as the distributed mesh can where its cells are linear, and adds midpoints of edges.
void make_quadratic(const SceneOptions &options, CellList &whole) {
  const PetscInt refine = options.mesh_file.empty() ? 0 : options.refine;
  for (PetscInt level = 0; level < refine && !is_quadratic(*whole.shape); ++level) {
    if (8. * whole.shape->children * static_cast<double>(whole.cells.size()) > PETSC_MAX_INT)
      throw InputError("-mesh_refine " + std::to_string(refine) +
                       " would make more cells than can be numbered; refine less");
    refine_uniformly(whole);
  }
  promote_to_quadratic(whole);
}

/// The whole mesh, on the first rank, ready to be distributed. Throws InputError.
CellList prepare_mesh(const SceneOptions &options, PetscInt *unused, PetscInt *dropped) {
  CellList whole = options.mesh_file.empty()
                       ? generate_mesh(options.generate, options.resolution, options.refine)
                       : read_mesh(options.mesh_file);
  if (options.order == 1) drop_midpoints(whole);
  const Repair repair = options.repair == "drop" ? Repair::drop : Repair::none;
  *dropped = repair_rest_shape(whole, repair, mesh_name(options));
  check_curved_cells(whole, mesh_name(options));
  *unused = drop_unused_vertices(whole);
  if (options.order == 2) make_quadratic(options, whole);
  if (options.normalize) normalize(whole);
  order_along_curve(whole);
  return whole;
}

/// Refuses what PetscInt cannot number: each refinement cuts a tetrahedron into eight.
PetscErrorCode check_refined_size(MPI_Comm comm, const CellList &whole, PetscInt refine) {
  PetscInt shape[2] = {whole.size(), whole.shape->order};  // known on the first rank
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(shape, 2, MPIU_INT, 0, comm));
  PetscCheck(shape[1] == 1 || refine == 0, comm, PETSC_ERR_USER_INPUT,
             "-mesh_refine works on linear cells, and the mesh's are quadratic; refine it in the "
             "mesher, or give -order 1");
  const double entries = 4. * shape[0] * std::pow(8., refine);
  PetscCheck(entries < PETSC_MAX_INT, comm, PETSC_ERR_USER_INPUT,
             "-mesh_refine %" PetscInt_FMT " would make more than %.1g tetrahedra; refine less",
             refine, PETSC_MAX_INT / 4.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode load_mesh(MPI_Comm comm, const SceneOptions &options, Mesh *mesh) {
  PetscMPIInt rank = 0, ranks = 0;
  PetscInt unused = 0, dropped = 0;
  CellList whole;
  std::string complaint;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  if (rank == 0) {
    complaint = complaint_of([&] { whole = prepare_mesh(options, &unused, &dropped); });
  }
  PetscCall(agree_on_complaint(comm, complaint));
  if (dropped) {
    PetscCall(PetscPrintf(comm, "dropped %" PetscInt_FMT " %s without positive volume\n", dropped,
                          whole.shape->plural));
  }
  if (unused) {
    PetscCall(PetscPrintf(comm, "dropped %" PetscInt_FMT " vertices that no %s uses\n", unused,
                          whole.shape->singular));
  }
  // A generated mesh was refined where it was generated, true to its curved boundary.
  // So was one that was made quadratic.
  const PetscInt refine = options.mesh_file.empty() || options.order == 2 ? 0 : options.refine;
  PetscCall(check_refined_size(comm, whole, refine));
  PetscCall(distribute_mesh(comm, whole, options.partitioner, refine, mesh));
  const bool quadratic = is_quadratic(*mesh->shape);
  PetscCall(PetscPrintf(comm, "mesh: %s, %" PetscInt_FMT " %s, %" PetscInt_FMT " %s%s",
                        mesh_name(options).c_str(), mesh->total_vertices,
                        quadratic ? "nodes" : "vertices", mesh->total_cells,
                        quadratic ? "quadratic " : "", mesh->shape->plural));
  if (ranks > 1) {
    PetscCall(PetscPrintf(comm, " on %d ranks, edge cut %" PetscInt_FMT ", imbalance %.3f", ranks,
                          mesh->edge_cut, mesh->imbalance));
  }
  PetscCall(PetscPrintf(comm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The elastic term of the materials that the options name.
std::unique_ptr<Term> make_elastic_term(const SceneOptions &options, const Mesh &mesh,
                                        const std::vector<int> &region_of_cell) {
  std::vector<std::unique_ptr<MaterialModel>> materials;
  materials.push_back(make_material(options.material));
  for (const RegionOptions &region : options.regions) {
    materials.push_back(make_material(region.material));
  }
  // Without regions, all cells have the first.
  MaterialRuns runs = options.regions.empty()
                          ? MaterialRuns(std::move(materials.front()), mesh.local_cells())
                          : MaterialRuns(std::move(materials), region_of_cell);
  const auto space =
      options.filter_space == "deformation" ? FilterSpace::deformation : FilterSpace::element;
  return std::make_unique<ElasticTerm>(mesh, std::move(runs), space);
}

/// The term of the loads, where the options name any. Keeps `scene`, whose functional owns it.
PetscErrorCode add_loads(const std::vector<int> &region_of_cell, Scene *scene) {
  const SceneOptions &options = scene->options;
  std::vector<double> densities{options.material.density};
  PetscFunctionBeginUser;
  if (!options.loads.any()) PetscFunctionReturn(PETSC_SUCCESS);
  for (const RegionOptions &region : options.regions) densities.push_back(region.material.density);
  for (const int region : region_of_cell) {
    scene->density_of_cell.push_back(densities[static_cast<std::size_t>(region)]);
  }
  scene->functional->add_term(std::make_unique<DeadLoadTerm>([scene](double time,
                                                                     std::vector<double> *forces) {
    return evaluate_loads(scene->mesh, scene->options.loads, scene->density_of_cell, time, forces);
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

Scene::~Scene() {
  static_cast<void>(VecDestroy(&displacement));  // errors have nowhere to go from here
  static_cast<void>(MatDestroy(&hessian));
}

PetscErrorCode build_scene(MPI_Comm comm, const SceneOptions &options, Scene *scene) {
  HeldDofs held;
  std::vector<int> region_of_cell;
  PetscLogDouble begin = 0, loaded = 0, end = 0;
  PetscFunctionBeginUser;
  scene->options = options;
  PetscCall(PetscTime(&begin));
  PetscCall(load_mesh(comm, options, &scene->mesh));
  PetscCall(PetscTime(&loaded));
  PetscCall(hold_vertices(scene->mesh, options.constraints, 1, &held));
  PetscCall(check_rigid_body_modes(scene->mesh, held));
  PetscCall(scene->discretization.set_up(scene->mesh, held));
  PetscCheck(scene->discretization.total_dofs() > 0, comm, PETSC_ERR_USER_INPUT,
             "the constraints hold every vertex; nothing is left to solve for");
  if (!scene->discretization.has_whole_blocks()) {
    PetscCall(PetscPrintf(comm,
                          "some vertices are held in single components: matrix block size "
                          "1, with which algebraic multigrid is slower\n"));
  }
  scene->functional = std::make_unique<EnergyFunctional>(scene->discretization);
  PetscCall(assign_regions(scene->mesh, options.regions, &region_of_cell));
  scene->functional->add_term(make_elastic_term(options, scene->mesh, region_of_cell));
  PetscCall(add_loads(region_of_cell, scene));
  PetscCall(scene->functional->set_time(1));
  PetscCall(scene->discretization.create_vector(&scene->displacement));
  PetscCall(scene->discretization.create_matrix(&scene->hessian));
  if (options.assembly == "split") PetscCall(scene->functional->prepare(scene->hessian));
  PetscCall(PetscTime(&end));
  scene->read_seconds = loaded - begin;
  scene->setup_seconds = end - loaded;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
