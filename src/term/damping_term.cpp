#include "term/damping_term.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "support/petsc_compatibility.hpp"
#include "term/mass_matrix.hpp"
#include "term/quadratic_changes.hpp"

namespace trefoil {
namespace {

constexpr std::size_t most_rows = 3 * (ReferenceElement::most_nodes - 1);

/// Columns of the basis of the reduced matrices, see ElementPacks.
struct Basis {
  explicit Basis(std::size_t nodes)
      : first(1 / std::sqrt(static_cast<double>(nodes))), shared(first * first / (1 - first)) {}
  [[nodiscard]] double operator()(std::size_t node, std::size_t mode) const {
    return node == 0 ? first : (node == mode + 1 ? 1 : 0) - shared;
  }
  double first, shared;
};

}  // namespace

std::vector<double> DampingTerm::product(double factor, const std::vector<double> &w) const {
  const ElementPacks &packs = cells_.elements();
  const auto nodes = static_cast<std::size_t>(packs.reference->nodes);
  const auto dim = static_cast<std::size_t>(packs.reference->dimension);
  const auto rows = static_cast<std::size_t>(packs.rows());
  const auto entries = static_cast<std::size_t>(packs.entries());
  const Basis Q(nodes);
  std::vector<double> result(w.size(), 0);
  for (std::size_t cell = 0; cell < static_cast<std::size_t>(packs.elements); ++cell) {
    const std::size_t pack = cell / lanes, lane = cell % lanes;
    const PetscInt *node = &packs.nodes[nodes * pack * lanes + lane];
    const double *K = &stiffness_[entries * pack * lanes + lane];
    std::array<double, most_rows> q{}, force{};
    for (std::size_t a = 0; a < nodes; ++a) {
      const double *value = &w[3 * static_cast<std::size_t>(node[a * lanes])];
      for (std::size_t r = 0; r < rows; ++r) q[r] += Q(a, r / dim) * value[r % dim];
    }
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t c = 0; c <= r; ++c, K += lanes) {
        force[r] += *K * q[c];
        if (c != r) force[c] += *K * q[r];
      }
    }
    for (std::size_t a = 0; a < nodes; ++a) {
      double *value = &result[3 * static_cast<std::size_t>(node[a * lanes])];
      for (std::size_t r = 0; r < rows; ++r) value[r % dim] += factor * Q(a, r / dim) * force[r];
    }
  }
  return result;
}

std::vector<double> DampingTerm::moved(const double *u) const {
  std::vector<double> w(origin_.size());
  for (std::size_t k = 0; k < w.size(); ++k) w[k] = u[k] - origin_[k];
  return w;
}

PetscErrorCode DampingTerm::begin_step(const StepState &state) {
  PetscFunctionBeginUser;
  scale_ = damping_ / state.velocity_time;
  hessian_scale_ = state.step > 0 ? scale_ : 0;
  std::copy_n(state.velocity_origin, origin_.size(), origin_.begin());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DampingTerm::accept_step(const double *u) {
  const ElementPacks &packs = cells_.elements();
  const PetscInt count = packs.packs();
  std::vector<double> negative(static_cast<std::size_t>(packs.entries() * lanes * count));
  std::vector<int> counts(static_cast<std::size_t>(count * lanes));
  PetscFunctionBeginUser;
  stiffness_.resize(negative.size());
  cells_.hessians(0, count, u, stiffness_.data());
  const SplitResult result =
      cells_.split(0, count, u, stiffness_.data(), negative.data(), counts.data());
  PetscCheck(result.status == SplitStatus::ok, PETSC_COMM_SELF, PETSC_ERR_FP,
             "a stiffness that damps is not finite");
  for (std::size_t k = 0; k < negative.size(); ++k) stiffness_[k] += negative[k];
  ++version_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DampingTerm::add_energy(const double *u, EnergySums *sums) const {
  PetscFunctionBeginUser;
  const std::vector<double> w = moved(u);
  const double energy = 0.5 * dot(w, product(scale_, w));
  sums->energy += energy;
  sums->scale += energy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DampingTerm::add_energy_changes(const double *u, std::size_t size, int directions,
                                               const double *const *d, int points,
                                               const double *coefficients, double *changes) const {
  PetscFunctionBeginUser;
  static_cast<void>(size);
  add_quadratic_changes([this](const std::vector<double> &w) { return product(scale_, w); },
                        product(scale_, moved(u)), directions, d, points, coefficients, changes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DampingTerm::add_gradient(const double *u, double *gradient) const {
  PetscFunctionBeginUser;
  const std::vector<double> forces = product(scale_, moved(u));
  for (std::size_t k = 0; k < forces.size(); ++k) gradient[k] += forces[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DampingTerm::add_hessian(const double *, StencilSink &sink) const {
  const ElementPacks &packs = cells_.elements();
  const int nodes = packs.reference->nodes, dim = packs.reference->dimension, n = dim * nodes;
  std::vector<double> blocks(static_cast<std::size_t>(nodes * (nodes + 1) / 2 * dim * dim * lanes));
  std::vector<double> H(static_cast<std::size_t>(n * n));
  std::vector<PetscInt> dofs(static_cast<std::size_t>(n));
  PetscFunctionBeginUser;
  for (PetscInt cell = 0; cell < packs.elements; ++cell) {
    const PetscInt pack = cell / lanes, lane = cell % lanes;
    if (lane == 0)
      cells_.expand()(&stiffness_[static_cast<std::size_t>(packs.entries() * lanes * pack)],
                      blocks.data());
    for (int r = 0; r < n; ++r) {
      const auto at = static_cast<std::size_t>((nodes * pack + r / dim) * lanes + lane);
      dofs[static_cast<std::size_t>(r)] = 3 * packs.nodes[at] + r % dim;
    }
    const double *entry = blocks.data() + lane;
    for (int a = 0; a < nodes; ++a) {
      for (int b = a; b < nodes; ++b) {
        for (int k = 0; k < dim * dim; ++k, entry += lanes) {
          const int row = dim * a + k / dim, column = dim * b + k % dim;
          H[static_cast<std::size_t>(n * row + column)] = *entry;
          H[static_cast<std::size_t>(n * column + row)] = *entry;
        }
      }
    }
    PetscCall(sink.add({.n = n, .dofs = dofs.data(), .cell = cell}, H.data()));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

double DampingTerm::bytes() const {
  return static_cast<double>((stiffness_.capacity() + origin_.capacity()) * sizeof(double));
}

}  // namespace trefoil
