// What a material costs: nanoseconds for one deformation gradient, alone and in packs of eight with
// the best instruction set of this machine. The gradients are random, a part of them inverted.
//
//   build/tests/benchmarks/material_benchmark

#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>

#include "trefoil/material_registry.hpp"

namespace {

using namespace trefoil;

constexpr int packs = 512;
double sink = 0;  // what is computed is used, so that it is computed

/// Nanoseconds a call of `work`, for `gradients` deformation gradients each: the least of five.
template <class Work>
double nanoseconds(int gradients, const Work &work) {
  double least = 1e300;
  for (int repetition = 0; repetition < 5; ++repetition) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - begin;
    least = std::min(least, spent.count() / gradients);
  }
  return least;
}

std::vector<double> random_gradients() {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.4);
  std::vector<double> F(9 * lanes * packs);
  for (std::size_t k = 0; k < F.size(); ++k) F[k] = noise(random) + (k / lanes % 9 % 4 == 0);
  return F;
}

}  // namespace

int main() {
  const std::vector<double> gradients = random_gradients();
  std::printf("%-20s %8s %8s %8s   %10s\n", "ns a gradient", "energy", "stress", "tangent",
              "tangent, alone");
  for (const std::string &name : material_names()) {
    const auto model = make_material(name, {{1, 0.4}});
    alignas(64) double result[81 * lanes];
    const auto packed = [&](auto function) {
      return nanoseconds(lanes * packs, [&] {
        for (int pack = 0; pack < packs; ++pack) {
          function(&gradients[static_cast<std::size_t>(9 * lanes * pack)]);
          sink += result[pack % lanes];
        }
      });
    };
    const double energy = packed([&](const double *F) { model->energy_densities(F, result); });
    const double stress = packed([&](const double *F) { model->stresses(F, result); });
    const double tangent = packed([&](const double *F) { model->tangents(F, result); });
    const double alone = nanoseconds(packs, [&] {
      for (int pack = 0; pack < packs; ++pack) {
        Matrix3<double> F;
        Tangent<double> A;
        for (std::size_t k = 0; k < 9; ++k) {
          F.entries[k] = gradients[static_cast<std::size_t>(9 * lanes * pack) + lanes * k];
        }
        model->tangent(F, A);
        sink += A[40];
      }
    });
    std::printf("%-20s %8.1f %8.1f %8.1f   %10.1f\n", name.c_str(), energy, stress, tangent, alone);
  }
  return std::isnan(sink) && sink == 0;
}
