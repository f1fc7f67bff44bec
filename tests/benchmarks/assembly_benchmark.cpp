// What one Newton iteration costs around the linear solve: part by part against the machine's
// measured peak, and as a whole against the plain path in the same run. Asserts nothing.
//
//   assembly_benchmark [resolutions = 4] [poisson ratios = 0.495] [element = tet4] [deformation]
//                      [no_plain]
//   assembly_benchmark 4,9,13 0.3,0.495,0.4999 no_plain
//   assembly_benchmark 2 0.495 tet10 deformation
// Elements: tet4 and tet10 on the knot, tri3 and tri6 on the square, filtered by element or, with
// `deformation`, by quadrature point.

#include <petsctime.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <limits>
#include <numeric>
#include <sstream>
#include <string>

#include "assembly/energy_functional.hpp"
#include "assembly/hessian_assembler.hpp"
#include "flop_count.hpp"
#include "machine_peak.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/generate.hpp"
#include "mesh/locality.hpp"
#include "mesh/quadratic.hpp"
#include "one_thread.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/elastic_term.hpp"

using namespace trefoil;

namespace {

double now() {
  PetscLogDouble time = 0;
  static_cast<void>(PetscTime(&time));
  return time;
}

/// Least processor seconds of several runs: the machine may be shared.
double seconds(int repeats, const std::function<PetscErrorCode()> &run) {
  std::clock_t least = std::numeric_limits<std::clock_t>::max();
  for (int i = 0; i < repeats; ++i) {
    const std::clock_t begin = std::clock();
    PetscCallAbort(PETSC_COMM_SELF, run());
    least = std::min(least, std::clock() - begin);
  }
  return static_cast<double>(least) / CLOCKS_PER_SEC;
}

/// A body pulled and twisted: at strength 1 almost every element is indefinite at nu = .495, at
/// less as many as in scenes.
std::vector<double> deform(const Mesh &mesh, double strength) {
  std::vector<double> u(mesh.coordinates.size());
  const double stretch = 1 + 0.3 * strength;
  for (std::size_t v = 0; 3 * v < u.size(); ++v) {
    const double *p = &mesh.coordinates[3 * v];
    const double angle = 0.4 * strength * (mesh.dimension() == 3 ? p[2] : p[0]);
    u[3 * v] = (std::cos(angle) * p[0] - std::sin(angle) * p[1]) / std::sqrt(stretch) - p[0];
    u[3 * v + 1] = (std::sin(angle) * p[0] + std::cos(angle) * p[1]) / std::sqrt(stretch) - p[1];
    const double wave = 0.02 * strength * std::sin(20 * p[0]) * std::cos(17 * p[1]);
    if (mesh.dimension() == 3) {
      u[3 * v + 2] = (stretch - 1) * p[2] + wave;
    } else {
      u[3 * v] += wave;
    }
  }
  return u;
}

struct Body {
  Mesh mesh;
  Discretization discretization;
  Mat H = nullptr, N = nullptr;

  PetscErrorCode set_up(const std::string &element, PetscInt resolution) {
    const bool flat = element.substr(0, 3) == "tri";
    PetscFunctionBeginUser;
    CellList whole =
        generate_mesh(flat ? "square" : "knot", flat ? 16 * resolution : resolution, 0);
    if (element == "tri6" || element == "tet10") promote_to_quadratic(whole);
    order_along_curve(whole);
    PetscCall(distribute_mesh(PETSC_COMM_WORLD, whole, "metis", 0, &mesh));
    HeldDofs held = nothing_held(mesh);
    for (std::size_t v = 0; 3 * v < mesh.coordinates.size(); ++v) {
      const double part =
          (mesh.coordinates[3 * v] - mesh.box_min[0]) / (mesh.box_max[0] - mesh.box_min[0]);
      if (part < 0.07) std::fill_n(&held.held[3 * v], 3, 1);
    }
    PetscCall(discretization.set_up(mesh, held));
    PetscCall(discretization.create_matrix(&H));
    PetscCall(MatDuplicate(H, MAT_DO_NOT_COPY_VALUES, &N));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ~Body() {
    static_cast<void>(MatDestroy(&N));
    static_cast<void>(MatDestroy(&H));
  }
};

/// Seconds of H and N by part, chunk by chunk as PackedAssembler works.
struct Parts {
  using Times = std::array<double, 4>;  ///< K, adding H, filter, adding N
  std::vector<Times> of_chunk;          ///< the least of all runs
  double indefinite = 0, negative = 0;  ///< counts: elements, and eigenvalues

  void include(std::size_t chunk, const Times &times) {
    of_chunk.resize(std::max(of_chunk.size(), chunk + 1), Times{1, 1, 1, 1});
    for (std::size_t k = 0; k < times.size(); ++k) {
      of_chunk[chunk][k] = std::min(of_chunk[chunk][k], times[k]);
    }
  }
  [[nodiscard]] double sum(std::size_t part) const {
    double total = 0;
    for (const Times &times : of_chunk) total += times[part];
    return total;
  }
};

PetscErrorCode measure_parts(const ElasticTerm &term, const std::vector<double> &u,
                             const PackedAssembler &assembler, Mat H_matrix, Mat N_matrix,
                             Parts *parts) {
  const PackedElements &elements = *term.batch();
  const ElementPacks &packs = elements.elements();
  const PetscInt chunk = PackedAssembler::chunk_of(packs);
  const AddBlocks add_blocks = add_blocks_kernel(*packs.reference);
  const BlockSums &sums = assembler.sums_of(packs);
  std::vector<double> K(static_cast<std::size_t>(chunk * packs.entries() * lanes)), N(K.size());
  std::vector<int> negative(static_cast<std::size_t>(chunk * lanes));
  MatrixBlocks::Target H, N_target;
  PetscFunctionBeginUser;
  PetscCall(assembler.blocks().begin(H_matrix, &H));
  PetscCall(assembler.blocks().begin(N_matrix, &N_target));
  for (PetscInt first = 0; first < packs.packs(); first += chunk) {
    const PetscInt count = std::min(chunk, packs.packs() - first);
    const double t0 = now();
    elements.hessians(first, count, u.data(), K.data());
    const double t1 = now();
    add_blocks(sums, elements.expand(), first, count, K.data(), nullptr, H.arrays);
    const double t2 = now();
    const SplitResult result =
        elements.split(first, count, u.data(), K.data(), N.data(), negative.data());
    const double t3 = now();
    add_blocks(sums, elements.expand(), first, count, N.data(), negative.data(), N_target.arrays);
    const double t4 = now();
    parts->include(static_cast<std::size_t>(first / chunk), {t1 - t0, t2 - t1, t3 - t2, t4 - t3});
    parts->indefinite += static_cast<double>(result.indefinite);
    parts->negative += std::accumulate(negative.begin(), negative.begin() + lanes * count, 0.0);
  }
  PetscCall(assembler.blocks().end(&H));
  PetscCall(assembler.blocks().end(&N_target));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Springs from every vertex to the ground: a second term.
class Springs final : public Term {
 public:
  Springs(const Mesh &mesh, HessianKind kind) : mesh_(mesh), kind_(kind) {}
  PetscErrorCode add_energy(const double *, EnergySums *) const override { return PETSC_SUCCESS; }
  PetscErrorCode add_gradient(const double *, double *) const override { return PETSC_SUCCESS; }
  [[nodiscard]] HessianKind hessian_kind() const override { return kind_; }
  PetscErrorCode add_hessian(const double *, StencilSink &sink) const override {
    const int n = mesh_.dimension();
    const double plane[4] = {1, 0, 0, 1}, space[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, nothing[9] = {};
    const double *identity = n == 2 ? plane : space;
    PetscFunctionBeginUser;
    for (PetscInt v = 0; v < mesh_.local_vertices(); ++v) {
      const PetscInt dofs[3] = {3 * v, 3 * v + 1, 3 * v + 2};
      PetscCall(sink.add_split({.n = n, .dofs = dofs}, identity, nothing, 0));
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }

 private:
  const Mesh &mesh_;
  HessianKind kind_;
};

/// H and N of the elastic term alone and with another one, in turns.
PetscErrorCode print_second_terms(const Body &body,
                                  const std::function<std::unique_ptr<Term>()> &elastic,
                                  const std::vector<double> &u) {
  constexpr HessianKind kinds[] = {HessianKind::none, HessianKind::constant, HessianKind::stencils};
  const char *names[] = {"H and N, one term", "H and N, and a constant matrix",
                         "H and N, and a stencil a vertex"};
  double least[3] = {1e300, 1e300, 1e300};
  Mat N = body.N;
  PetscFunctionBeginUser;
  for (int repeat = 0; repeat < 10; ++repeat) {
    for (int k = 0; k < 3; ++k) {
      HessianAssembler::Terms terms;
      TrefoilSplitStatistics statistics{};
      terms.push_back(elastic());
      terms.push_back(std::make_unique<Springs>(body.mesh, kinds[k]));
      HessianAssembler assembler(body.discretization, terms);
      const HessianFilter filter;
      PetscCall(assembler.assemble(u.data(), body.H, N, &filter, &statistics));
      least[k] = std::min(least[k], seconds(2, [&] {
                            return assembler.assemble(u.data(), body.H, N, &filter, &statistics);
                          }));
    }
  }
  for (int k = 0; k < 3; ++k) {
    std::printf("| %-32s | %6.1f | ratio %.2f\n", names[k],
                1e9 * least[k] / body.mesh.local_cells(), least[k] / least[0]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Element matrices as they come.
class Collector final : public StencilSink {
 public:
  explicit Collector(const Discretization &discretization) : discretization_(discretization) {}
  PetscErrorCode add(const Stencil &stencil, const double *H) override {
    const auto &number = discretization_.global_dofs();
    for (int i = 0; i < stencil.n; ++i) {
      for (int j = 0; j < stencil.n; ++j) {
        rows.push_back(number[static_cast<std::size_t>(stencil.dofs[i])]);
        columns.push_back(number[static_cast<std::size_t>(stencil.dofs[j])]);
      }
    }
    values.insert(values.end(), H, H + stencil.n * stencil.n);
    return PETSC_SUCCESS;
  }
  PetscErrorCode add_split(const Stencil &stencil, const double *H, const double *, int) override {
    return add(stencil, H);
  }
  std::vector<PetscInt> rows, columns;
  std::vector<double> values;

 private:
  const Discretization &discretization_;
};

/// Adding H by PETSc's coordinate format, the numbers of the elements given: without what it takes
/// to write them.
PetscErrorCode measure_coordinates(const Body &body, const ElasticTerm &term,
                                   const std::vector<double> &u, double *time) {
  Mat matrix = nullptr;
  PetscInt rows = 0;
  Collector all(body.discretization);
  PetscFunctionBeginUser;
  PetscCall(term.add_hessian(u.data(), all));
  PetscCall(MatGetLocalSize(body.H, &rows, nullptr));
  PetscCall(MatCreate(PETSC_COMM_WORLD, &matrix));
  PetscCall(MatSetSizes(matrix, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(matrix, MATAIJ));
  PetscCall(MatSetPreallocationCOO(matrix, static_cast<PetscCount>(all.values.size()),
                                   all.rows.data(), all.columns.data()));
  *time = seconds(15, [&] { return MatSetValuesCOO(matrix, all.values.data(), INSERT_VALUES); });
  PetscCall(MatDestroy(&matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Energy, gradient, H and N by LAPACK and MatSetValues.
PetscErrorCode measure_plain(Body &body, std::unique_ptr<Term> term, const std::vector<double> &u,
                             double *time) {
  Mesh &mesh = body.mesh;
  EnergyFunctional plain(body.discretization);
  TrefoilSplitStatistics statistics{};
  EnergySums sums;
  SNES snes = nullptr;
  Vec x = nullptr, g = nullptr, local = nullptr;
  PetscScalar *value = nullptr;
  PetscFunctionBeginUser;
  plain.add_term(std::move(term));
  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(plain.attach(snes, body.H, EnergyFunctional::Assembly::plain));
  PetscCall(body.discretization.create_vector(&x));
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
    return plain.hessian(x, body.H, &body.N, &statistics);
  });
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&g));
  PetscCall(SNESDestroy(&snes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

struct Printer {
  MachinePeak peak;
  double elements;
  bool counted;  ///< flops are known
  void row(const char *name, double time, double flops, double bytes) const {
    const double each = time / elements;
    std::printf("| %-32s | %6.1f |", name, 1e9 * each);
    if (counted) {
      std::printf(" %5.0f | %4.0f %% |", flops, 100 * flops / each / peak.flops_per_second);
    }
    std::printf(" %4.0f | %4.0f %% |\n", bytes, 100 * bytes / each / peak.bytes_per_second);
  }
};

PetscErrorCode benchmark(Body &body, double poisson, FilterSpace space, double strength,
                         const MachinePeak &peak, bool with_plain) {
  const StableNeoHookean material({1e6, poisson}, StableNeoHookean::Lame::raw);
  const ElasticTerm term(body.mesh, make_material_model(material), space);
  const ElementPacks &packs = term.batch()->elements();
  const std::vector<double> u = deform(body.mesh, strength);
  std::vector<double> forces(u.size());
  const auto elements = static_cast<double>(body.mesh.local_cells());
  EnergySums sums;
  PackedAssembler assembler;
  TrefoilSplitStatistics statistics{};
  MatInfo info;
  PetscFunctionBeginUser;
  PetscCall(assembler.set_up(body.discretization, std::vector{&packs}, body.H));
  PetscCall(MatGetInfo(body.H, MAT_LOCAL, &info));
  Parts parts;
  for (int repeat = 0; repeat < 15; ++repeat) {
    parts.indefinite = parts.negative = 0;
    PetscCall(measure_parts(term, u, assembler, body.H, body.N, &parts));
  }
  std::printf(
      "\n%.0f %s, nu %g, %.1f %% indefinite with %.2f negative eigenvalues each%s; the table "
      "of places takes %.0f bytes an element\n\n",
      elements, body.mesh.element_name().c_str(), poisson, 100 * parts.indefinite / elements,
      parts.negative / std::max(parts.indefinite, 1.0),
      space == FilterSpace::deformation ? ", filtered by quadrature point" : "",
      assembler.bytes() / elements);
  const bool counted = packs.reference->nodes == 4 && space == FilterSpace::element;
  std::printf(counted ? "| part                             | ns     | flops | of peak | bytes | "
                        "of bandwidth |\n|---|---|---|---|---|---|\n"
                      : "| part                             | ns     | bytes | of bandwidth |\n"
                        "|---|---|---|---|\n");
  const FlopCount flops(material,
                        static_cast<double>(assembler.sums_of(packs).pairs.size()) / elements);
  const double rest = term.bytes() / elements,
               field = 8.0 * static_cast<double>(u.size()) / elements;
  const double matrix = 8 * info.nz_used / elements, places = assembler.bytes() / elements;
  const double filter_flops = FlopCount::filter(parts.indefinite / elements,
                                                parts.negative / std::max(parts.indefinite, 1.0));
  const Printer print{peak, elements, counted};
  const auto energy = [&] { return term.add_energy(u.data(), &sums); };
  const auto gradient = [&] { return term.add_gradient(u.data(), forces.data()); };
  print.row("energy", seconds(15, energy), flops.energy, rest + field);
  print.row("forces", seconds(15, gradient), flops.forces, rest + 3 * field);
  print.row("reduced Hessians", parts.sum(0), flops.hessian, rest + field);
  print.row("adding H", parts.sum(1), flops.add, 2 * matrix + places);
  print.row("negative parts", parts.sum(2), filter_flops, 0);
  print.row("adding N", parts.sum(3), flops.add, 2 * matrix + places);
  const PackedAssembler::Part part{term.batch()};
  const double fast = seconds(15, [&] {
    PetscCall(energy());
    PetscCall(gradient());
    return assembler.assemble({&part, 1}, u.data(), {}, body.H, body.N, true, &statistics);
  });
  print.row("energy, forces, H and N", fast,
            flops.energy + flops.forces + flops.hessian + 2 * flops.add + filter_flops,
            3 * rest + 5 * field + 6 * matrix + 2 * places);
  const auto elastic = [&] {
    return std::make_unique<ElasticTerm>(body.mesh, make_material_model(material), space);
  };
  PetscCall(print_second_terms(body, elastic, u));
  if (with_plain) {
    double slow = 0, coordinates = 0;
    PetscCall(measure_coordinates(body, term, u, &coordinates));
    std::printf("| %-32s | %6.1f | ratio %.1f\n", "adding H by MatSetValuesCOO",
                1e9 * coordinates / elements, coordinates / parts.sum(1));
    PetscCall(measure_plain(body, elastic(), u, &slow));
    std::printf("| %-32s | %6.0f | ratio %.1f\n", "all, by LAPACK and MatSetValues",
                1e9 * slow / elements, slow / fast);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<double> numbers(const std::string &list) {
  std::vector<double> result;
  std::istringstream words(list);
  for (std::string word; std::getline(words, word, ',');) result.push_back(std::stod(word));
  return result;
}

PetscErrorCode run(const std::vector<std::string> &arguments) {
  std::string element = "tet4";
  FilterSpace space = FilterSpace::element;
  bool with_plain = true;
  PetscFunctionBeginUser;
  for (std::size_t i = 2; i < arguments.size(); ++i) {
    if (arguments[i] == "no_plain") {
      with_plain = false;
    } else if (arguments[i] == "deformation") {
      space = FilterSpace::deformation;
    } else {
      element = arguments[i];
    }
  }
  const MachinePeak peak = measure_machine_peak();
  std::printf("instruction set %d, one core: %.1f Gflop/s in registers, %.1f GB/s from memory\n",
              static_cast<int>(chosen_instruction_set()), 1e-9 * peak.flops_per_second,
              1e-9 * peak.bytes_per_second);
  for (const double resolution : numbers(arguments.empty() ? "4" : arguments[0])) {
    Body body;
    PetscCall(body.set_up(element, static_cast<PetscInt>(resolution)));
    for (const double poisson : numbers(arguments.size() < 2 ? "0.495" : arguments[1])) {
      for (const double strength : {0.05, 1.0}) {
        PetscCall(benchmark(body, poisson, space, strength, peak, with_plain));
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

int main(int argc, char **argv) {
  keep_lapack_to_one_thread(argv);
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  PetscCall(run(arguments));
  PetscCall(PetscFinalize());
  return 0;
}
