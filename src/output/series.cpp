#include "output/series.hpp"

#include <algorithm>
#include <functional>

#include "output/hdf5_file.hpp"
#include "output/output_files.hpp"
#include "output/row_order.hpp"
#include "output/series_list.hpp"
#include "output/vtu.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"

namespace trefoil {
namespace {

bool fits(const OutputMesh &mesh) {
  const auto nodes = static_cast<std::size_t>(mesh.shape->nodes);
  return mesh.points.size() == 3 * mesh.point_numbers.size() &&
         mesh.cells.size() == nodes * mesh.cell_numbers.size();
}

bool fits(const Field &field, std::size_t points, std::size_t cells) {
  const std::size_t rows = field.on_vertices ? points : cells;
  return field.components > 0 &&
         field.values.size() == rows * static_cast<std::size_t>(field.components) &&
         !field.name.empty() && field.name.find('/') == std::string::npos;
}

/// An error on all ranks where something does not fit on one.
PetscErrorCode agree_that_it_fits(MPI_Comm comm, bool fits) {
  int all = fits;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, comm));
  PetscCheck(all, comm, PETSC_ERR_ARG_SIZ,
             "the arrays of an output must fit its vertices and cells on every rank");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Lets `name` be another name of `file`, or a copy where the disk knows no second names.
std::string give_second_name(const std::filesystem::path &file, const std::filesystem::path &name) {
  std::error_code error;
  std::filesystem::remove(name, error);
  if (!error) std::filesystem::create_hard_link(file, name, error);
  if (error) std::filesystem::copy_file(file, name, error);
  return error ? cannot_write(name, error.message()) : "";
}

}  // namespace

struct Series::State {
  State(MPI_Comm ranks, const std::filesystem::path &place)
      : comm(ranks), path(place), format(format_of_output(place)), list(place) {}

  MPI_Comm comm;
  int rank = 0;
  std::filesystem::path path;
  OutputFormat format;
  RowOrder points, cells;
  std::size_t local_points = 0, local_cells = 0;
  ArrangedMesh mesh;
  std::vector<XdmfState> states;
  SeriesList list;

  PetscErrorCode take_mesh(const OutputMesh &given);
  PetscErrorCode write(bool has_time, double t, const std::vector<Field> &fields);
  PetscErrorCode arrange(const std::vector<Field> &fields, std::vector<ArrangedField> *arranged);
  PetscErrorCode write_xdmf(const std::vector<ArrangedField> &fields);
  PetscErrorCode write_vtus(const std::vector<ArrangedField> &fields);
  PetscErrorCode publish_list();
  std::string cut() const;
};

PetscErrorCode Series::State::take_mesh(const OutputMesh &given) {
  PetscFunctionBeginUser;
  PetscCall(agree_that_it_fits(comm, fits(given)));
  PetscCall(points.set_up(comm, given.point_numbers));
  PetscCall(cells.set_up(comm, given.cell_numbers));
  local_points = given.point_numbers.size();
  local_cells = given.cell_numbers.size();
  mesh.shape = given.shape;
  mesh.obstacles = given.obstacles;
  mesh.total_points = points.total();
  mesh.total_cells = cells.total();
  mesh.first_point = points.first();
  mesh.first_cell = cells.first();
  std::vector<PetscInt> nodes(given.cells);
  PetscCall(points.find_places(&nodes));
  PetscCall(points.arrange(given.points, 3, &mesh.points));
  PetscCall(cells.arrange(nodes, given.shape->nodes, &mesh.cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::arrange(const std::vector<Field> &fields,
                                      std::vector<ArrangedField> *arranged) {
  PetscFunctionBeginUser;
  PetscCall(
      agree_that_it_fits(comm, std::all_of(fields.begin(), fields.end(), [&](const Field &field) {
                           return fits(field, local_points, local_cells);
                         })));
  for (const Field &field : fields) {
    ArrangedField share{{field.name, field.on_vertices, field.components}, {}};
    const RowOrder &order = field.on_vertices ? points : cells;
    PetscCall(order.arrange(field.values, field.components, &share.values));
    arranged->push_back(std::move(share));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::publish_list() {
  std::string problem;
  PetscFunctionBeginUser;
  if (rank == 0) {
    FileInParts whole(list.place());
    problem = whole.create();
    if (problem.empty()) problem = whole.write(list.text(mesh, states));
    if (problem.empty()) problem = whole.publish();
  }
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// On one rank: removes the states behind those that are known. @return one sentence where these
/// are not there, or nothing
std::string Series::State::cut() const {
  std::error_code error;
  std::vector<std::filesystem::path> needed;
  if (format == OutputFormat::xdmf) needed.push_back(list.data());
  for (std::size_t k = 0; k < states.size(); ++k) needed.push_back(list.of_state(k));
  for (const std::filesystem::path &file : needed) {
    if (std::filesystem::exists(file, error)) continue;
    return "cannot go on with the series '" + path.string() + "': '" + file.string() +
           "' is not there; restart where it was written, or name another -output_file";
  }
  for (std::size_t k = states.size(); std::filesystem::remove(list.of_state(k), error); ++k) {
  }
  return format == OutputFormat::xdmf ? ""
                                      : give_second_name(list.of_state(states.size() - 1), path);
}

PetscErrorCode Series::State::write_xdmf(const std::vector<ArrangedField> &fields) {
  const std::filesystem::path data = list.data();
  const bool is_series = states.back().has_time, is_first = states.size() == 1;
  const std::vector<ArrangedField> none;
  PetscFunctionBeginUser;
  if (is_first) {
    // An old description goes first: at no moment does one stand beside data that it does not fit.
    const std::vector<ArrangedField> &with = is_series ? none : fields;
    PetscCall(write_whole(
        comm, data, size_in_hdf5(mesh, true, with),
        [&](const std::string &part) { return write_hdf5(comm, part, &mesh, with); }, path));
  }
  const std::filesystem::path of_state = is_series ? list.of_state(states.size() - 1) : data;
  states.back().data_file = of_state.filename().string();
  if (is_series) {
    PetscCall(write_whole(
        comm, of_state, size_in_hdf5(mesh, false, fields),
        [&](const std::string &part) { return write_hdf5(comm, part, nullptr, fields); }));
  }
  PetscCall(publish_list());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::write_vtus(const std::vector<ArrangedField> &fields) {
  const bool is_series = states.back().has_time;
  const std::filesystem::path file = is_series ? list.of_state(states.size() - 1) : path;
  std::string problem;
  PetscFunctionBeginUser;
  PetscCall(write_whole(comm, file, size_in_vtu(mesh, fields), [&](const std::string &part) {
    return write_vtu(comm, part, mesh, fields);
  }));
  if (!is_series) PetscFunctionReturn(PETSC_SUCCESS);
  if (rank == 0) problem = give_second_name(file, path);
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscCall(publish_list());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::write(bool has_time, double t, const std::vector<Field> &fields) {
  std::vector<ArrangedField> arranged;
  PetscFunctionBeginUser;
  PetscCheck(states.empty() || (has_time && states.front().has_time), comm, PETSC_ERR_ORDER,
             "a single state has been written, or is to be written behind others");
  PetscCall(arrange(fields, &arranged));
  if (states.empty()) PetscCall(check_writable(comm, path.string()));
  states.push_back({has_time, t, "", {arranged.begin(), arranged.end()}});
  const PetscErrorCode outcome =
      format == OutputFormat::xdmf ? write_xdmf(arranged) : write_vtus(arranged);
  if (outcome) {
    states.pop_back();
    list.forget();
  }
  PetscCall(outcome);
  PetscFunctionReturn(PETSC_SUCCESS);
}

Series::Series() = default;
Series::~Series() = default;

PetscErrorCode Series::open(MPI_Comm comm, const std::string &path, const OutputMesh &mesh) {
  PetscFunctionBeginUser;
  state_ = std::make_unique<State>(comm, follow_links(path));
  PetscCallMPI(MPI_Comm_rank(comm, &state_->rank));
  PetscCall(check_writable(comm, path));
  PetscCall(state_->take_mesh(mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::append(double t, const std::vector<Field> &fields) {
  PetscFunctionBeginUser;
  PetscCall(state_->write(true, t, fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

nlohmann::ordered_json Series::save() const {
  auto written = nlohmann::ordered_json::array();
  if (!state_) return written;
  for (const XdmfState &state : state_->states) {
    auto fields = nlohmann::ordered_json::array();
    for (const FieldKind &field : state.fields) {
      fields.push_back({{"name", field.name},
                        {"on_vertices", field.on_vertices},
                        {"components", field.components}});
    }
    written.push_back({{"t", state.t}, {"file", state.data_file}, {"fields", fields}});
  }
  return written;
}

PetscErrorCode Series::go_on(const nlohmann::ordered_json &written) {
  State &state = *state_;
  std::string problem;
  PetscFunctionBeginUser;
  for (const auto &one : written) {
    XdmfState known{true, one.at("t"), one.at("file"), {}};
    for (const auto &field : one.at("fields")) {
      known.fields.push_back({field.at("name"), field.at("on_vertices"), field.at("components")});
    }
    state.states.push_back(std::move(known));
  }
  if (state.states.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  if (state.rank == 0) problem = state.cut();
  PetscCall(agree_on_complaint(state.comm, problem, PETSC_ERR_FILE_OPEN));
  PetscCall(state.publish_list());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::write_only(const std::vector<Field> &fields) {
  PetscFunctionBeginUser;
  PetscCall(state_->write(false, 0, fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode write_snapshot(MPI_Comm comm, const std::string &path, const OutputMesh &mesh,
                              const std::vector<Field> &fields) {
  Series series;
  PetscFunctionBeginUser;
  PetscCall(series.open(comm, path, mesh));
  PetscCall(series.write_only(fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
