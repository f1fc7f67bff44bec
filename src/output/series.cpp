#include "output/series.hpp"

#include <algorithm>
#include <cstdio>

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

std::string text_of_pvd(const std::filesystem::path &path, const std::vector<double> &times) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (std::size_t k = 0; k < times.size(); ++k) {
    char t[32];
    std::snprintf(t, sizeof t, "%.17g", times[k]);
    text += std::string("<DataSet timestep=\"") + t + "\" file=\"" +
            escaped_for_xml(numbered(path, k).filename().string()) + "\"/>\n";
  }
  return text + "</Collection>\n</VTKFile>\n";
}

}  // namespace

struct Series::State {
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
  PetscErrorCode append_to_hdf5(const std::filesystem::path &file,
                                const std::vector<ArrangedField> &fields);
  PetscErrorCode write_first_hdf5(const std::filesystem::path &file,
                                  const std::vector<ArrangedField> &fields);
  PetscErrorCode write_one_vtu(const std::filesystem::path &file,
                               const std::vector<ArrangedField> &fields);
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

PetscErrorCode Series::State::write_first_hdf5(const std::filesystem::path &file,
                                               const std::vector<ArrangedField> &fields) {
  FileInParts data(file);
  std::string problem;
  PetscFunctionBeginUser;
  // A disk that fills up in the middle of a collective write leaves ranks waiting for ever in
  // HDF5 (seen with 1.10.8 on a small disk): whether there is room is settled before.
  if (rank == 0) problem = data.create();
  if (rank == 0 && problem.empty()) {
    problem = check_room_on_disk(data.part(), size_in_hdf5(mesh, true, fields));
  }
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscCall(data.share(comm));
  const PetscErrorCode outcome =
      write_hdf5(comm, data.part().string(), &mesh, states.back().prefix, fields);
  PetscCall(agree_on_writing(comm, file.string(), outcome));
  if (rank == 0) {
    // The old description goes first: at no moment does one stand beside data that it does not fit.
    std::error_code error;
    std::filesystem::remove(path, error);
    problem = error ? cannot_write(path, error.message()) : data.publish();
  }
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::append_to_hdf5(const std::filesystem::path &file,
                                             const std::vector<ArrangedField> &fields) {
  std::string problem;
  PetscFunctionBeginUser;
  if (rank == 0) problem = check_room_on_disk(file, size_in_hdf5(mesh, false, fields));
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  const PetscErrorCode outcome =
      write_hdf5(comm, file.string(), nullptr, states.back().prefix, fields);
  PetscCall(agree_on_writing(comm, file.string(), outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::write_xdmf(const std::vector<ArrangedField> &fields) {
  const std::filesystem::path data =
      follow_links(std::filesystem::path(path).replace_extension(".h5").string());
  PetscFunctionBeginUser;
  if (states.size() == 1) {
    PetscCall(write_first_hdf5(data, fields));
  } else {
    PetscCall(append_to_hdf5(data, fields));
  }
  PetscCall(publish_text(path, describe_in_xdmf(data.filename().string(), mesh, states)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::write_one_vtu(const std::filesystem::path &file,
                                            const std::vector<ArrangedField> &fields) {
  FileInParts grid(file);
  std::string problem;
  PetscFunctionBeginUser;
  if (rank == 0) problem = grid.create();
  if (rank == 0 && problem.empty()) {
    problem = check_room_on_disk(grid.part(), size_in_vtu(mesh, fields));
  }
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscCall(grid.share(comm));
  PetscCall(
      agree_on_writing(comm, file.string(), write_vtu(comm, grid.part().string(), mesh, fields)));
  if (rank == 0) problem = grid.publish();
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Series::State::write(bool has_time, double t, const std::vector<Field> &fields) {
  std::vector<ArrangedField> arranged;
  std::string problem;
  PetscFunctionBeginUser;
  PetscCheck(states.empty() || (has_time && states.front().has_time), comm, PETSC_ERR_ORDER,
             "a single state has been written, or is to be written behind others");
  PetscCall(arrange(fields, &arranged));
  if (states.empty()) PetscCall(check_writable(comm, path.string()));
  states.push_back({has_time,
                    t,
                    has_time ? "/step" + std::to_string(states.size()) : "",
                    {arranged.begin(), arranged.end()}});
  if (format == OutputFormat::xdmf) {
    PetscCall(write_xdmf(arranged));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const std::filesystem::path file = has_time ? numbered(path, states.size() - 1) : path;
  PetscCall(write_one_vtu(file, arranged));
  if (!has_time) PetscFunctionReturn(PETSC_SUCCESS);
  if (rank == 0) problem = give_second_name(file, path);
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  std::vector<double> times;
  for (const XdmfState &state : states) times.push_back(state.t);
  PetscCall(publish_text(std::filesystem::path(path).replace_extension(".pvd"),
                         text_of_pvd(path, times)));
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
