// Projection to positive semi-definite matrices, element by element against the global Hessian: the
// negative part of every element's matrix in batches, and by LAPACK one by one, and that of the
// assembled matrix by a dense eigen-decomposition. Prints seconds and ratios, asserts nothing.
//
//   projection_benchmark [resolutions of the square = 8,16,24] [poisson ratio = 0.495]

#include <petsctime.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "assembly/energy_functional.hpp"
#include "filter/filter.hpp"
#include "filter/packed_filter.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/generate.hpp"
#include "one_thread.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/elastic_term.hpp"

extern "C" void dsyevd_(const char *jobz, const char *uplo, const int *n, double *A, const int *lda,
                        double *w, double *work, const int *lwork, int *iwork, const int *liwork,
                        int *info, std::size_t, std::size_t);

using namespace trefoil;

namespace {

double seconds(int repeats, const std::function<void()> &run) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) {
    PetscLogDouble begin = 0, end = 0;
    static_cast<void>(PetscTime(&begin));
    run();
    static_cast<void>(PetscTime(&end));
    least = std::min(least, end - begin);
  }
  return least;
}

/// Element matrices as they come, for LAPACK.
class Collector final : public StencilSink {
 public:
  PetscErrorCode add(const Stencil &stencil, const double *H) override {
    matrices.insert(matrices.end(), H, H + stencil.n * stencil.n);
    return PETSC_SUCCESS;
  }
  PetscErrorCode add_split(const Stencil &, const double *, const double *, int) override {
    return PETSC_SUCCESS;
  }
  std::vector<double> matrices;
};

/// Eigenvalues and eigenvectors of a dense symmetric matrix, and its negative part.
double project_dense(const std::vector<double> &dense, int n, int *negative) {
  std::vector<double> A, values(static_cast<std::size_t>(n)), N(dense.size());
  return seconds(n < 800 ? 3 : 1, [&] {
    A = dense;
    const int work_size = 1 + 6 * n + 2 * n * n, integers = 3 + 5 * n;
    std::vector<double> work(static_cast<std::size_t>(work_size));
    std::vector<int> integer(static_cast<std::size_t>(integers));
    int info = 0;
    dsyevd_("V", "L", &n, A.data(), &n, values.data(), work.data(), &work_size, integer.data(),
            &integers, &info, 1, 1);
    std::fill(N.begin(), N.end(), 0);
    *negative = 0;
    for (int k = 0; k < n && values[static_cast<std::size_t>(k)] < 0; ++k, ++*negative) {
      const double *v = &A[static_cast<std::size_t>(n) * static_cast<std::size_t>(k)];
      for (int i = 0; i < n; ++i) {
        const double factor = -values[static_cast<std::size_t>(k)] * v[i];
        double *row = &N[static_cast<std::size_t>(n) * static_cast<std::size_t>(i)];
        for (int j = 0; j < n; ++j) row[j] += factor * v[j];
      }
    }
  });
}

PetscErrorCode compare(PetscInt resolution, double poisson) {
  Mesh mesh;
  Discretization discretization;
  Mat H = nullptr;
  Vec x = nullptr;
  TrefoilSplitStatistics ignored{};
  PetscFunctionBeginUser;
  PetscCall(
      distribute_mesh(PETSC_COMM_SELF, generate_mesh("square", resolution, 0), "metis", 0, &mesh));
  HeldDofs held = nothing_held(mesh);
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (mesh.coordinates[3 * v] < 1e-9) std::fill_n(&held.held[3 * v], 3, 1);
  }
  PetscCall(discretization.set_up(mesh, held));
  PetscCall(discretization.create_matrix(&H));
  PetscCall(discretization.create_vector(&x));
  const StableNeoHookean material({1, poisson}, StableNeoHookean::Lame::physical);
  EnergyFunctional functional(discretization);
  functional.add_term(
      std::make_unique<ElasticTerm>(mesh, make_material_model(material), FilterSpace::element));
  const ElasticTerm term(mesh, make_material_model(material), FilterSpace::element);
  std::vector<double> u(mesh.coordinates.size(), 0);
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    const double *p = &mesh.coordinates[3 * v];
    if (held.held[3 * v]) continue;
    u[3 * v] = -0.3 * p[0] + 0.02 * std::sin(40 * p[1]);
    u[3 * v + 1] = 0.2 * p[0] * p[0] + 0.02 * std::cos(37 * p[0]);
    for (std::size_t i = 0; i < 2; ++i)
      PetscCall(
          VecSetValue(x, discretization.global_dofs()[3 * v + i], u[3 * v + i], INSERT_VALUES));
  }
  PetscCall(VecAssemblyBegin(x));
  PetscCall(VecAssemblyEnd(x));

  const PackedElements &packed = *term.batch();
  const auto size =
      static_cast<std::size_t>(packed.elements().packs() * packed.elements().entries() * lanes);
  std::vector<double> K(size), N(size);
  std::vector<int> negative(static_cast<std::size_t>(packed.elements().packs() * lanes));
  packed.hessians(0, packed.elements().packs(), u.data(), K.data());
  const double batched = seconds(20, [&] {
    static_cast<void>(
        packed.split(0, packed.elements().packs(), u.data(), K.data(), N.data(), negative.data()));
  });
  const auto indefinite = std::count_if(negative.begin(), negative.begin() + mesh.local_cells(),
                                        [](int count) { return count > 0; });
  Collector collector;
  PetscCall(term.add_hessian(u.data(), collector));
  std::vector<double> parts(collector.matrices.size());
  const double plain = seconds(5, [&] {
    static_cast<void>(
        split(6, mesh.local_cells(), collector.matrices.data(), parts.data(), nullptr));
  });
  PetscCall(functional.hessian(x, H, nullptr, &ignored));
  const PetscInt n = discretization.total_dofs();
  std::vector<double> dense(static_cast<std::size_t>(n * n), 0);
  for (PetscInt row = 0; row < n; ++row) {
    PetscInt count = 0;
    const PetscInt *column = nullptr;
    const PetscScalar *value = nullptr;
    PetscCall(MatGetRow(H, row, &count, &column, &value));
    for (PetscInt k = 0; k < count; ++k)
      dense[static_cast<std::size_t>(n * row + column[k])] = value[k];
    PetscCall(MatRestoreRow(H, row, &count, &column, &value));
  }
  int global_negative = 0;
  const double global = project_dense(dense, static_cast<int>(n), &global_negative);
  std::printf("| %d | %d | %d | %ld | %d | %.3g | %.3g | %.3g | %.0f | %.0f |\n",
              static_cast<int>(resolution), static_cast<int>(mesh.local_cells()),
              static_cast<int>(n), static_cast<long>(indefinite), global_negative, batched, plain,
              global, global / batched, global / plain);
  PetscCall(VecDestroy(&x));
  PetscCall(MatDestroy(&H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

int main(int argc, char **argv) {
  keep_lapack_to_one_thread(argv);
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  std::printf(
      "| resolution | triangles | unknowns | indefinite triangles | negative eigenvalues of H |"
      " batched, s | LAPACK by element, s | global, s | global/batched | global/by element |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  std::istringstream resolutions(argc > 1 ? argv[1] : "8,16,24");
  for (std::string word; std::getline(resolutions, word, ',');) {
    PetscCall(compare(std::atoi(word.c_str()), argc > 2 ? std::atof(argv[2]) : 0.495));
  }
  PetscCall(PetscFinalize());
  return 0;
}
