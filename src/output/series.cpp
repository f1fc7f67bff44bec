#include "output/series.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>

#include "output/hdf5_file.hpp"
#include "output/output_files.hpp"
#include "output/row_order.hpp"
#include "output/vtu.hpp"
#include "output/xdmf.hpp"
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

/// A PETSc error of one rank as a sentence for all. Collective.
PetscErrorCode agree_on_writing(MPI_Comm comm, const std::string &file, PetscErrorCode outcome) {
  int error = static_cast<int>(outcome);
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &error, 1, MPI_INT, MPI_MAX, comm));
  const std::string why = "writing it failed, PETSc's error " + std::to_string(error);
  PetscCall(agree_on_complaint(comm, error ? cannot_write(file, why) : "", PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// "bar_0012.vtu"
std::filesystem::path numbered(const std::filesystem::path &path, std::size_t number) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "_%04zu", number);
  return path.parent_path() / (path.stem().string() + digits + path.extension().string());
}

/// Lets `name` be another name of `file`, or a copy where the disk knows no second names.
std::string give_second_name(const std::filesystem::path &file, const std::filesystem::path &name) {
  std::error_code error;
  std::filesystem::remove(name, error);
  if (!error) std::filesystem::create_hard_link(file, name, error);
  if (error) std::filesystem::copy_file(file, name, error);
  return error ? cannot_write(name, error.message()) : "";
}

std::string text_of_pvd(const std::filesystem::path &path, const std::vector<XdmfState> &states) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (std::size_t k = 0; k < states.size(); ++k) {
    char t[32];
    std::snprintf(t, sizeof t, "%.17g", states[k].t);
    text += std::string("<DataSet timestep=\"") + t + "\" file=\"" +
            escaped_for_xml(numbered(path, k).filename().string()) + "\"/>\n";
  }
  return text + "</Collection>\n</VTKFile>\n";
}

}  // namespace

struct Series::State {
  using Write = std::function<PetscErrorCode(const std::string &file)>;  ///< collective

  MPI_Comm comm = MPI_COMM_NULL;
  int rank = 0;
  std::filesystem::path path;
  OutputFormat format = OutputFormat::unknown;
  RowOrder points, cells;
  std::size_t local_points = 0, local_cells = 0;
  ArrangedMesh mesh;
  std::vector<XdmfState> states;

  PetscErrorCode take_mesh(const OutputMesh &given);
  PetscErrorCode write(bool has_time, double t, const std::vector<Field> &fields);
  PetscErrorCode arrange(const std::vector<Field> &fields, std::vector<ArrangedField> *arranged);
  PetscErrorCode write_xdmf(const std::vector<ArrangedField> &fields);
  PetscErrorCode write_vtus(const std::vector<ArrangedField> &fields);
  /// Writes a file beside its place, where the disk has room for it, and gives it its name.
  /// @param stale a description of the file that was there, or empty: removed just before
  PetscErrorCode write_heavy(const std::filesystem::path &file, const Write &write,
                             PetscInt64 bytes, const std::filesystem::path &stale = {});
  PetscErrorCode publish_text(const std::filesystem::path &file, const std::string &text);
};

PetscErrorCode Series::State::take_mesh(const OutputMesh &given) {
  PetscFunctionBeginUser;
  PetscCall(agree_that_it_fits(comm, fits(given)));
  PetscCall(points.set_up(comm, given.point_numbers));
  PetscCall(cells.set_up(comm, given.cell_numbers));
  local_points = given.point_numbers.size();
  local_cells = given.cell_numbers.size();
  mesh.shape = given.shape;
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

PetscErrorCode Series::State::publish_text(const std::filesystem::path &file,
                                           const std::string &text) {
  std::string problem;
  PetscFunctionBeginUser;
  if (rank == 0) {
    FileInParts whole(file);
    problem = whole.create();
    if (problem.empty()) problem = whole.write(text);
    if (problem.empty()) problem = whole.publish();
  }
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::write_heavy(const std::filesystem::path &file, const Write &write,
                                          PetscInt64 bytes, const std::filesystem::path &stale) {
  FileInParts whole(file);
  std::string problem;
  PetscFunctionBeginUser;
  // A disk that fills up in the middle of a collective write leaves ranks waiting for ever in
  // HDF5 (seen with 1.10.8 on a small disk): whether there is room is settled before.
  if (rank == 0) problem = whole.create();
  if (rank == 0 && problem.empty()) problem = check_room_on_disk(whole.part(), bytes);
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscCall(whole.share(comm));
  PetscCall(agree_on_writing(comm, file.string(), write(whole.part().string())));
  if (rank == 0) {
    std::error_code error;
    if (!stale.empty()) std::filesystem::remove(stale, error);
    problem = error ? cannot_write(stale, error.message()) : whole.publish();
  }
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::write_xdmf(const std::vector<ArrangedField> &fields) {
  const std::filesystem::path data = std::filesystem::path(path).replace_extension(".h5");
  const bool is_series = states.back().has_time, is_first = states.size() == 1;
  const std::vector<ArrangedField> none;
  PetscFunctionBeginUser;
  if (is_first) {
    // An old description goes first: at no moment does one stand beside data that it does not fit.
    const std::vector<ArrangedField> &with = is_series ? none : fields;
    PetscCall(write_heavy(
        data, [&](const std::string &part) { return write_hdf5(comm, part, &mesh, with); },
        size_in_hdf5(mesh, true, with), path));
  }
  const std::filesystem::path of_state = is_series ? numbered(data, states.size() - 1) : data;
  states.back().data_file = of_state.filename().string();
  if (is_series) {
    PetscCall(write_heavy(
        of_state, [&](const std::string &part) { return write_hdf5(comm, part, nullptr, fields); },
        size_in_hdf5(mesh, false, fields)));
  }
  PetscCall(publish_text(path, describe_in_xdmf(data.filename().string(), mesh, states)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::write_vtus(const std::vector<ArrangedField> &fields) {
  const bool is_series = states.back().has_time;
  const std::filesystem::path file = is_series ? numbered(path, states.size() - 1) : path;
  std::string problem;
  PetscFunctionBeginUser;
  PetscCall(write_heavy(
      file, [&](const std::string &part) { return write_vtu(comm, part, mesh, fields); },
      size_in_vtu(mesh, fields)));
  if (!is_series) PetscFunctionReturn(PETSC_SUCCESS);
  if (rank == 0) problem = give_second_name(file, path);
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscCall(publish_text(std::filesystem::path(path).replace_extension(".pvd"),
                         text_of_pvd(path, states)));
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
  if (outcome) states.pop_back();
  PetscCall(outcome);
  PetscFunctionReturn(PETSC_SUCCESS);
}

Series::Series() = default;
Series::~Series() = default;

PetscErrorCode Series::open(MPI_Comm comm, const std::string &path, const OutputMesh &mesh) {
  PetscFunctionBeginUser;
  state_ = std::make_unique<State>();
  state_->comm = comm;
  PetscCallMPI(MPI_Comm_rank(comm, &state_->rank));
  state_->path = follow_links(path);
  state_->format = format_of_output(path);
  PetscCall(check_writable(comm, path));
  PetscCall(state_->take_mesh(mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::append(double t, const std::vector<Field> &fields) {
  PetscFunctionBeginUser;
  PetscCall(state_->write(true, t, fields));
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
