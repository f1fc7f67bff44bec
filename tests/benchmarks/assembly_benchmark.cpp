// What one Newton iteration costs around the linear solve: part by part against the machine's
// measured peak, and as a whole against the plain path in the same run. Asserts nothing.
//
//   assembly_benchmark [resolutions of the knot = 4] [poisson ratios = 0.495] [plain | no_plain]
//   assembly_benchmark 4,9,13 0.3,0.495,0.4999
//   assembly_benchmark resolution nu element [element | deformation]
//   assembly_benchmark 2 0.495 tet10 deformation
// Elements: tri3 and tri6 on the square, tet4 and tet10 on the knot, filtered by element (default)
// or by quadrature point.

#include <petsctime.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <string>

#include "assembly/energy_functional.hpp"
#include "element/tet4_packs.hpp"
#include "element_benchmark.hpp"
#include "filter/reduced_filter.hpp"
#include "flop_count.hpp"
#include "machine_peak.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/generate.hpp"
#include "one_thread.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/elastic_term.hpp"

using namespace trefoil;

namespace {

const auto ok = static_cast<PetscErrorCode>(0);

double now() {
  PetscLogDouble time = 0;
  static_cast<void>(PetscTime(&time));
  return time;
}

/// Least seconds of several runs: the machine may be shared.
double seconds(int repeats, const std::function<PetscErrorCode()> &run) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) {
    const double begin = now();
    PetscCallAbort(PETSC_COMM_SELF, run());
    least = std::min(least, now() - begin);
  }
  return least;
}

/// A body pulled and twisted: at strength 1 almost every element is indefinite at nu = .495, at
/// less as many as in scenes.
std::vector<double> deform(const Mesh &mesh, double strength) {
  std::vector<double> u(mesh.coordinates.size());
  const double stretch = 1 + 0.3 * strength;
  for (std::size_t v = 0; 3 * v < u.size(); ++v) {
    const double *p = &mesh.coordinates[3 * v];
    const double angle = 0.4 * strength * p[2];
    u[3 * v] = (std::cos(angle) * p[0] - std::sin(angle) * p[1]) / std::sqrt(stretch) - p[0];
    u[3 * v + 1] = (std::sin(angle) * p[0] + std::cos(angle) * p[1]) / std::sqrt(stretch) - p[1];
    u[3 * v + 2] =
        (stretch - 1) * p[2] + 0.02 * strength * std::sin(20 * p[0]) * std::cos(17 * p[1]);
  }
  return u;
}

struct Knot {
  Mesh mesh;
  Discretization discretization;
  Mat H = nullptr, N = nullptr;

  PetscErrorCode set_up(PetscInt resolution) {
    PetscFunctionBeginUser;
    PetscCall(
        distribute_mesh(PETSC_COMM_WORLD, generate_mesh("knot", resolution, 0), "metis", 0, &mesh));
    HeldDofs held{std::vector<char>(mesh.coordinates.size(), 0),
                  std::vector<double>(mesh.coordinates.size(), 0)};
    for (std::size_t v = 0; 3 * v < mesh.coordinates.size(); ++v) {
      if (mesh.coordinates[3 * v] < mesh.box_min[0] + 0.5) std::fill_n(&held.held[3 * v], 3, 1);
    }
    PetscCall(discretization.set_up(mesh, held));
    PetscCall(discretization.create_matrix(&H));
    PetscCall(MatDuplicate(H, MAT_DO_NOT_COPY_VALUES, &N));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ~Knot() {
    static_cast<void>(MatDestroy(&N));
    static_cast<void>(MatDestroy(&H));
  }
};

/// Seconds of H and N by part, chunk by chunk as BatchedHessian works.
struct Parts {
  double K = 0, add_H = 0, filter = 0, add_N = 0;
  double indefinite = 0, negative = 0;  ///< counts: elements, and eigenvalues
  [[nodiscard]] double sum() const { return K + add_H + filter + add_N; }
};

PetscErrorCode measure_parts(const ElasticTerm &term, const std::vector<double> &u,
                             const BatchedHessian &batched, Mat H_matrix, Mat N_matrix,
                             Parts *parts) {
  constexpr PetscInt chunk = 2 * BlockSums::stretch;
  const Tet4Packs &tets = *term.packs();
  const AddBlocks add_blocks = add_blocks_kernel();
  std::vector<double> K(chunk * reduced_entries * lanes), N(K.size());
  std::vector<int> negative(chunk * lanes);
  MatrixBlocks::Target H, N_target;
  PetscFunctionBeginUser;
  PetscCall(batched.blocks().begin(H_matrix, &H));
  PetscCall(batched.blocks().begin(N_matrix, &N_target));
  for (PetscInt first = 0; first < tets.packs(); first += chunk) {
    const PetscInt count = std::min(chunk, tets.packs() - first);
    const double t0 = now();
    term.reduced_hessians(first, count, u.data(), K.data());
    const double t1 = now();
    add_blocks(batched.sums(), first, count, K.data(), nullptr, H.arrays);
    const double t2 = now();
    const SplitResult result =
        split_reduced(static_cast<int>(count), K.data(), N.data(), negative.data());
    const double t3 = now();
    add_blocks(batched.sums(), first, count, N.data(), negative.data(), N_target.arrays);
    const double t4 = now();
    parts->K += t1 - t0;
    parts->add_H += t2 - t1;
    parts->filter += t3 - t2;
    parts->add_N += t4 - t3;
    parts->indefinite += static_cast<double>(result.indefinite);
    parts->negative += std::accumulate(negative.begin(), negative.begin() + lanes * count, 0.0);
  }
  PetscCall(batched.blocks().end(&H));
  PetscCall(batched.blocks().end(&N_target));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The same by LAPACK and MatSetValues.
PetscErrorCode measure_plain(Knot &knot, const StableNeoHookean &material,
                             const std::vector<double> &u, double *time) {
  Mesh &mesh = knot.mesh;
  EnergyFunctional plain(knot.discretization);
  TrefoilSplitStatistics statistics{};
  EnergySums sums;
  SNES snes = nullptr;
  Vec x = nullptr, g = nullptr, local = nullptr;
  PetscScalar *value = nullptr;
  PetscFunctionBeginUser;
  plain.add_term(std::make_unique<ElasticTerm>(mesh, make_material_model(material)));
  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(plain.attach(snes, knot.H, EnergyFunctional::Assembly::plain));
  PetscCall(knot.discretization.create_vector(&x));
  PetscCall(VecDuplicate(x, &g));
  PetscCall(DMGetLocalVector(mesh.dm, &local));
  PetscCall(VecGetArray(local, &value));
  std::copy(u.begin(), u.end(), value);
  PetscCall(VecRestoreArray(local, &value));
  PetscCall(DMLocalToGlobal(mesh.dm, local, INSERT_VALUES, x));
  PetscCall(DMRestoreLocalVector(mesh.dm, &local));
  *time = seconds(2, [&] {
    PetscCall(plain.energy(x, &sums));
    PetscCall(plain.gradient(x, g));
    return plain.hessian(x, knot.H, &knot.N, &statistics);
  });
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&g));
  PetscCall(SNESDestroy(&snes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

struct Printer {
  MachinePeak peak;
  double elements;
  void row(const char *name, double time, double flops, double bytes) const {
    const double each = time / elements;
    std::printf("| %-32s | %6.1f | %5.0f | %4.0f %% | %4.0f | %4.0f %% |\n", name, 1e9 * each,
                flops, 100 * flops / each / peak.flops_per_second, bytes,
                100 * bytes / each / peak.bytes_per_second);
  }
};

PetscErrorCode benchmark(Knot &knot, double poisson, double strength, const MachinePeak &peak,
                         bool with_plain) {
  const StableNeoHookean material({1e6, poisson}, StableNeoHookean::Lame::raw);
  const ElasticTerm term(knot.mesh, make_material_model(material));
  const std::vector<double> u = deform(knot.mesh, strength);
  std::vector<double> forces(u.size());
  const auto elements = static_cast<double>(knot.mesh.local_cells());
  EnergySums sums;
  BatchedHessian batched;
  TrefoilSplitStatistics statistics{};
  MatInfo info;
  PetscFunctionBeginUser;
  PetscCall(batched.set_up(knot.discretization, term, knot.H));
  PetscCall(MatGetInfo(knot.H, MAT_LOCAL, &info));
  Parts parts;
  for (int repeat = 0; repeat < 5; ++repeat) {
    Parts here;
    PetscCall(measure_parts(term, u, batched, knot.H, knot.N, &here));
    if (repeat == 0 || here.sum() < parts.sum()) parts = here;
  }
  std::printf(
      "\n%.0f tetrahedra, nu %g, %.1f %% indefinite with %.2f negative eigenvalues each\n\n",
      elements, poisson, 100 * parts.indefinite / elements,
      parts.negative / std::max(parts.indefinite, 1.0));
  std::printf(
      "| part                             | ns     | flops | of peak | bytes | of bandwidth |\n"
      "|---|---|---|---|---|---|\n");
  const FlopCount flops(material, static_cast<double>(batched.sums().pairs.size()) / elements);
  const double body = term.bytes() / elements,
               field = 8.0 * static_cast<double>(u.size()) / elements;
  const double matrix = 8 * info.nz_used / elements, places = batched.bytes() / elements;
  const double filter_flops = FlopCount::filter(parts.indefinite / elements,
                                                parts.negative / std::max(parts.indefinite, 1.0));
  const Printer print{peak, elements};
  const auto energy = [&] {
    term.add_energy(u.data(), &sums);
    return ok;
  };
  const auto gradient = [&] {
    term.add_gradient(u.data(), forces.data());
    return ok;
  };
  print.row("energy", seconds(5, energy), flops.energy, body + field);
  print.row("forces", seconds(5, gradient), flops.forces, body + 3 * field);
  print.row("reduced Hessians", parts.K, flops.hessian, body + field);
  print.row("adding H", parts.add_H, flops.add, 2 * matrix + places);
  print.row("negative parts", parts.filter, filter_flops, 0);
  print.row("adding N", parts.add_N, flops.add, 2 * matrix + places);
  const double fast = seconds(5, [&] {
    PetscCall(energy());
    PetscCall(gradient());
    return batched.assemble(term, u.data(), knot.H, knot.N, true, &statistics);
  });
  print.row("energy, forces, H and N", fast,
            flops.energy + flops.forces + flops.hessian + 2 * flops.add + filter_flops,
            3 * body + 5 * field + 6 * matrix + 2 * places);
  if (with_plain) {
    double slow = 0;
    PetscCall(measure_plain(knot, material, u, &slow));
    std::printf("| %-32s | %6.0f | ratio %.1f\n", "the same, LAPACK and MatSetValues",
                1e9 * slow / elements, slow / fast);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode run(const char *resolutions, const char *poissons, bool with_plain) {
  PetscFunctionBeginUser;
  const MachinePeak peak = measure_machine_peak();
  std::printf("instruction set %d, one core: %.1f Gflop/s in registers, %.1f GB/s from memory\n",
              static_cast<int>(chosen_instruction_set()), 1e-9 * peak.flops_per_second,
              1e-9 * peak.bytes_per_second);
  for (const char *r = resolutions; r;
       r = std::strchr(r, ',') ? std::strchr(r, ',') + 1 : nullptr) {
    Knot knot;
    PetscCall(knot.set_up(std::atoi(r)));
    for (const char *p = poissons; p; p = std::strchr(p, ',') ? std::strchr(p, ',') + 1 : nullptr) {
      for (const double strength : {0.05, 1.0}) {
        PetscCall(benchmark(knot, std::atof(p), strength, peak, with_plain));
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

int main(int argc, char **argv) {
  keep_lapack_to_one_thread(argv);
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  const std::string element = argc > 3 ? argv[3] : "";
  if (element.substr(0, 2) == "tr" || element.substr(0, 2) == "te") {
    const bool points = argc > 4 && std::strcmp(argv[4], "deformation") == 0;
    PetscCall(benchmark_element(std::atof(argv[2]), std::atoi(argv[1]), element,
                                points ? FilterSpace::deformation : FilterSpace::element));
    PetscCall(PetscFinalize());
    return 0;
  }
  PetscCall(run(argc > 1 ? argv[1] : "4", argc > 2 ? argv[2] : "0.495",
                argc <= 3 || std::strcmp(argv[3], "no_plain") != 0));
  PetscCall(PetscFinalize());
  return 0;
}
