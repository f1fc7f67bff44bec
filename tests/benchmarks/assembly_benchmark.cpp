// What one Newton iteration costs around the linear solve, part by part and as a whole, batched and
// plain in the same run: nanoseconds an element. Asserts nothing.
//
//   build/tests/benchmarks/assembly_benchmark [poisson ratio = 0.495] [resolution of the knot = 4]

#include <petsctime.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>

#include "assembly/energy_functional.hpp"
#include "element/tet4_packs.hpp"
#include "filter/reduced_filter.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/generate.hpp"
#include "petsc_compatibility.hpp"
#include "term/elastic_term.hpp"

using namespace trefoil;

namespace {

/// Least seconds of several runs: the machine may be shared.
double seconds(const std::function<PetscErrorCode()> &run, int repeats) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) {
    PetscLogDouble begin = 0, end = 0;
    static_cast<void>(PetscTime(&begin));
    PetscCallAbort(PETSC_COMM_SELF, run());
    static_cast<void>(PetscTime(&end));
    least = std::min(least, end - begin);
  }
  return least;
}

double print_part(const char *name, double time, PetscInt elements) {
  const double nanoseconds = 1e9 * time / static_cast<double>(elements);
  std::printf("  %-46s %9.1f ns/element\n", name, nanoseconds);
  return nanoseconds;
}

/// A body pulled and twisted so that elements are stretched, sheared and partly indefinite.
void deform(const Mesh &mesh, std::vector<double> *u) {
  for (std::size_t v = 0; 3 * v < mesh.coordinates.size(); ++v) {
    const double *p = &mesh.coordinates[3 * v];
    const double angle = 0.4 * p[2], stretch = 1.3;
    (*u)[3 * v] = (std::cos(angle) * p[0] - std::sin(angle) * p[1]) / std::sqrt(stretch) - p[0];
    (*u)[3 * v + 1] = (std::sin(angle) * p[0] + std::cos(angle) * p[1]) / std::sqrt(stretch) - p[1];
    (*u)[3 * v + 2] = (stretch - 1) * p[2] + 0.02 * std::sin(20 * p[0]) * std::cos(17 * p[1]);
  }
}

PetscErrorCode benchmark(double poisson, PetscInt resolution) {
  Mesh mesh;
  PetscFunctionBeginUser;
  PetscCall(
      distribute_mesh(PETSC_COMM_WORLD, generate_mesh("knot", resolution, 0), "metis", 0, &mesh));
  HeldDofs held{std::vector<char>(mesh.coordinates.size(), 0),
                std::vector<double>(mesh.coordinates.size(), 0)};
  for (std::size_t v = 0; 3 * v < mesh.coordinates.size(); ++v) {
    if (mesh.coordinates[3 * v] < mesh.box_min[0] + 0.5) std::fill_n(&held.held[3 * v], 3, 1);
  }
  Discretization discretization;
  PetscCall(discretization.set_up(mesh, held));
  Mat H = nullptr;
  PetscCall(discretization.create_matrix(&H));
  const StableNeoHookean material({1e6, poisson}, StableNeoHookean::Lame::raw);
  const ElasticTerm term(mesh, make_material_model(material));
  const Tet4Packs &tets = *term.packs();
  const PetscInt elements = mesh.local_cells(), packs = tets.packs();
  std::vector<double> u(mesh.coordinates.size()), forces(u.size());
  deform(mesh, &u);

  std::vector<double> K(static_cast<std::size_t>(packs) * reduced_entries * lanes), N(K.size());
  std::vector<int> negative(static_cast<std::size_t>(packs) * lanes);
  EnergySums sums;
  BatchedHessian batched;
  DirectAssembly direct;
  PetscCall(batched.set_up(discretization, term, H));
  PetscCall(direct.set_up(discretization, tets, H));
  Mat N_matrix = nullptr;
  PetscCall(MatDuplicate(H, MAT_DO_NOT_COPY_VALUES, &N_matrix));

  term.reduced_hessians(0, packs, u.data(), K.data());
  const SplitResult result =
      split_reduced(static_cast<int>(packs), K.data(), N.data(), negative.data());
  std::printf("%d tetrahedra, nu %g, %.0f %% indefinite, instruction set %d\n",
              static_cast<int>(elements), poisson, 100.0 * result.indefinite / elements,
              static_cast<int>(chosen_instruction_set()));
  const auto ok = static_cast<PetscErrorCode>(0);
  print_part("energy",
             seconds(
                 [&] {
                   term.add_energy(u.data(), &sums);
                   return ok;
                 },
                 5),
             elements);
  print_part("forces",
             seconds(
                 [&] {
                   term.add_gradient(u.data(), forces.data());
                   return ok;
                 },
                 5),
             elements);
  print_part("reduced Hessians",
             seconds(
                 [&] {
                   term.reduced_hessians(0, packs, u.data(), K.data());
                   return ok;
                 },
                 5),
             elements);
  print_part("negative parts",
             seconds(
                 [&] {
                   static_cast<void>(
                       split_reduced(static_cast<int>(packs), K.data(), N.data(), negative.data()));
                   return ok;
                 },
                 5),
             elements);
  DirectAssembly::Target target;
  PetscCall(direct.begin(H, &target));
  const AddBlocks add_blocks = add_blocks_kernel();
  print_part("adding H",
             seconds(
                 [&] {
                   add_blocks(direct.sums(), 0, packs, K.data(), nullptr, target.arrays);
                   return ok;
                 },
                 5),
             elements);
  print_part("adding N",
             seconds(
                 [&] {
                   add_blocks(direct.sums(), 0, packs, N.data(), negative.data(), target.arrays);
                   return ok;
                 },
                 5),
             elements);
  PetscCall(direct.end(&target));
  print_part("zeroing a matrix", seconds([&] { return MatZeroEntries(H); }, 5), elements);
  print_part("H + 2 w N", seconds([&] { return MatAXPY(H, 1, N_matrix, SAME_NONZERO_PATTERN); }, 5),
             elements);

  TrefoilSplitStatistics statistics{};
  const double fast =
      print_part("energy, forces, H and N: batched",
                 seconds(
                     [&] {
                       term.add_energy(u.data(), &sums);
                       term.add_gradient(u.data(), forces.data());
                       return batched.assemble(term, u.data(), H, N_matrix, true, &statistics);
                     },
                     5),
                 elements);
  EnergyFunctional plain(discretization);
  plain.add_term(std::make_unique<ElasticTerm>(mesh, make_material_model(material)));
  SNES snes = nullptr;
  Vec x = nullptr, g = nullptr;
  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(plain.attach(snes, H, EnergyFunctional::Assembly::plain));
  PetscCall(discretization.create_vector(&x));
  PetscCall(VecDuplicate(x, &g));
  Vec local = nullptr;
  PetscCall(DMGetLocalVector(mesh.dm, &local));
  PetscScalar *value = nullptr;
  PetscCall(VecGetArray(local, &value));
  std::copy(u.begin(), u.end(), value);
  PetscCall(VecRestoreArray(local, &value));
  PetscCall(DMLocalToGlobal(mesh.dm, local, INSERT_VALUES, x));
  PetscCall(DMRestoreLocalVector(mesh.dm, &local));
  const double slow = print_part("energy, forces, H and N: LAPACK and MatSetValues",
                                 seconds(
                                     [&] {
                                       PetscCall(plain.energy(x, &sums));
                                       PetscCall(plain.gradient(x, g));
                                       return plain.hessian(x, H, &N_matrix, &statistics);
                                     },
                                     2),
                                 elements);
  std::printf("  ratio %.1f\n", slow / fast);
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&g));
  PetscCall(SNESDestroy(&snes));
  PetscCall(MatDestroy(&N_matrix));
  PetscCall(MatDestroy(&H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

int main(int argc, char **argv) {
  // One thread for LAPACK, whose library reads this before main() begins.
  if (!std::getenv("OPENBLAS_NUM_THREADS")) {
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    execv("/proc/self/exe", argv);
  }
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  PetscCall(benchmark(argc > 1 ? std::atof(argv[1]) : 0.495, argc > 2 ? std::atoi(argv[2]) : 4));
  PetscCall(PetscFinalize());
  return 0;
}
