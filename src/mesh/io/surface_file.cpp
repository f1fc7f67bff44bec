#include "mesh/io/surface_file.hpp"

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

/// Numbers the points of triangles that name each corner by its place.
class PointNumbers {
 public:
  explicit PointNumbers(SurfaceMesh *surface) : surface_(surface) {}

  int number(const std::array<double, 3> &place) {
    const auto [found, is_new] = numbers_.emplace(place, static_cast<int>(surface_->points.size()));
    if (is_new) surface_->points.push_back(place);
    return found->second;
  }
  /// Adds a triangle, unless it has two corners at one place.
  void add(const std::array<std::array<double, 3>, 3> &corners) {
    const std::array<int, 3> facet{number(corners[0]), number(corners[1]), number(corners[2])};
    if (facet[0] == facet[1] || facet[1] == facet[2] || facet[2] == facet[0]) return;
    surface_->facets.push_back(facet);
  }

 private:
  SurfaceMesh *surface_;
  std::map<std::array<double, 3>, int> numbers_;
};

constexpr std::size_t stl_header = 84, stl_triangle = 50;

std::uint32_t count_of_binary_stl(const std::string &text) {
  std::uint32_t count = 0;
  std::memcpy(&count, text.data() + 80, sizeof(count));
  return count;
}

bool is_binary_stl(const std::string &text) {
  return text.size() >= stl_header &&
         text.size() == stl_header + stl_triangle * std::size_t{count_of_binary_stl(text)};
}

/// Says what a binary .stl lacks that is shorter than it says itself. A text has no zero byte.
void check_stl_is_whole(const std::string &name, const std::string &text) {
  if (text.size() < stl_header || text.find('\0') >= stl_header) return;
  const std::size_t room = (text.size() - stl_header) / stl_triangle;
  if (count_of_binary_stl(text) <= room) return;
  throw InputError("'" + name + "' is cut short: it announces " +
                   std::to_string(count_of_binary_stl(text)) + " triangles and has room for " +
                   std::to_string(room));
}

void check_surface(const std::string &name, const SurfaceMesh &surface) {
  if (surface.facets.empty()) throw InputError("'" + name + "' has no triangles");
  for (const auto &point : surface.points) {
    for (const double x : point) {
      if (!std::isfinite(x)) throw InputError("'" + name + "' has a point that is not finite");
    }
  }
}

}  // namespace

SurfaceMesh parse_obj(const std::string &name, const std::string &text) {
  SurfaceMesh surface;
  std::istringstream lines(text);
  std::string line, word;
  for (int number = 1; std::getline(lines, line); ++number) {
    const auto refuse = [&](const std::string &why) {
      throw InputError("'" + name + "', line " + std::to_string(number) + ": " + why);
    };
    std::istringstream words(line);
    if (!(words >> word)) continue;
    if (word == "v") {
      std::array<double, 3> point{};
      if (!(words >> point[0] >> point[1] >> point[2])) refuse("a point needs three numbers");
      surface.points.push_back(point);
    } else if (word == "f" || word == "l") {
      const bool is_face = word == "f";
      std::vector<int> corners;
      while (words >> word) {  // "3/1/2": the point, and what is no matter here
        const int count = static_cast<int>(surface.points.size());
        const long corner = std::strtol(word.c_str(), nullptr, 10);
        if (corner == 0 || corner > count || -corner > count) {
          refuse("'" + word + "' is no point before this line");
        }
        corners.push_back(static_cast<int>(corner > 0 ? corner - 1 : count + corner));
      }
      if (corners.size() < (is_face ? 3U : 2U)) refuse("too few corners");
      for (std::size_t k = 1; !is_face && k < corners.size(); ++k) {
        surface.facets.push_back({corners[k - 1], corners[k], -1});
      }
      for (std::size_t k = 2; is_face && k < corners.size(); ++k) {
        surface.facets.push_back({corners[0], corners[k - 1], corners[k]});
      }
    }
  }
  check_surface(name, surface);
  return surface;
}

SurfaceMesh parse_stl(const std::string &name, const std::string &text) {
  SurfaceMesh surface;
  PointNumbers points(&surface);
  check_stl_is_whole(name, text);
  if (is_binary_stl(text)) {
    for (std::size_t at = stl_header; at < text.size(); at += stl_triangle) {
      std::array<float, 12> numbers{};  // the normal and three corners
      std::memcpy(numbers.data(), text.data() + at, sizeof(numbers));
      std::array<std::array<double, 3>, 3> corners;
      for (std::size_t k = 0; k < 9; ++k) corners[k / 3][k % 3] = numbers[3 + k];
      points.add(corners);
    }
  } else {
    std::istringstream words(text);
    std::string word;
    std::array<std::array<double, 3>, 3> corners;
    std::size_t count = 0;
    bool is_ended = true;
    if (!(words >> word) || word != "solid") {
      throw InputError("'" + name + "' is neither a binary nor a text .stl");
    }
    while (words >> word) {
      if (word == "endsolid") is_ended = true;
      if (word != "vertex") continue;
      is_ended = false;
      auto &corner = corners[count];
      if (!(words >> corner[0] >> corner[1] >> corner[2])) {
        throw InputError("'" + name + "' has a vertex without three numbers");
      }
      count = (count + 1) % 3;
      if (count == 0) points.add(corners);
    }
    if (count) throw InputError("'" + name + "' ends within a triangle");
    if (!is_ended) {
      throw InputError("'" + name + "' is cut short: it has no `endsolid` at its end");
    }
  }
  check_surface(name, surface);
  return surface;
}

PetscErrorCode read_surface(MPI_Comm comm, const std::string &path, SurfaceMesh *surface) {
  int rank = 0;
  std::string text, complaint;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  const std::string ending = std::filesystem::path(path).extension().string();
  if (rank == 0) {
    complaint = complaint_of([&] {
      if (ending != ".obj" && ending != ".stl") {
        throw InputError("'" + path + "' is no surface that can be read: give an .obj or an .stl");
      }
      std::ifstream file(path, std::ios::binary);
      if (!file) throw InputError("cannot read '" + path + "': " + std::strerror(errno));
      text.assign(std::istreambuf_iterator<char>(file), {});
    });
  }
  PetscCall(agree_on_complaint(comm, complaint));
  int length = static_cast<int>(text.size());
  PetscCallMPI(MPI_Bcast(&length, 1, MPI_INT, 0, comm));
  text.resize(static_cast<std::size_t>(length));
  PetscCallMPI(MPI_Bcast(text.data(), length, MPI_CHAR, 0, comm));
  complaint = complaint_of(
      [&] { *surface = ending == ".obj" ? parse_obj(path, text) : parse_stl(path, text); });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
