// What the element hook costs: nanoseconds per linear tetrahedron (n = 12) of adding its element
// matrix to a Mat, without the hook and under watch, and the ratio of the two at the end.
//
//     OPENBLAS_NUM_THREADS=1 hook_benchmark --benchmark_min_time=1
//
// The elements of a block of cubes, six tetrahedra each, in order. Their matrices are singular by
// translations as an element's are, with a share of them indefinite.

#include <benchmark/benchmark.h>
#include <petscmat.h>

#include <cstdio>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "hook/element_hook.hpp"
#include "support/petsc_compatibility.hpp"

namespace {

constexpr PetscInt cells = 10, vertices = (cells + 1) * (cells + 1) * (cells + 1);
constexpr int n = 12, different = 400;

struct Mesh {
  std::vector<PetscInt> nodes;  ///< four of each element
  Mesh() {
    constexpr PetscInt tetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                           {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
    for (PetscInt cell = 0; cell < cells * cells * cells; ++cell) {
      const PetscInt x = cell % cells, y = cell / cells % cells, z = cell / cells / cells;
      for (const auto &tetrahedron : tetrahedra) {
        for (const PetscInt corner : tetrahedron) {
          nodes.push_back(x + (corner & 1) +
                          (cells + 1) *
                              (y + (corner >> 1 & 1) + (cells + 1) * (z + (corner >> 2 & 1))));
        }
      }
    }
  }
  [[nodiscard]] std::size_t elements() const { return nodes.size() / 4; }
};

/// B' D B with nine strains B of four nodes, zero for translations, and D > 0, or one D < 0.
std::vector<double> element_matrices(int percent_indefinite) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<double> all;
  for (int e = 0; e < different; ++e) {
    double gradients[4][3] = {}, D[9], B[9][n] = {};
    for (int i = 0; i < 3; ++i) {
      for (int a = 1; a < 4; ++a) {
        gradients[a][i] = uniform(engine);
        gradients[0][i] -= gradients[a][i];
      }
    }
    for (int i = 0; i < 9; ++i) {
      D[i] = 1 + 0.5 * uniform(engine);
      for (int a = 0; a < 4; ++a) B[i][3 * a + i % 3] = gradients[a][i / 3];
    }
    if (e % 100 < percent_indefinite) D[e % 9] = -0.3;
    std::vector<double> H(n * n, 0);
    for (int k = 0; k < 9; ++k) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) H[n * i + j] += D[k] * (B[k][i] * B[k][j]);
      }
    }
    all.insert(all.end(), H.begin(), H.end());
  }
  return all;
}

Mat make_matrix(const std::string &type) {
  Mat H = nullptr;
  const auto check = [](PetscErrorCode code) { CHKERRABORT(PETSC_COMM_SELF, code); };
  check(MatCreate(PETSC_COMM_SELF, &H));
  check(MatSetSizes(H, 3 * vertices, 3 * vertices, 3 * vertices, 3 * vertices));
  check(MatSetBlockSize(H, 3));
  check(MatSetType(H, type.c_str()));
  check(MatSeqAIJSetPreallocation(H, 45, nullptr));
  check(MatSeqBAIJSetPreallocation(H, 3, 15, nullptr));
  check(MatSeqSBAIJSetPreallocation(H, 3, 15, nullptr));
  if (type == MATSBAIJ) check(MatSetOption(H, MAT_IGNORE_LOWER_TRIANGULAR, PETSC_TRUE));
  return H;
}

/// As a Jacobian callback does it.
PetscErrorCode assemble(Mat H, const Mesh &mesh, const std::vector<double> &values, bool blocked) {
  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(H));
  for (std::size_t e = 0; e < mesh.elements(); ++e) {
    const double *block = &values[e % different * n * n];
    const PetscInt *nodes = &mesh.nodes[4 * e];
    if (blocked) {
      PetscCall(MatSetValuesBlocked(H, 4, nodes, 4, nodes, block, ADD_VALUES));
    } else {
      PetscInt index[n];
      for (int i = 0; i < n; ++i) index[i] = 3 * nodes[i / 3] + i % 3;
      PetscCall(MatSetValues(H, n, index, n, index, block, ADD_VALUES));
    }
  }
  PetscCall(MatAssemblyBegin(H, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(H, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void measure(benchmark::State &state, const std::string &type, bool watched, int percent) {
  static const Mesh mesh;
  const std::vector<double> values = element_matrices(percent);
  Mat H = make_matrix(type), N = nullptr;
  const auto callback = [&] {
    trefoil::ElementHook *hook = nullptr;
    trefoil::InsertionCounts counts;
    double seconds = 0;
    PetscFunctionBeginUser;
    if (watched) {
      PetscCall(trefoil::ElementHook::attach(H, &hook));
      PetscCall(hook->begin(N, nullptr));
    }
    PetscCall(assemble(H, mesh, values, type != MATAIJ));
    if (watched) PetscCall(hook->end(H, &N, &counts, &seconds));
    PetscFunctionReturn(PETSC_SUCCESS);
  };
  for (int i = 0; i < 2; ++i) {
    if (callback() != 0) state.SkipWithError("PETSc's error, see above");
  }
  for (auto _ : state) {
    if (callback() != 0) state.SkipWithError("PETSc's error, see above");
  }
  using benchmark::Counter;
  state.counters["per_element"] = Counter(static_cast<double>(mesh.elements()),
                                          Counter::kIsIterationInvariantRate | Counter::kInvert);
  static_cast<void>(MatDestroy(&H));
  static_cast<void>(MatDestroy(&N));
}

/// Prints as ever, and keeps the nanoseconds for the table of ratios.
class Reporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run> &runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run &run : runs) {
      const auto found = run.counters.find("per_element");
      // The fastest of repetitions: other programs only make it slower.
      if (run.run_type != Run::RT_Iteration || found == run.counters.end()) continue;
      double &best = nanoseconds_[run.run_name.function_name];
      if (best == 0 || 1e9 * found->second < best) best = 1e9 * found->second;
    }
  }
  void print_ratios() const {
    for (const auto &[name, time] : nanoseconds_) {
      const auto plain = nanoseconds_.find(name.substr(0, name.find('/')) + "/plain");
      if (plain == nanoseconds_.end()) continue;
      std::printf("%-24s %7.0f ns per element, %5.2f x plain\n", name.c_str(), time,
                  time / plain->second);
    }
  }

 private:
  std::map<std::string, double> nanoseconds_;
};

}  // namespace

int main(int argc, char **argv) {
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  benchmark::Initialize(&argc, argv);
  for (const std::string type : {MATAIJ, MATBAIJ, MATSBAIJ}) {
    benchmark::RegisterBenchmark((type + "/plain").c_str(), measure, type, false, 0);
    for (const int percent : {0, 30, 80}) {
      const std::string name = type + "/indefinite " + std::to_string(percent) + "%";
      benchmark::RegisterBenchmark(name.c_str(), measure, type, true, percent);
    }
  }
  Reporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.print_ratios();
  benchmark::Shutdown();
  PetscCall(PetscFinalize());
  return 0;
}
