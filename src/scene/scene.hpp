#pragma once

#include <memory>

#include "assembly/energy_functional.hpp"
#include "output/progress.hpp"
#include "output/run_report.hpp"
#include "scene/cell_states.hpp"
#include "scene/constraints.hpp"
#include "scene/loads.hpp"
#include "scene/moving_body.hpp"
#include "scene/obstacle_output.hpp"
#include "scene/probes.hpp"
#include "scene/scene_options.hpp"
#include "scene/solver_choice.hpp"
#include "term/contact_term.hpp"
#include "term/elastic_term.hpp"

namespace trefoil {

/// A scene, built: what its options name, and nothing else. Members are destroyed in reverse order.
struct Scene {
  SceneOptions options;
  Mesh mesh;
  Discretization discretization;
  std::unique_ptr<EnergyFunctional> functional;
  ElasticTerm *elastic = nullptr;  ///< of the functional
  Constraints constraints;
  ContactTerm *contact = nullptr;        ///< of the functional; null: the scene has none
  std::vector<DrawnObstacle> obstacles;  ///< where there is an output
  Loads loads;
  Probes probes;
  std::unique_ptr<CellStates> cells;     ///< for output
  std::unique_ptr<MovingBody> motion;    ///< of a scene in time
  std::vector<LoadReport> load_reports;  ///< at t = 1, in time at 0, on the body at rest
  std::vector<RegionReport> regions;
  std::vector<std::string> warnings;
  Progress progress;
  Mat hessian = nullptr;
  Mat spreading = nullptr;     ///< of the cells' pattern, where H has another
  Vec displacement = nullptr;  ///< the unknowns; the start, later the solution
  SolverChoice linear_solver;  ///< made where the scene is solved
  double read_seconds = 0, setup_seconds = 0;

  /// The matrix for spreading displacements.
  [[nodiscard]] Mat matrix_of_cells() const { return spreading ? spreading : hessian; }

  ~Scene();
};

/// Reads or generates the mesh and writes it to -mesh_write; nothing else of a scene is needed.
/// Collective; input that makes no mesh is an error with one sentence on all ranks.
PetscErrorCode write_mesh(MPI_Comm comm, const SceneOptions &options);

/// Reads or generates the mesh, distributes it, holds what is held, makes the terms and matrices.
/// Collective; input that makes no scene is an error with one sentence on all ranks.
PetscErrorCode build_scene(MPI_Comm comm, const SceneOptions &given, Scene *scene);

}  // namespace trefoil
