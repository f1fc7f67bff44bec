#include "scene/contact_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "input/expression.hpp"
#include "input/selection.hpp"
#include "mesh/io/surface_file.hpp"
#include "output/mesh_output.hpp"
#include "output/series.hpp"
#include "scene/obstacle_check.hpp"
#include "scene/scene.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

using contact::Vector3;

/// A formula's displacement of points. What does not depend on t grows in proportion to it, as
/// constraints do, but where t is time.
class Motion {
 public:
  Motion(const ObstacleOptions &obstacle, const Scene &scene)
      : dimension_(static_cast<std::size_t>(scene.mesh.dimension())) {
    if (obstacle.move.empty()) return;
    formula_ = std::make_shared<Expression>(obstacle.move, "-obstacle_" + obstacle.name + "_move",
                                            box_of(scene.mesh));
    grows_ = !formula_->uses_time() && !scene.options.time.is_on;
  }

  [[nodiscard]] bool uses_place() const { return formula_ && formula_->uses_place(); }
  /// Throws InputError.
  [[nodiscard]] Vector3 at(const Vector3 &place, double time) const {
    Vector3 displacement;
    if (!formula_) return displacement;
    const double position[3] = {place.x, place.y, place.z};
    const std::vector<double> values = formula_->evaluate(position, time, dimension_);
    const double scale = grows_ ? time : 1;
    for (std::size_t i = 0; i < dimension_; ++i) {
      if (Expression::is_free(values[i])) throw InputError("an obstacle is nowhere `free`");
      displacement[static_cast<int>(i)] = scale * values[i];
    }
    return displacement;
  }
  /// What is not finite is no way for anybody, which the check of the way says.
  [[nodiscard]] Vector3 at_or_nowhere(const Vector3 &place, double time) const {
    try {
      return at(place, time);
    } catch (const InputError &) {
      const double nowhere = std::numeric_limits<double>::quiet_NaN();
      return {nowhere, nowhere, nowhere};
    }
  }

 private:
  std::shared_ptr<Expression> formula_;
  bool grows_ = false;
  std::size_t dimension_;
};

/// The obstacles of a scene as the term wants them.
struct Obstacles {
  std::vector<HalfSpaceObstacle> planes;
  std::vector<ObstacleSurface> surfaces;
  std::vector<ObstacleMotion> motions;
  std::vector<double> friction;  ///< of the surfaces
};

Vector3 vector_of(const std::string &text, const std::string &option, const Mesh &mesh) {
  const double origin[3] = {0, 0, 0};
  const auto dimension = static_cast<std::size_t>(mesh.dimension());
  const Expression formula(text, option, box_of(mesh));
  if (formula.uses_time() || formula.uses_place()) {
    throw InputError(option + " is '" + text +
                     "', which depends on x, y, z or t; a half-space is the same everywhere, and "
                     "moves by its `move`");
  }
  const std::vector<double> values = formula.evaluate(origin, 0, dimension);
  Vector3 result;
  for (std::size_t i = 0; i < dimension; ++i) result[static_cast<int>(i)] = values[i];
  return result;
}

/// Throws InputError.
HalfSpaceObstacle make_plane(const ObstacleOptions &obstacle, double friction, const Scene &scene) {
  const Mesh &mesh = scene.mesh;
  const std::string option = "-obstacle_" + obstacle.name;
  Vector3 normal = vector_of(obstacle.plane, option + "_plane", mesh), at;
  if (!obstacle.at.empty()) at = vector_of(obstacle.at, option + "_at", mesh);
  const double length = contact::norm(normal);
  if (!(length > 0)) throw InputError(option + "_plane is no direction: its length is 0");
  normal = (1 / length) * normal;
  const Motion motion(obstacle, scene);
  if (motion.uses_place()) {
    throw InputError(option +
                     "_move depends on x, y or z, but a half-space moves as a whole; give "
                     "a formula in t, or a surface as -obstacle_NAME_file");
  }
  static_cast<void>(motion.at(at, 1));
  return {obstacle.name,
          {normal, contact::dot(normal, at)},
          [motion, at](double time) { return motion.at_or_nowhere(at, time); },
          obstacle.friction.value_or(friction)};
}

PetscErrorCode read_obstacles(const Scene &scene, Obstacles *obstacles) {
  const ContactOptions &options = scene.options.contact;
  const Mesh &mesh = scene.mesh;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  for (const ObstacleOptions &obstacle : options.obstacles) {
    SurfaceMesh read;
    if (!obstacle.file.empty()) PetscCall(read_surface(comm, obstacle.file, &read));
    const std::string complaint = complaint_of([&] {
      if (obstacle.file.empty()) {
        obstacles->planes.push_back(make_plane(obstacle, options.friction, scene));
        return;
      }
      ObstacleSurface surface{obstacle.name, {}, {}};
      for (const auto &p : read.points) surface.points.push_back({p[0], p[1], p[2]});
      surface.facets = read.facets;
      check_facets(read, obstacle.file, mesh.dimension() == 2);
      const Motion motion(obstacle, scene);
      for (const Vector3 &point : surface.points) static_cast<void>(motion.at(point, 1));
      obstacles->motions.push_back([motion, points = surface.points](double time) {
        std::vector<Vector3> moved;
        for (const Vector3 &point : points) moved.push_back(motion.at_or_nowhere(point, time));
        return moved;
      });
      obstacles->friction.push_back(obstacle.friction.value_or(options.friction));
      obstacles->surfaces.push_back(std::move(surface));
    });
    PetscCall(agree_on_complaint(comm, complaint));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<ObstacleSurface> moved_to(const Obstacles &obstacles, double time) {
  std::vector<ObstacleSurface> surfaces = obstacles.surfaces;
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    const std::vector<Vector3> moves = obstacles.motions[k](time);
    for (std::size_t p = 0; p < moves.size(); ++p) {
      surfaces[k].points[p] = surfaces[k].points[p] + moves[p];
    }
  }
  return surfaces;
}

std::vector<DrawnObstacle> drawn(const Obstacles &obstacles, const Mesh &mesh) {
  std::vector<DrawnObstacle> all;
  for (const HalfSpaceObstacle &plane : obstacles.planes) {
    all.push_back(draw_half_space(plane, mesh));
  }
  for (std::size_t k = 0; k < obstacles.surfaces.size(); ++k) {
    all.push_back({obstacles.surfaces[k], obstacles.motions[k]});
  }
  return all;
}

/// kappa of the surface in front of each local cell.
std::vector<double> stiffness_of_cells(const SceneOptions &options,
                                       const std::vector<int> &region_of_cell, std::size_t cells) {
  constexpr double share_of_young = 0.1;
  const auto of = [&](const MaterialOptions &material) {
    return options.contact.stiffness == "auto"
               ? share_of_young * material.parameters.constants.young
               : std::stod(options.contact.stiffness);
  };
  std::vector<double> of_region{of(options.material)}, result(cells, of_region.front());
  for (const RegionOptions &region : options.regions) of_region.push_back(of(region.material));
  for (std::size_t c = 0; c < region_of_cell.size(); ++c) {
    result[c] = of_region[static_cast<std::size_t>(region_of_cell[c])];
  }
  return result;
}

/// mu between two bodies: an obstacle has the last word. Null where there is none.
contact::FrictionOfBodies friction_of(double bodies, std::vector<double> obstacles, int first) {
  if (bodies == 0 &&
      std::all_of(obstacles.begin(), obstacles.end(), [](double mu) { return mu == 0; })) {
    return nullptr;
  }
  return [=](int a, int b) {
    const int last = std::max(a, b);
    return last < first ? bodies : obstacles[static_cast<std::size_t>(last - first)];
  };
}

/// Nothing may meet at rest, and nothing may be in contact.
PetscErrorCode check_rest(const Scene &scene, double diagonal, ContactTerm &term) {
  constexpr double least_share = 1e-6;
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
  const std::vector<double> rest(scene.mesh.coordinates.size(), 0);
  PetscInt64 count = 0;
  double gap = 0;
  std::string pair;
  PetscFunctionBeginUser;
  PetscCall(term.set_time(0));
  PetscCall(term.find_intersections(rest.data(), &count, &pair));
  PetscCheck(count == 0, comm, PETSC_ERR_USER_INPUT,
             "the rest shape intersects itself or an obstacle: %lld %s, the first: %s; contact "
             "needs a start where all are apart",
             static_cast<long long>(count), count == 1 ? "pair" : "pairs", pair.c_str());
  const double distance = term.parameters().distance;
  PetscCall(term.find_gap(rest.data(), distance, &gap, &pair));
  if (!(gap < distance)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(gap / 2 >= least_share * diagonal, comm, PETSC_ERR_USER_INPUT,
             "%s are %.3g apart at rest, too near for contact: move them apart by more than %.3g",
             pair.c_str(), gap, 2 * least_share * diagonal);
  term.set_distance(gap / 2);
  PetscCall(PetscPrintf(comm, "contact distance lowered to %.6g: %s are only %.6g apart at rest\n",
                        gap / 2, pair.c_str(), gap));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Writes each iterate as a state of a series, its number as time.
PetscErrorCode write_iterates(Scene *scene, ContactTerm &term) {
  const auto series = std::make_shared<Series>();
  PetscFunctionBeginUser;
  PetscCall(series->open(PetscObjectComm(reinterpret_cast<PetscObject>(scene->mesh.dm)),
                         scene->options.contact.iterates, output_of(scene->mesh)));
  term.observe_iterates([scene, series, count = 0](const double *u) mutable {
    PetscFunctionBeginUser;
    const Field displacement{"displacement", true, 3, values_of_owned(scene->mesh, u, 3)};
    PetscCall(series->append(count++, {displacement}));
    PetscFunctionReturn(PETSC_SUCCESS);
  });
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode add_contact(const std::vector<int> &region_of_cell, Scene *scene) {
  const ContactOptions &options = scene->options.contact;
  const Mesh &mesh = scene->mesh;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  Obstacles obstacles;
  auto surface = std::make_unique<ContactSurface>();
  PetscFunctionBeginUser;
  PetscCheck(mesh.shape->nodes == mesh.shape->corners, comm, PETSC_ERR_USER_INPUT,
             "contact needs linear elements, whose surface has straight edges, and these are %s: "
             "use -order 1, or a mesh of linear cells",
             mesh.element_name().c_str());
  PetscCheck(scene->options.assembly != "hook", comm, PETSC_ERR_USER_INPUT,
             "-assembly hook knows no matrix whose pattern changes, which contact needs; leave it "
             "out");
  PetscCall(read_obstacles(*scene, &obstacles));
  if (!scene->options.output_file.empty()) scene->obstacles = drawn(obstacles, mesh);
  PetscCall(surface->set_up(mesh, scene->discretization.global_dofs(),
                            stiffness_of_cells(scene->options, region_of_cell,
                                               static_cast<std::size_t>(mesh.local_cells())),
                            obstacles.surfaces));
  const double diagonal = contact::body_diagonal(surface->surface());
  const double distance = options.distance * diagonal;
  ContactParameters parameters{
      .distance = distance,
      .self_contact = options.self,
      .limits = {.share = options.ccd, .touching = 1e-12 * diagonal, .far = distance},
      .slip_velocity = options.slip_velocity * diagonal,
      .weight = options.weight == "rule" ? FilterWeight::rule : FilterWeight::clamp,
      .friction = friction_of(options.friction, obstacles.friction, surface->first_obstacle())};
  const std::vector<ObstacleSurface> at_start = moved_to(obstacles, 0);
  auto term =
      std::make_unique<ContactTerm>(std::move(surface), std::move(parameters),
                                    std::move(obstacles.planes), std::move(obstacles.motions));
  PetscCall(check_rest(*scene, diagonal, *term));
  PetscCall(check_outside(mesh, at_start));
  PetscCall(check_bodies_apart(mesh, term->contact_surface()));
  if (scene->options.time.integrator == "newmark") {
    scene->warnings.push_back(
        "newmark does not damp what contact excites, so momenta and forces of contact may be far "
        "off: take -time_integrator bdf2 or backward_euler");
  }
  if (!options.iterates.empty()) PetscCall(write_iterates(scene, *term));
  scene->contact = term.get();
  scene->functional->add_term(std::move(term));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
