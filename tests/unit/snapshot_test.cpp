// Writes states of a mesh on all ranks of PETSC_COMM_WORLD; rank 0 reads them back. Runs on any
// number of ranks; needs petsc_main.cpp.

#include "output/snapshot.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "output/series.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

namespace fs = std::filesystem;

/// Which rank holds the `index`-th of `count` vertices or cells.
using Split = std::function<int(int index, int count, int ranks)>;

int evenly(int index, int count, int ranks) {
  return index * ranks / count;
}
int last_rank_empty(int index, int count, int ranks) {
  return evenly(index, count, std::max(1, ranks - 1));
}
int all_on_last_rank(int, int, int ranks) {
  return ranks - 1;
}
int in_turns(int index, int, int ranks) {
  return index % ranks;
}

/// A row of unit cubes, each cut into six tetrahedra around its diagonal; or, with dim 2, of unit
/// squares cut into two triangles.
struct Bar {
  int dim, cubes;

  [[nodiscard]] int layer() const { return 1 << (dim - 1); }  // vertices at one x
  [[nodiscard]] int vertices() const { return layer() * (cubes + 1); }
  [[nodiscard]] int cells_a_cube() const { return dim == 3 ? 6 : 2; }
  [[nodiscard]] int cells() const { return cells_a_cube() * cubes; }
  [[nodiscard]] int corners() const { return dim + 1; }
  [[nodiscard]] double coordinate(int vertex, int axis) const {
    return axis == 0 ? vertex / layer() : (vertex % layer()) >> (axis - 1) & 1;
  }
  /// Walks along the edges of the cube from its first to its last vertex, one axis after another.
  [[nodiscard]] PetscInt corner(int cell, int corner) const {
    static constexpr int orders[6][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1},
                                         {2, 0, 1}, {1, 2, 0}, {2, 1, 0}};
    const int strides[3] = {layer(), 1, 2};
    int vertex = cell / cells_a_cube() * layer();
    for (int step = 0; step < corner; ++step)
      vertex += strides[orders[cell % cells_a_cube()][step]];
    return vertex;
  }
};

double vector_value(int vertex, int component) {
  return 0.1 * vertex - 7.25 * component;
}
double vertex_value(int vertex, int = 0) {
  return std::sqrt(vertex);
}
double cell_value(int cell, int = 0) {
  return 1e6 / (1 + cell);
}
double tensor_value(int cell, int component) {
  return cell + 0.25 * component;
}

/// What a file holds under one name.
struct Dataset {
  std::vector<hsize_t> shape;
  std::vector<double> values;
};

Dataset read_dataset(const fs::path &file, const std::string &name) {
  Dataset result;
  const hid_t handle = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (handle < 0) return result;
  const hid_t dataset = H5Dopen2(handle, name.c_str(), H5P_DEFAULT);
  if (dataset >= 0) {
    const hid_t space = H5Dget_space(dataset);
    result.shape.resize(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, result.shape.data(), nullptr);
    result.values.resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.values.data());
    H5Sclose(space);
    H5Dclose(dataset);
  }
  H5Fclose(handle);
  return result;
}

/// @return whether every tag is closed in its turn: taking out the innermost pairs leaves none
bool is_well_formed(std::string xml) {
  static const std::regex pair(R"(<(\w+)(\s+\w+="[^"<]*")*>[^<>]*</\1>)");
  xml.erase(0, xml.find("?>"));
  xml = std::regex_replace(xml, std::regex(R"(<\w+(\s+\w+="[^"<]*")*/>)"), "");
  std::string before;
  do {
    before = xml;
    xml = std::regex_replace(before, pair, "");
  } while (xml != before);
  return xml.find('<') == std::string::npos;
}

class SnapshotTest : public testing::Test {
 protected:
  void SetUp() override {
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank_);
    MPI_Comm_size(PETSC_COMM_WORLD, &ranks_);
    std::string name = testing::TempDir() + "/trefoil_snapshot_XXXXXX";
    if (rank_ == 0 && mkdtemp(name.data()) == nullptr) ADD_FAILURE() << "cannot make " << name;
    MPI_Bcast(name.data(), static_cast<int>(name.size()), MPI_CHAR, 0, PETSC_COMM_WORLD);
    directory_ = name;
    EXPECT_EQ(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr), PETSC_SUCCESS);
  }

  void TearDown() override {
    EXPECT_EQ(PetscPopErrorHandler(), PETSC_SUCCESS);
    MPI_Barrier(PETSC_COMM_WORLD);
    if (rank_ == 0) fs::remove_all(directory_);
  }

  /// What this rank has of a bar. Numbers leave gaps where `stride` is not 1.
  OutputMesh part_of(const Bar &bar, const Split &split, int stride = 1) const {
    OutputMesh part;
    part.shape = bar.dim == 3 ? &shapes::tet4 : &shapes::tri3;
    for (int vertex = bar.vertices() - 1; vertex >= 0; --vertex) {
      if (split(vertex, bar.vertices(), ranks_) != rank_) continue;
      part.point_numbers.push_back(stride * vertex + stride / 2);
      for (int axis = 0; axis < 3; ++axis)
        part.points.push_back(axis < bar.dim ? bar.coordinate(vertex, axis) : 0);
    }
    for (int cell = bar.cells() - 1; cell >= 0; --cell) {
      if (split(cell, bar.cells(), ranks_) != rank_) continue;
      part.cell_numbers.push_back(stride * cell + stride / 2);
      for (int corner = 0; corner < bar.corners(); ++corner)
        part.cells.push_back(stride * bar.corner(cell, corner) + stride / 2);
    }
    return part;
  }

  /// Its fields, times a factor.
  static std::vector<Field> fields_of(const OutputMesh &part, int stride = 1, double factor = 1) {
    Field displacement{"displacement", true, 3, {}}, temperature{"root <n>", true, 1, {}};
    Field energy{"energy_density", false, 1, {}}, stress{"stress", false, 6, {}};
    for (const PetscInt number : part.point_numbers) {
      const int vertex = static_cast<int>(number) / stride;
      for (int axis = 0; axis < 3; ++axis)
        displacement.values.push_back(factor * vector_value(vertex, axis));
      temperature.values.push_back(factor * vertex_value(vertex));
    }
    for (const PetscInt number : part.cell_numbers) {
      const int cell = static_cast<int>(number) / stride;
      energy.values.push_back(factor * cell_value(cell));
      for (int k = 0; k < 6; ++k) stress.values.push_back(factor * tensor_value(cell, k));
    }
    return {displacement, temperature, energy, stress};
  }

  PetscErrorCode write(const fs::path &path, const OutputMesh &part) const {
    return write_snapshot(PETSC_COMM_WORLD, path, part, fields_of(part));
  }

  void expect_dataset(const std::string &name, int rows, int columns,
                      const std::function<double(int, int)> &expected,
                      const std::string &file = "bar.h5") const {
    const Dataset dataset = read_dataset(directory_ / file, name);
    std::vector<hsize_t> shape{static_cast<hsize_t>(rows)};
    if (columns > 1) shape.push_back(static_cast<hsize_t>(columns));
    ASSERT_EQ(dataset.shape, shape) << name;
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        ASSERT_EQ(dataset.values[static_cast<std::size_t>(row * columns + column)],
                  expected(row, column))
            << name << ' ' << row << ' ' << column;
  }

  void expect_whole(const Bar &bar, const std::string &data = "bar.h5", double factor = 1) const {
    expect_dataset("/points", bar.vertices(), 3, [&](int vertex, int axis) {
      return axis < bar.dim ? bar.coordinate(vertex, axis) : 0.0;
    });
    expect_dataset("/cells", bar.cells(), bar.corners(), [&](int cell, int corner) {
      return static_cast<double>(bar.corner(cell, corner));
    });
    const auto times_factor = [factor](double (*value)(int, int)) {
      return [=](int row, int column) { return factor * value(row, column); };
    };
    expect_dataset("/vertex_fields/displacement", bar.vertices(), 3, times_factor(vector_value),
                   data);
    expect_dataset("/vertex_fields/root <n>", bar.vertices(), 1, times_factor(vertex_value), data);
    expect_dataset("/cell_fields/energy_density", bar.cells(), 1, times_factor(cell_value), data);
    expect_dataset("/cell_fields/stress", bar.cells(), 6, times_factor(tensor_value), data);
  }

  /// Every DataItem names a dataset of the file beside, with the dimensions it says.
  void expect_description(const Bar &bar, int states = 1) const {
    std::ifstream stream(directory_ / "bar.xdmf");
    const std::string xml{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_TRUE(is_well_formed(xml)) << xml;
    for (const char *words : {bar.dim == 3 ? "\"Tetrahedron\"" : "\"Triangle\"",
                              R"(Name="displacement" AttributeType="Vector" Center="Node")",
                              R"(Name="energy_density" AttributeType="Scalar" Center="Cell")",
                              R"(Name="stress" AttributeType="Tensor6" Center="Cell")"})
      EXPECT_NE(xml.find(words), std::string::npos) << words;
    static const std::regex item(R"(Dimensions="([0-9 ]+)\">(bar[_0-9]*\.h5):([^\n]+)</DataItem>)");
    int items = 0;
    for (std::sregex_iterator match(xml.begin(), xml.end(), item), end; match != end; ++match) {
      const std::string name = std::regex_replace(
          std::regex_replace((*match)[3].str(), std::regex("&lt;"), "<"), std::regex("&gt;"), ">");
      std::istringstream numbers((*match)[1]);
      const std::vector<hsize_t> shape{std::istream_iterator<hsize_t>(numbers), {}};
      EXPECT_EQ(read_dataset(directory_ / (*match)[2].str(), name).shape, shape) << name;
      ++items;
    }
    EXPECT_EQ(items, 6 * states);
  }

  [[nodiscard]] int files_in_directory() const {
    return static_cast<int>(std::distance(fs::directory_iterator(directory_), {}));
  }

  /// Both functions refuse `path` on all ranks, with a sentence that holds `words`.
  void expect_refusal(const fs::path &path, const std::string &words) const {
    const OutputMesh part = part_of({3, 2}, evenly);
    for (const bool only_asked : {true, false}) {
      EXPECT_EQ(only_asked ? check_writable(PETSC_COMM_WORLD, path) : write(path, part),
                PETSC_ERR_FILE_OPEN);
#if PETSC_VERSION_LT(3, 25, 0)
      char *sentence = nullptr;
#else
      const char *sentence = nullptr;
#endif
      EXPECT_EQ(PetscErrorMessage(PETSC_ERR_FILE_OPEN, nullptr, &sentence), PETSC_SUCCESS);
      ASSERT_NE(sentence, nullptr);
      EXPECT_NE(std::string(sentence).find(words), std::string::npos) << sentence;
      EXPECT_NE(std::string(sentence).find(path.stem()), std::string::npos) << sentence;
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  }

  int rank_ = 0, ranks_ = 1;
  fs::path directory_;
};

TEST_F(SnapshotTest, ReadsBackWhatWasWritten) {
  for (const Split &split :
       {Split(evenly), Split(last_rank_empty), Split(all_on_last_rank), Split(in_turns)})
    for (const Bar &bar : {Bar{3, 4}, Bar{2, 5}, Bar{3, 1}}) {
      ASSERT_EQ(check_writable(PETSC_COMM_WORLD, directory_ / "bar.xdmf"), PETSC_SUCCESS);
      ASSERT_EQ(write(directory_ / "bar.xdmf", part_of(bar, split)), PETSC_SUCCESS);
      if (rank_ == 0) {
        expect_whole(bar);
        expect_description(bar);
        EXPECT_EQ(files_in_directory(), 2);
      }
      MPI_Barrier(PETSC_COMM_WORLD);
    }
}

TEST_F(SnapshotTest, WritesIntoTheWorkingDirectoryButOnlyWhenTold) {
  const fs::path before = fs::current_path();
  fs::current_path(directory_);
  EXPECT_EQ(check_writable(PETSC_COMM_WORLD, "bar.xdmf"), PETSC_SUCCESS);
  EXPECT_EQ(files_in_directory(), 0);
  MPI_Barrier(PETSC_COMM_WORLD);
  EXPECT_EQ(write("bar.xdmf", part_of({3, 2}, evenly)), PETSC_SUCCESS);
  fs::current_path(before);
  EXPECT_EQ(files_in_directory(), 2);
}

TEST_F(SnapshotTest, RefusesAMissingDirectory) {
  expect_refusal(directory_ / "nowhere" / "bar.xdmf", "there is no directory");
  EXPECT_EQ(files_in_directory(), 0);
}

TEST_F(SnapshotTest, RefusesAnUnwritableDirectory) {
  // Root may write everywhere, but into /proc.
  const fs::path directory = geteuid() == 0 ? "/proc" : directory_ / "locked";
  if (rank_ == 0 && geteuid() != 0) {
    fs::create_directory(directory);
    fs::permissions(directory, fs::perms::owner_read | fs::perms::owner_exec);
  }
  MPI_Barrier(PETSC_COMM_WORLD);
  expect_refusal(directory / "bar.xdmf", "cannot write");
  EXPECT_FALSE(fs::exists(directory / "bar.xdmf") || fs::exists(directory / "bar.h5.part"));
}

TEST_F(SnapshotTest, RefusesWhereADirectoryStands) {
  for (const char *name : {"bar.xdmf", "bar.h5"}) {
    if (rank_ == 0) fs::create_directory(directory_ / name);
    MPI_Barrier(PETSC_COMM_WORLD);
    expect_refusal(directory_ / "bar.xdmf", "directory of this name");
    EXPECT_EQ(files_in_directory(), 1);
    MPI_Barrier(PETSC_COMM_WORLD);
    if (rank_ == 0) fs::remove(directory_ / name);
  }
}

TEST_F(SnapshotTest, RefusesOtherNames) {
  expect_refusal(directory_ / "bar.msh", "must end in .xdmf or .vtu");
  expect_refusal(directory_ / "bar.vtk", "meshio convert bar.xdmf bar.vtk");
  expect_refusal(directory_ / "bar", "must end in");
  expect_refusal(directory_ / "a:bar.xdmf", "colon");
}

TEST_F(SnapshotTest, RefusesArraysThatDoNotFit) {
  const OutputMesh part = part_of({3, 2}, evenly);
  const fs::path path = directory_ / "bar.xdmf";
  std::vector<Field> fields = fields_of(part);
  if (rank_ == ranks_ - 1) fields[0].values.push_back(0);
  EXPECT_EQ(write_snapshot(PETSC_COMM_WORLD, path, part, fields), PETSC_ERR_ARG_SIZ);
  OutputMesh twice = part;
  if (rank_ == 0) twice.point_numbers[0] = twice.point_numbers[1];
  EXPECT_EQ(write(path, twice), PETSC_ERR_ARG_SIZ);
  EXPECT_EQ(files_in_directory(), 0);
}

/// Numbers with gaps between them only say which comes first.
TEST_F(SnapshotTest, NumbersMayLeaveGaps) {
  const Bar bar{3, 3};
  const OutputMesh part = part_of(bar, in_turns, 7);
  ASSERT_EQ(write_snapshot(PETSC_COMM_WORLD, directory_ / "bar.xdmf", part, fields_of(part, 7)),
            PETSC_SUCCESS);
  if (rank_ == 0) expect_whole(bar);
}

/// After every state the files are whole, and say what is in them.
TEST_F(SnapshotTest, SeriesGrow) {
  const Bar bar{3, 3};
  const OutputMesh part = part_of(bar, in_turns);
  for (int round = 0; round < 2; ++round) {  // the second over the first
    Series series;
    ASSERT_EQ(series.open(PETSC_COMM_WORLD, directory_ / "bar.xdmf", part), PETSC_SUCCESS);
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(series.append(0.5 * k, fields_of(part, 1, k + 1)), PETSC_SUCCESS);
      if (rank_ == 0) {
        for (int each = 0; each <= k; ++each)
          expect_whole(bar, "bar_000" + std::to_string(each) + ".h5", each + 1);
        expect_description(bar, k + 1);
        EXPECT_EQ(files_in_directory(), round == 0 ? 3 + k : 5);
      }
      MPI_Barrier(PETSC_COMM_WORLD);
    }
    EXPECT_EQ(series.write_only(fields_of(part)), PETSC_ERR_ORDER);
  }
  std::ifstream stream(directory_ / "bar.xdmf");
  const std::string xml{std::istreambuf_iterator<char>(stream), {}};
  for (const char *words : {R"(CollectionType="Temporal")", R"(<Time Value="0"/>)",
                            R"(<Time Value="0.5"/>)", R"(<Time Value="1"/>)"})
    EXPECT_NE(xml.find(words), std::string::npos) << words;
  MPI_Barrier(PETSC_COMM_WORLD);
}

/// The arrays of a .vtu file behind its head, each behind its size.
std::vector<std::string> arrays_of_vtu(const fs::path &path) {
  std::ifstream stream(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const std::string mark = "encoding=\"raw\">\n_", tail = "\n</AppendedData>\n</VTKFile>\n";
  std::size_t at = text.find(mark);
  if (at == std::string::npos) return {};
  std::vector<std::string> arrays;
  for (at += mark.size(); at + tail.size() < text.size();) {
    std::uint64_t size = 0;
    std::memcpy(&size, text.data() + at, sizeof size);
    arrays.push_back(text.substr(at + sizeof size, size));
    at += sizeof size + size;
  }
  EXPECT_EQ(text.substr(at), tail);
  return arrays;
}

template <class T>
std::vector<T> numbers_in(const std::string &bytes) {
  std::vector<T> numbers(bytes.size() / sizeof(T));
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

void expect_vtu(const fs::path &path, const Bar &bar, double factor = 1) {
  const std::vector<std::string> arrays = arrays_of_vtu(path);
  ASSERT_EQ(arrays.size(), 8u);
  const auto points = numbers_in<double>(arrays[0]);
  const auto nodes = numbers_in<PetscInt>(arrays[1]);
  const auto ends = numbers_in<std::int64_t>(arrays[2]);
  ASSERT_EQ(points.size(), static_cast<std::size_t>(3 * bar.vertices()));
  ASSERT_EQ(ends.size(), static_cast<std::size_t>(bar.cells()));
  EXPECT_EQ(arrays[3], std::string(ends.size(), bar.dim == 3 ? 10 : 5));
  const auto displacement = numbers_in<double>(arrays[4]), energy = numbers_in<double>(arrays[6]);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int vertex = static_cast<int>(k / 3), axis = static_cast<int>(k % 3);
    ASSERT_EQ(points[k], axis < bar.dim ? bar.coordinate(vertex, axis) : 0);
    ASSERT_EQ(displacement[k], factor * vector_value(vertex, axis));
  }
  const auto stress = numbers_in<double>(arrays[7]);
  const int places[] = {0, 3, 5, 1, 4, 2};  // xx yy zz xy yz xz of ours
  for (int cell = 0; cell < bar.cells(); ++cell) {
    const auto c = static_cast<std::size_t>(cell);
    ASSERT_EQ(ends[c], bar.corners() * (cell + 1));
    ASSERT_EQ(energy[c], factor * cell_value(cell));
    for (int corner = 0; corner < bar.corners(); ++corner)
      ASSERT_EQ(nodes[static_cast<std::size_t>(bar.corners() * cell + corner)],
                bar.corner(cell, corner));
    for (std::size_t k = 0; k < 6; ++k)
      ASSERT_EQ(stress[6 * c + k], factor * tensor_value(cell, places[k]));
  }
}

TEST_F(SnapshotTest, GridsOfVtk) {
  for (const Split &split : {Split(evenly), Split(all_on_last_rank), Split(in_turns)})
    for (const Bar &bar : {Bar{3, 4}, Bar{2, 5}}) {
      ASSERT_EQ(write(directory_ / "bar.vtu", part_of(bar, split)), PETSC_SUCCESS);
      if (rank_ == 0) expect_vtu(directory_ / "bar.vtu", bar);
      EXPECT_EQ(files_in_directory(), 1);
      MPI_Barrier(PETSC_COMM_WORLD);
    }
}

TEST_F(SnapshotTest, SeriesOfGridsOfVtk) {
  const Bar bar{3, 3};
  const OutputMesh part = part_of(bar, in_turns);
  Series series;
  ASSERT_EQ(series.open(PETSC_COMM_WORLD, directory_ / "bar.vtu", part), PETSC_SUCCESS);
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(series.append(0.5 * k, fields_of(part, 1, k + 1)), PETSC_SUCCESS);
    if (rank_ == 0) {
      expect_vtu(directory_ / "bar.vtu", bar, k + 1);
      expect_vtu(directory_ / ("bar_000" + std::to_string(k) + ".vtu"), bar, k + 1);
      std::ifstream stream(directory_ / "bar.pvd");
      const std::string xml{std::istreambuf_iterator<char>(stream), {}};
      const std::string last = "file=\"bar_000" + std::to_string(k) + ".vtu\"";
      EXPECT_NE(xml.find(last), std::string::npos) << xml;
      EXPECT_EQ(files_in_directory(), k + 3);
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  }
}

TEST_F(SnapshotTest, AFullDiskKeepsTheOldFiles) {
  const fs::path path = directory_ / "bar.xdmf";
  const Bar old_bar{3, 1};
  ASSERT_EQ(write(path, part_of(old_bar, evenly)), PETSC_SUCCESS);
  // A limit on the size of files stands for the disk.
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{4096, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_EQ(write(path, part_of({3, 40}, evenly)), PETSC_ERR_FILE_OPEN);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(files_in_directory(), 2);
  if (rank_ == 0) expect_whole(old_bar);
}

/// A series that finds no room for its next state keeps those before.
TEST_F(SnapshotTest, AFullDiskKeepsEarlierStates) {
  for (const char *name : {"bar.xdmf", "bar.vtu"}) {
    const Bar bar{3, 60};
    const OutputMesh part = part_of(bar, in_turns);
    Series series;
    ASSERT_EQ(series.open(PETSC_COMM_WORLD, directory_ / name, part), PETSC_SUCCESS);
    ASSERT_EQ(series.append(0, fields_of(part)), PETSC_SUCCESS);
    MPI_Barrier(PETSC_COMM_WORLD);
    const auto size =
        fs::file_size(directory_ / (name == std::string("bar.vtu") ? name : "bar.h5"));
    MPI_Barrier(PETSC_COMM_WORLD);
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{size / 2, before.rlim_max};
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    EXPECT_EQ(series.append(1, fields_of(part, 1, 2)), PETSC_ERR_FILE_OPEN) << name;
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    if (rank_ == 0 && name == std::string("bar.vtu")) {
      expect_vtu(directory_ / name, bar);
    } else if (rank_ == 0) {
      expect_whole(bar, "bar_0000.h5");
      expect_description(bar);
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  }
}

}  // namespace
}  // namespace trefoil
