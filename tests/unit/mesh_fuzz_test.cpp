// Damaged files, at random but always the same ones: every reader refuses them with an InputError,
// or makes something of them that can be worked with. Meant for the sanitizers (preset `sanitize`),
// which see what a wrong answer would not show; a file that breaks a reader is left in the
// temporary folder.
//
//   TREFOIL_FUZZ_RUNS=100000 TREFOIL_FUZZ_SEED=2 ctest -R mesh_fuzz

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include "mesh/check_mesh.hpp"
#include "mesh/locality.hpp"
#include "mesh/quadratic.hpp"
#include "mesh/refine.hpp"
#include "mesh/repeated.hpp"
#include "mesh_writers.hpp"

namespace trefoil::testing {
namespace {

/// A file that a reader reads, and the reader; it throws InputError for what it refuses.
struct Sample {
  const char *name;
  std::string contents;
  std::function<void(const std::string &path)> read;
};

bool is_in_range(const std::vector<PetscInt> &numbers, std::size_t count) {
  return std::all_of(numbers.begin(), numbers.end(), [&](PetscInt number) {
    return number >= 0 && static_cast<std::size_t>(number) < count;
  });
}

void expect_usable(const CellList &mesh) {
  const auto vertices = static_cast<std::size_t>(mesh.vertices());
  EXPECT_GT(mesh.size(), 0);
  EXPECT_EQ(mesh.cells.size() % static_cast<std::size_t>(mesh.nodes_per_cell()), 0u);
  EXPECT_TRUE(is_in_range(mesh.cells, vertices));
  EXPECT_TRUE(std::all_of(mesh.coordinates.begin(), mesh.coordinates.end(),
                          [](double coordinate) { return std::isfinite(coordinate); }));
  const std::size_t sets = mesh.groups.sets().size();
  EXPECT_TRUE(mesh.groups.set_of_cell.empty() ||
              mesh.groups.set_of_cell.size() == static_cast<std::size_t>(mesh.size()));
  EXPECT_TRUE(is_in_range(mesh.groups.set_of_cell, sets));
  for (const GroupedEntities &below : mesh.groups.below) {
    EXPECT_TRUE(is_in_range(below.sets, sets));
    EXPECT_TRUE(is_in_range(below.vertices, vertices));
  }
}

/// Reads a mesh, and does with it what is done before it is distributed.
void read_and_prepare(const std::string &path) {
  CellList mesh = read_mesh(path);
  expect_usable(mesh);
  number_as_in_file(mesh);
  take_once(mesh, path);
  check_node_order(mesh, path);
  repair_rest_shape(mesh, Repair::drop, path);
  drop_unused_vertices(mesh);
  if (is_quadratic(*mesh.shape))
    drop_midpoints(mesh);
  else
    refine_uniformly(mesh);
  drop_unused_vertices(mesh);
  promote_to_quadratic(mesh);
  order_along_curve(mesh);
  coincident_vertices(mesh);
  expect_usable(mesh);
}

const std::string plane_medit =
    "MeshVersionFormatted 2\nDimension 2\nVertices 4\n0 0 3\n1 0 0\n1 1 0\n0 1 0\nEdges 2\n1 2 7\n"
    "2 3 -8\nCorners 1\n1\nTriangles 2\n1 2 3 0\n1 3 4 5\nQuadrilaterals 0\nEnd\n";

const std::string second_order =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Comments\nby hand\n$EndComments\n$ParametricNodes\n6\n"
    "1 0 0 0 0 1\n2 2 0 0 1 1 .5\n3 0 2 0 2 1 .5 .5\n4 1 0 0 3 1\n5 1 1 0 3 1\n6 0 1 0 3 1\n"
    "$EndParametricNodes\n$Elements\n4\n1 15 2 4 1 1\n2 8 2 5 1 1 2 4\n3 8 2 -6 1 1 2 4\n"
    "4 9 2 7 1 1 2 3 4 5 6\n$EndElements\n$Periodic\n0\n$EndPeriodic\n";

std::vector<Sample> samples() {
  const TaggedMesh two = two_tetrahedra();
  const TaggedMesh scattered = two_tetrahedra({900000, 2, 31, 4, 5});
  const auto read = read_and_prepare;
  return {{"medit", medit(two.mesh), read},
          {"medit_plane", plane_medit, read},
          {"gmsh_2_2", gmsh_2_2(two, Encoding::ascii), read},
          {"gmsh_2_2_binary", gmsh_2_2(scattered, Encoding::binary), read},
          {"gmsh_2_2_second_order", second_order, read},
          {"gmsh_4_1", gmsh_4_1(scattered, Encoding::ascii), read},
          {"gmsh_4_1_binary", gmsh_4_1(two, Encoding::binary), read},
          {"gmsh_4_1_entities", two_volumes_4_1(Encoding::ascii), read},
          {"gmsh_4_1_entities_binary", two_volumes_4_1(Encoding::binary), read},
          {"gmsh_4_1_partitioned", partitioned_4_1(Encoding::ascii), read},
          {"gmsh_4_1_partitioned_binary", partitioned_4_1(Encoding::binary), read}};
}

/// Damages a file.
class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  std::string mutated(std::string text, const std::string &other) {
    for (auto times = 1 + random_() % 3; times > 0 && !text.empty(); --times) mutate(text, other);
    return text;
  }

 private:
  std::size_t place(const std::string &text) { return random_() % text.size(); }
  std::size_t length(const std::string &text, std::size_t from) {
    return std::min<std::size_t>(text.size() - from, 1 + random_() % 40);
  }

  void mutate(std::string &text, const std::string &other) {
    const std::size_t at = place(text);
    switch (random_() % 8) {
      case 0:
        text[at] = static_cast<char>(random_());
        break;
      case 1:
        text[at] = "0123456789-+.eEn $#\"\n"[random_() % 21];
        break;
      case 2:
        text.erase(at, length(text, at));
        break;
      case 3:
        text.insert(at, text.substr(place(text), 40));
        break;
      case 4:
        text.insert(at, other.substr(place(other), 40));
        break;
      case 5:
        text.resize(at);
        break;
      case 6:
        replace_word(text, at);
        break;
      default:
        replace_binary(text, at);
        break;
    }
  }

  /// A word becomes a number at an end of some range, or another word of the format.
  void replace_word(std::string &text, std::size_t at) {
    static const char *const words[] = {"0",
                                        "-1",
                                        "1",
                                        "2",
                                        "3",
                                        "15",
                                        "29",
                                        "2147483647",
                                        "2147483648",
                                        "-2147483648",
                                        "4294967296",
                                        "1e308",
                                        "-1e308",
                                        "1e-320",
                                        "nan",
                                        "inf",
                                        "9223372036854775807",
                                        "-9223372036854775808",
                                        "99999999999999999999",
                                        "1152921504606846976",
                                        "\"\"",
                                        "$Nodes",
                                        "$Elements",
                                        "$Entities",
                                        "$EndNodes",
                                        "Vertices",
                                        "Triangles",
                                        "Tetrahedra",
                                        "Hexahedra",
                                        "End",
                                        "#"};
    const std::size_t begin = text.find_first_not_of(" \n", at);
    if (begin == std::string::npos) return;
    const std::size_t end = std::min(text.find_first_of(" \n", begin), text.size());
    text.replace(begin, end - begin, words[random_() % std::size(words)]);
  }

  /// Four or eight bytes become a number at an end of its range, or a small one.
  void replace_binary(std::string &text, std::size_t at) {
    static constexpr std::int64_t numbers[] = {0,
                                               1,
                                               -1,
                                               4,
                                               INT32_MAX,
                                               INT32_MIN,
                                               INT64_MAX,
                                               INT64_MIN,
                                               INT64_C(1) << 60,
                                               INT64_C(0x7ff0000000000000)};  // infinity
    const std::int64_t number = numbers[random_() % std::size(numbers)];
    const std::size_t width = random_() % 2 == 0 ? 4 : 8;
    const auto *bytes = reinterpret_cast<const char *>(&number);
    if (at + width <= text.size()) text.replace(at, width, bytes, width);
  }

  std::mt19937 random_;
};

unsigned from_environment(const char *name, unsigned otherwise) {
  const char *text = std::getenv(name);
  return text ? static_cast<unsigned>(std::strtoul(text, nullptr, 10)) : otherwise;
}

class MeshFuzzTest : public ::testing::TestWithParam<Sample> {};

TEST_P(MeshFuzzTest, RefusesOrReadsWhatIsDamaged) {
  const std::vector<Sample> all = samples();
  const unsigned runs = from_environment("TREFOIL_FUZZ_RUNS", 3000);
  Mutator mutator(from_environment("TREFOIL_FUZZ_SEED", 1));
  std::mt19937 choice(17);
  unsigned accepted = 0;
  GetParam().read(TemporaryFile(GetParam().contents).path());
  for (unsigned run = 0; run < runs; ++run) {
    const std::string &other = all[choice() % all.size()].contents;
    const TemporaryFile file(mutator.mutated(GetParam().contents, other));
    try {
      GetParam().read(file.path());
      ++accepted;
    } catch (const InputError &error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
    if (::testing::Test::HasFailure()) FAIL() << "run " << run << " of " << GetParam().name;
  }
  // Damage that nobody sees would test nothing.
  EXPECT_GT(accepted, 0u);
  EXPECT_LT(accepted, runs);
}

INSTANTIATE_TEST_SUITE_P(Readers, MeshFuzzTest, ::testing::ValuesIn(samples()),
                         [](const auto &each) { return std::string(each.param.name); });

}  // namespace
}  // namespace trefoil::testing
