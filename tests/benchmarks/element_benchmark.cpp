#include "element_benchmark.hpp"

#include <petsctime.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>

#include "assembly/energy_functional.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/generate.hpp"
#include "mesh/locality.hpp"
#include "mesh/quadratic.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
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

}  // namespace

/// Energy, forces, H and N of other elements, batched and plain.
PetscErrorCode benchmark_element(double poisson, PetscInt resolution, const std::string &element,
                                 FilterSpace space) {
  const bool flat = element.substr(0, 3) == "tri",
             quadratic = element == "tri6" || element == "tet10";
  Mesh mesh;
  CellList whole = generate_mesh(flat ? "square" : "knot", resolution, 0);
  if (quadratic) promote_to_quadratic(whole);
  order_along_curve(whole);
  PetscFunctionBeginUser;
  PetscCall(distribute_mesh(PETSC_COMM_WORLD, whole, "metis", 0, &mesh));
  HeldDofs held = nothing_held(mesh);
  for (std::size_t v = 0; 3 * v < mesh.coordinates.size(); ++v) {
    const double part =
        (mesh.coordinates[3 * v] - mesh.box_min[0]) / (mesh.box_max[0] - mesh.box_min[0]);
    if (part < 0.07) std::fill_n(&held.held[3 * v], 3, 1);
  }
  Discretization discretization;
  PetscCall(discretization.set_up(mesh, held));
  Mat H = nullptr, N = nullptr;
  PetscCall(discretization.create_matrix(&H));
  PetscCall(MatDuplicate(H, MAT_DO_NOT_COPY_VALUES, &N));
  const StableNeoHookean material({1e6, poisson}, StableNeoHookean::Lame::raw);
  EnergyFunctional batched(discretization), plain(discretization);
  for (EnergyFunctional *each : {&batched, &plain}) {
    each->add_term(std::make_unique<ElementTerm>(mesh, make_material_model(material), space));
  }
  const ElementTerm term(mesh, make_material_model(material), space);
  const PackedElements &packed = *term.packed_elements();
  SNES snes = nullptr;
  Vec x = nullptr, g = nullptr;
  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(plain.attach(snes, H, EnergyFunctional::Assembly::plain));
  PetscCall(discretization.create_vector(&x));
  PetscCall(VecDuplicate(x, &g));
  std::vector<double> u(mesh.coordinates.size()), forces(u.size());
  deform(mesh, &u);
  for (std::size_t k = 0; k < u.size(); ++k) {
    if (held.held[k]) u[k] = 0;
    if (discretization.global_dofs()[k] >= 0)
      PetscCall(VecSetValue(x, discretization.global_dofs()[k], u[k], INSERT_VALUES));
  }
  PetscCall(VecAssemblyBegin(x));
  PetscCall(VecAssemblyEnd(x));

  const PetscInt elements = mesh.local_cells(), chunk = 32, packs = packed.packs();
  EnergySums sums;
  TrefoilSplitStatistics counts{}, ignored{};
  PetscCall(batched.hessian(x, H, &N, &counts));
  std::printf("%d %s, nu %g, %.0f %% indefinite, filtered by %s, instruction set %d\n",
              static_cast<int>(elements), mesh.element_name().c_str(), poisson,
              100.0 * static_cast<double>(counts.indefinite) / elements,
              space == FilterSpace::element ? "element" : "quadrature point",
              static_cast<int>(chosen_instruction_set()));
  std::vector<double> K(static_cast<std::size_t>(chunk * packed.entries() * lanes)), part(K.size());
  std::vector<int> negative(static_cast<std::size_t>(chunk * lanes));
  const auto ok = static_cast<PetscErrorCode>(0);
  const auto by_chunks = [&](const auto &work) {
    for (PetscInt first = 0; first < packs; first += chunk) {
      work(first, std::min(chunk, packs - first));
    }
    return ok;
  };
  print_part("energy", seconds([&] { return term.add_energy(u.data(), &sums), ok; }, 5), elements);
  print_part("forces", seconds([&] { return term.add_gradient(u.data(), forces.data()), ok; }, 5),
             elements);
  const double hessians = seconds(
      [&] {
        return by_chunks([&](PetscInt first, PetscInt count) {
          packed.hessians(first, count, u.data(), K.data());
        });
      },
      3);
  print_part("reduced Hessians", hessians, elements);
  print_part("negative parts",
             seconds(
                 [&] {
                   return by_chunks([&](PetscInt first, PetscInt count) {
                     packed.hessians(first, count, u.data(), K.data());
                     static_cast<void>(packed.split(first, count, u.data(), K.data(), part.data(),
                                                    negative.data()));
                   });
                 },
                 3) -
                 hessians,
             elements);
  BatchedHessian hessian;
  MatrixBlocks::Target target;
  PetscCall(hessian.set_up(discretization, term, H));
  PetscCall(hessian.blocks().begin(H, &target));
  print_part("adding H",
             seconds(
                 [&] {
                   return by_chunks([&](PetscInt first, PetscInt count) {
                     packed.add_blocks(first, count, K.data(), nullptr, hessian.places(),
                                       target.arrays);
                   });
                 },
                 3),
             elements);
  PetscCall(hessian.blocks().end(&target));
  const auto all = [&](EnergyFunctional &functional) {
    PetscFunctionBeginUser;
    PetscCall(functional.energy(x, &sums));
    PetscCall(functional.gradient(x, g));
    PetscCall(functional.hessian(x, H, &N, &ignored));
    PetscFunctionReturn(PETSC_SUCCESS);
  };
  const double fast = print_part("energy, forces, H and N: batched",
                                 seconds([&] { return all(batched); }, 3), elements);
  const double slow = print_part("energy, forces, H and N: LAPACK and MatSetValues",
                                 seconds([&] { return all(plain); }, 2), elements);
  std::printf("  ratio %.1f\n", slow / fast);
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&g));
  PetscCall(SNESDestroy(&snes));
  PetscCall(MatDestroy(&N));
  PetscCall(MatDestroy(&H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
