#include "output/vtu.hpp"

#include <cstdint>
#include <cstdio>
#include <cstring>

#include "output/xdmf.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// An array of the file: what the head says of it, and this rank's share.
struct Block {
  std::string head;        ///< attributes of its DataArray but the offset
  PetscInt64 bytes = 0;    ///< of all ranks
  PetscInt64 at = 0;       ///< where this rank's share begins
  std::vector<char> mine;  ///< its bytes
};

/// @param rows of all ranks, `first` of them before this rank's
template <class T>
Block make_block(const char *type, const std::string &attributes, PetscInt rows, PetscInt first,
                 int width, const std::vector<T> &values) {
  Block block;
  block.head = std::string("type=\"") + type + "\" " + attributes;
  const auto row = static_cast<PetscInt64>(sizeof(T)) * width;
  block.bytes = row * rows;
  block.at = row * first;
  block.mine.resize(sizeof(T) * values.size());
  if (!values.empty()) std::memcpy(block.mine.data(), values.data(), block.mine.size());
  return block;
}

std::string named(const std::string &name, int components) {
  const std::string attribute = "Name=\"" + escaped_for_xml(name) + "\"";
  if (components == 1) return attribute;
  return attribute + " NumberOfComponents=\"" + std::to_string(components) + "\"";
}

Block points_block(const ArrangedMesh &mesh) {
  return make_block("Float64", named("Points", 3), mesh.total_points, mesh.first_point, 3,
                    mesh.points);
}

std::vector<Block> cell_blocks(const ArrangedMesh &mesh) {
  const int nodes = mesh.shape->nodes;
  const std::size_t share = mesh.cells.size() / static_cast<std::size_t>(nodes);
  std::vector<std::int64_t> ends(share);
  for (std::size_t cell = 0; cell < share; ++cell)
    ends[cell] = nodes * (mesh.first_cell + static_cast<std::int64_t>(cell) + 1);
  const std::vector<std::uint8_t> types(share, static_cast<std::uint8_t>(mesh.shape->vtk));
  const char *integer = sizeof(PetscInt) == 8 ? "Int64" : "Int32";
  const auto block = [&](const char *type, const char *name, int width, const auto &values) {
    return make_block(type, std::string("Name=\"") + name + "\"", mesh.total_cells, mesh.first_cell,
                      width, values);
  };
  return {block(integer, "connectivity", nodes, mesh.cells), block("Int64", "offsets", 1, ends),
          block("UInt8", "types", 1, types)};
}

/// VTK has a symmetric tensor as xx yy zz xy yz xz.
std::vector<double> in_order_of_vtk(const ArrangedField &field) {
  constexpr std::size_t place[] = {0, 3, 5, 1, 4, 2};
  if (field.components != 6) return field.values;
  std::vector<double> values(field.values.size());
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = field.values[k - k % 6 + place[k % 6]];
  return values;
}

Block field_block(const ArrangedMesh &mesh, const ArrangedField &field) {
  const bool on_vertices = field.on_vertices;
  return make_block("Float64", named(field.name, field.components),
                    on_vertices ? mesh.total_points : mesh.total_cells,
                    on_vertices ? mesh.first_point : mesh.first_cell, field.components,
                    in_order_of_vtk(field));
}

constexpr PetscInt64 bytes_of_size = 8;  // before each array stands its size

/// The sections of the file in their order, each with its arrays.
struct Section {
  const char *name;
  std::vector<Block> blocks;
};

std::vector<Section> sections_of(const ArrangedMesh &mesh,
                                 const std::vector<ArrangedField> &fields) {
  std::vector<Section> sections{{"Points", {}}, {"Cells", {}}, {"PointData", {}}, {"CellData", {}}};
  sections[0].blocks.push_back(points_block(mesh));
  sections[1].blocks = cell_blocks(mesh);
  for (const ArrangedField &field : fields)
    sections[field.on_vertices ? 2 : 3].blocks.push_back(field_block(mesh, field));
  return sections;
}

std::string head_of(const ArrangedMesh &mesh, const std::vector<Section> &sections) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece "
      "NumberOfPoints=\"" +
      std::to_string(mesh.total_points) + "\" NumberOfCells=\"" + std::to_string(mesh.total_cells) +
      "\">\n";
  PetscInt64 offset = 0;
  for (const Section &section : sections) {
    text += std::string("<") + section.name + ">\n";
    for (const Block &block : section.blocks) {
      text += "<DataArray " + block.head + " format=\"appended\" offset=\"" +
              std::to_string(offset) + "\"/>\n";
      offset += bytes_of_size + block.bytes;
    }
    text += std::string("</") + section.name + ">\n";
  }
  return text + "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
}

constexpr const char *tail = "\n</AppendedData>\n</VTKFile>\n";

/// Errors of MPI's files are returned.
int write_all(MPI_File file, PetscInt64 at, const void *bytes, std::size_t count) {
  // Pieces, since a count is an int.
  constexpr std::size_t piece = std::size_t{1} << 30;
  const auto *begin = static_cast<const char *>(bytes);
  int error = MPI_SUCCESS;
  for (std::size_t done = 0; done < count && error == MPI_SUCCESS; done += piece) {
    const auto length = static_cast<int>(std::min(piece, count - done));
    error = MPI_File_write_at(file, static_cast<MPI_Offset>(at) + static_cast<MPI_Offset>(done),
                              begin + done, length, MPI_BYTE, MPI_STATUS_IGNORE);
  }
  return error;
}

int write_sections(MPI_File file, int rank, const std::string &head,
                   const std::vector<Section> &sections) {
  int error = rank == 0 ? write_all(file, 0, head.data(), head.size()) : MPI_SUCCESS;
  auto at = static_cast<PetscInt64>(head.size());
  for (const Section &section : sections) {
    for (const Block &block : section.blocks) {
      const auto size = static_cast<std::uint64_t>(block.bytes);
      if (rank == 0 && !error) error = write_all(file, at, &size, sizeof size);
      at += bytes_of_size;
      if (!error) error = write_all(file, at + block.at, block.mine.data(), block.mine.size());
      at += block.bytes;
    }
  }
  if (rank == 0 && !error) error = write_all(file, at, tail, std::strlen(tail));
  return error;
}

}  // namespace

PetscErrorCode write_vtu(MPI_Comm comm, const std::string &file, const ArrangedMesh &mesh,
                         const std::vector<ArrangedField> &fields) {
  MPI_File handle = MPI_FILE_NULL;
  int rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  const std::vector<Section> sections = sections_of(mesh, fields);
  int error = MPI_File_open(comm, file.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &handle);
  if (error) PetscFunctionReturn(PETSC_ERR_FILE_OPEN);
  error = write_sections(handle, rank, head_of(mesh, sections), sections);
  const int closing = MPI_File_close(&handle);
  PetscFunctionReturn(error || closing ? PETSC_ERR_FILE_WRITE : PETSC_SUCCESS);
}

PetscInt64 size_in_vtu(const ArrangedMesh &mesh, const std::vector<ArrangedField> &fields) {
  const std::vector<Section> sections = sections_of(mesh, fields);
  auto bytes = static_cast<PetscInt64>(head_of(mesh, sections).size() + std::strlen(tail));
  for (const Section &section : sections)
    for (const Block &block : section.blocks) bytes += bytes_of_size + block.bytes;
  return bytes;
}

std::string describe_in_pvd(const std::vector<VtuOfSeries> &files) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (const auto &[t, file] : files) {
    char number[32];
    std::snprintf(number, sizeof number, "%.17g", t);
    text += std::string("<DataSet timestep=\"") + number + "\" file=\"" + escaped_for_xml(file) +
            "\"/>\n";
  }
  return text + "</Collection>\n</VTKFile>\n";
}

}  // namespace trefoil
