#include "scene/fields.hpp"

#include <algorithm>

#include "output/mesh_output.hpp"
#include "output/output_files.hpp"
#include "scene/cell_tensors.hpp"
#include "scene/state_report.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"

namespace trefoil {
namespace {

/// Fields of strain and stress, each a function of a cell's or a vertex's mean tensors.
struct TensorField {
  const char *name;
  int components;
  void (*value)(const MeanTensors &tensors, double *values);
};

void put_symmetric(const Matrix3<double> &A, double *values) {
  int k = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) values[k++] = (A(i, j) + A(j, i)) / 2;
  }
}

constexpr TensorField tensor_fields[] = {
    {"von_mises", 1,
     [](const MeanTensors &mean, double *values) { *values = von_mises(mean.cauchy); }},
    {"cauchy_stress", 6,
     [](const MeanTensors &mean, double *values) { put_symmetric(mean.cauchy, values); }},
    {"principal_stresses", 3,
     [](const MeanTensors &mean, double *values) {
       const auto principal = principal_values(mean.cauchy);
       std::copy(principal.begin(), principal.end(), values);
     }},
    {"first_piola", 9,
     [](const MeanTensors &mean, double *values) {
       std::copy(mean.first_piola.entries.begin(), mean.first_piola.entries.end(), values);
     }},
    {"green_lagrange", 6,
     [](const MeanTensors &mean, double *values) { put_symmetric(mean.green_lagrange, values); }},
    {"principal_stretches", 3,
     [](const MeanTensors &mean, double *values) {
       const auto principal = principal_stretches(mean.F);
       std::copy(principal.begin(), principal.end(), values);
     }},
};

const char *const plain_fields[] = {
    "displacement",         "determinant_F", "energy_density", "reaction",
    "negative_eigenvalues", "region",        "part",           "rank"};

bool has(const std::vector<std::string> &names, const std::string &name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

template <class Number>
std::vector<double> as_doubles(const std::vector<Number> &values) {
  return {values.begin(), values.end()};
}

/// Strains and stresses, by cell and by vertex.
PetscErrorCode add_tensor_fields(const Scene &scene, const std::vector<std::string> &names,
                                 const double *u, std::vector<Field> *fields) {
  std::vector<MeanTensors> of_cells, of_vertices;
  PetscFunctionBeginUser;
  const bool any = std::any_of(std::begin(tensor_fields), std::end(tensor_fields),
                               [&](const TensorField &field) { return has(names, field.name); });
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(compute_mean_tensors(scene.mesh, *scene.cells, u, &of_cells, &of_vertices));
  for (const TensorField &field : tensor_fields) {
    if (!has(names, field.name)) continue;
    for (const bool on_vertices : {false, true}) {
      const std::vector<MeanTensors> &means = on_vertices ? of_vertices : of_cells;
      const auto width = static_cast<std::size_t>(field.components);
      std::vector<double> values(width * means.size());
      for (std::size_t k = 0; k < means.size(); ++k) field.value(means[k], &values[width * k]);
      fields->push_back({field.name, on_vertices, field.components, std::move(values)});
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What only scenes in time have: the scheme's own velocities and accelerations.
struct MotionField {
  const char *name;
  std::vector<double> Motion::*values;
};

constexpr MotionField motion_fields[] = {{"velocity", &Motion::v}, {"acceleration", &Motion::a}};

void add_motion_fields(const Mesh &mesh, const Motion &state, const std::vector<std::string> &names,
                       std::vector<Field> *fields) {
  for (const auto &[name, values] : motion_fields) {
    if (!has(names, name)) continue;
    fields->push_back({name, true, 3, values_of_owned(mesh, (state.*values).data(), 3)});
  }
}

/// Refuses fields of motion in a scene without time.
PetscErrorCode check_motion_fields(MPI_Comm comm, const SceneOptions &options) {
  PetscFunctionBeginUser;
  for (const MotionField &field : motion_fields) {
    PetscCheck(options.time.is_on || !has(options.output_fields, field.name), comm,
               PETSC_ERR_USER_INPUT,
               "-output_fields names the %s, which only a scene in time has: give -time_end and "
               "-time_step, or leave it out",
               field.name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The connected part of each local cell, by number.
PetscErrorCode add_parts(const Mesh &mesh, std::vector<Field> *fields) {
  std::vector<PetscInt> part_of_vertex;
  std::vector<double> part;
  PetscInt parts = 0;
  PetscFunctionBeginUser;
  PetscCall(connected_components(mesh, &part_of_vertex, &parts));
  const auto nodes = static_cast<std::size_t>(mesh.nodes_per_cell());
  for (std::size_t k = 0; k < mesh.cells.size(); k += nodes) {
    part.push_back(static_cast<double>(part_of_vertex[static_cast<std::size_t>(mesh.cells[k])]));
  }
  fields->push_back({"part", false, 1, std::move(part)});
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

std::vector<std::string> names_of_fields() {
  std::vector<std::string> names(std::begin(plain_fields), std::end(plain_fields));
  for (const TensorField &field : tensor_fields) names.emplace_back(field.name);
  for (const MotionField &field : motion_fields) names.emplace_back(field.name);
  return names;
}

std::vector<std::string> default_fields(const SceneOptions &options) {
  std::vector<std::string> names{"displacement",         "von_mises",
                                 "determinant_F",        "energy_density",
                                 "negative_eigenvalues", "rank"};
  if (!options.regions.empty()) names.emplace_back("region");
  if (options.time.is_on) names.emplace_back("velocity");
  return names;
}

PetscErrorCode check_outputs(MPI_Comm comm, const SceneOptions &options) {
  const std::string &path = options.output_file;
  PetscFunctionBeginUser;
  PetscCall(check_motion_fields(comm, options));
  if (!path.empty()) {
    PetscCall(check_writable(comm, path));
    for (const ObstacleOptions &obstacle : options.contact.obstacles) {
      PetscCall(check_writable(comm, output_of_obstacle(path, obstacle.name)));
    }
  }
  if (!options.contact.iterates.empty()) {
    PetscCall(check_writable(comm, options.contact.iterates));
  }
  for (const std::string &file : {options.csv_file, options.record_file}) {
    if (!file.empty()) PetscCall(check_text_file(comm, file));
  }
  if (!options.checkpoint.file.empty()) PetscCall(check_place(comm, options.checkpoint.file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FieldOutput::make_fields(std::vector<Field> *fields) const {
  const Mesh &mesh = scene_.mesh;
  const std::vector<std::string> names = scene_.options.output_fields.empty()
                                             ? default_fields(scene_.options)
                                             : scene_.options.output_fields;
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  EnergyFunctional::CellReport report;
  PetscMPIInt rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm)), &rank));
  PetscCall(scene_.discretization.get_local(scene_.displacement, &local, &u));
  if (has(names, "displacement")) {
    fields->push_back({"displacement", true, 3, values_of_owned(mesh, u, 3)});
  }
  PetscCall(add_tensor_fields(scene_, names, u, fields));
  PetscCall(scene_.discretization.restore_local(&local, &u));
  if (scene_.motion) add_motion_fields(mesh, scene_.motion->state(), names, fields);
  const bool counts = has(names, "negative_eigenvalues");
  if (counts || has(names, "determinant_F") || has(names, "energy_density")) {
    PetscCall(scene_.functional->describe_cells(scene_.displacement, &report, counts));
  }
  const auto add = [&](const char *name, const std::vector<double> &values) {
    if (has(names, name)) fields->push_back({name, false, 1, values});
  };
  add("determinant_F", report.determinant);
  add("energy_density", report.energy_density);
  add("negative_eigenvalues", report.negative_eigenvalues);
  add("region", as_doubles(scene_.cells->region_of_cell()));
  add("rank", std::vector<double>(static_cast<std::size_t>(mesh.local_cells()), rank));
  if (has(names, "part")) PetscCall(add_parts(mesh, fields));
  if (has(names, "reaction")) {
    std::vector<double> reactions;
    PetscCall(reactions_of_vertices(scene_, &reactions));
    fields->push_back({"reaction", true, 3, values_of_owned(mesh, reactions.data(), 3)});
  }
  PetscCall(add_original_vertices(mesh, fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FieldOutput::open() {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm));
  const std::string &file = scene_.options.output_file;
  PetscFunctionBeginUser;
  if (is_open_) PetscFunctionReturn(PETSC_SUCCESS);
  OutputMesh mesh = output_of(scene_.mesh);
  for (const DrawnObstacle &obstacle : scene_.obstacles) {
    mesh.obstacles.push_back(obstacle.surface.name);
  }
  PetscCall(series_.open(comm, file, mesh));
  PetscCall(obstacles_.open(comm, scene_.obstacles, file, is_series_));
  is_open_ = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode FieldOutput::write(double t) {
  std::vector<Field> fields;
  PetscFunctionBeginUser;
  if (scene_.options.output_file.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(open());
  PetscCall(make_fields(&fields));
  PetscCall(obstacles_.write(t));
  PetscCall(is_series_ ? series_.append(t, fields) : series_.write_only(fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

nlohmann::ordered_json FieldOutput::save() const {
  return {{"file", scene_.options.output_file},
          {"written", series_.save()},
          {"obstacles", obstacles_.save()}};
}

PetscErrorCode FieldOutput::go_on(const nlohmann::ordered_json &saved) {
  const std::string &file = scene_.options.output_file;
  PetscFunctionBeginUser;
  if (!is_series_ || file.empty() || saved.at("file") != file) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(open());
  PetscCall(series_.go_on(saved.at("written")));
  PetscCall(obstacles_.go_on(saved.value("obstacles", nlohmann::ordered_json::object())));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
