// What a material costs: nanoseconds for one deformation, in packs of eight with the best
// instruction set of this machine. The deformations are random, a part of them inverted; and small
// strains. The last column is for 28 energies in a plane, as the search samples them.
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

/// Nanoseconds a call of `work`, for `deformations` each: the least of nine.
template <class Work>
double nanoseconds(int deformations, const Work &work) {
  double least = 1e300;
  for (int repetition = 0; repetition < 9; ++repetition) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - begin;
    least = std::min(least, spent.count() / deformations);
  }
  return least;
}

/// Displacement gradients of about the given size.
std::vector<double> random_gradients(double size) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, size);
  std::vector<double> H(9 * lanes * packs);
  for (double &entry : H) entry = noise(random);
  return H;
}

}  // namespace

int main() {
  std::vector<PlanePoint> plane;
  for (int k = 0; k < 28; ++k) plane.emplace_back(0.01 * (k % 7), 0.02 * (k % 4));
  std::vector<double> changes(lanes * plane.size(), 0);
  const double weight[lanes] = {};
  std::printf("%-20s %8s %8s %8s %8s %8s\n", "ns a deformation", "H", "energy", "stress", "tangent",
              "plane");
  for (const std::string &name : material_names()) {
    for (const double size : {0.4, 1e-3}) {
      const std::vector<double> gradients = random_gradients(size);
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
      const double energy = packed([&](const double *H) { model->energy_densities(H, result); });
      const double stress = packed([&](const double *H) { model->stresses(H, result); });
      const double tangent = packed([&](const double *H) { model->tangents(H, result); });
      const double changes_in_plane = packed([&](const double *H) {
        model->energy_changes(H, H, &gradients[0], plane, weight, changes.data());
      });
      std::printf("%-20s %8g %8.1f %8.1f %8.1f %8.1f\n", name.c_str(), size, energy, stress,
                  tangent, changes_in_plane);
    }
  }
  return std::isnan(sink) && sink == 0;
}
