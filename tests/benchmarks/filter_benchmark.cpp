// Time per matrix of split() and of split_reduced() by each instruction set, on elements as in a
// large deformation under way. Never run by ctest.
//     OPENBLAS_NUM_THREADS=1 filter_benchmark --benchmark_repetitions=5
// Columns: Poisson's ratio in 1e-4, percentage of indefinite matrices; "matrix" is the time of one.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "../unit/reduced_matrices.hpp"
#include "filter/filter.hpp"
#include "filter/reduced_filter.hpp"

namespace trefoil {
namespace {

using namespace reduced_matrices;

constexpr int packs = 64, matrices = packs * lanes;

int negative_eigenvalues(const Matrix &A) {
  Matrix N;
  int negative = 0;
  (void)split(n, 1, A.data(), N.data(), &negative);
  return negative;
}

const std::vector<Matrix> &elements(int poisson, int percent) {
  static std::map<std::pair<int, int>, std::vector<Matrix>> made;
  std::vector<Matrix> &result = made[{poisson, percent}];
  if (!result.empty()) return result;
  Random random(1);
  while (static_cast<int>(result.size()) < matrices) {
    const Matrix A = stretched_element(random, poisson * 1e-4);
    const int wanted = matrices * percent / 100, so_far = static_cast<int>(result.size());
    // The indefinite ones first; shuffled below.
    if ((negative_eigenvalues(A) > 0) == (so_far < wanted)) result.push_back(A);
  }
  std::shuffle(result.begin(), result.end(), random);
  return result;
}

void report(benchmark::State &state) {
  state.counters["matrix"] = benchmark::Counter(
      matrices, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void plain(benchmark::State &state) {
  const auto &A = elements(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  std::vector<Matrix> N(A.size());
  for (auto _ : state) {
    benchmark::DoNotOptimize(split(n, matrices, A[0].data(), N[0].data(), nullptr));
  }
  report(state);
}

void split_lanes(benchmark::State &state, InstructionSet instructions) {
  if (!processor_has(instructions)) {
    state.SkipWithError("not on this processor");
    return;
  }
  const auto &A = elements(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const std::vector<double> K = packed(A);
  std::vector<double> N(K.size());
  std::vector<int> negative(A.size());
  ReducedSplitExperiment experiment{instructions};
  for (auto _ : state) {
    benchmark::DoNotOptimize(split_reduced(packs, K.data(), N.data(), negative.data(), experiment));
  }
  report(state);
  state.counters["to_split"] = static_cast<double>(experiment.fallbacks);
}

void cases(benchmark::internal::Benchmark *benchmark) {
  benchmark->ArgsProduct({{3000, 4950, 4999}, {0, 30, 60, 100}});
}

BENCHMARK(plain)->Apply(cases);
BENCHMARK_CAPTURE(split_lanes, baseline, InstructionSet::baseline)->Apply(cases);
BENCHMARK_CAPTURE(split_lanes, avx2, InstructionSet::avx2)->Apply(cases);
BENCHMARK_CAPTURE(split_lanes, avx512, InstructionSet::avx512)->Apply(cases);

}  // namespace
}  // namespace trefoil

BENCHMARK_MAIN();
