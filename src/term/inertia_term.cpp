#include "term/inertia_term.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "support/petsc_compatibility.hpp"
#include "term/quadratic_changes.hpp"

namespace trefoil {
namespace {

constexpr std::size_t most_nodes = ReferenceElement::most_nodes;

/// Place of (r, c), c <= r, in a lower triangle.
constexpr std::size_t lower(std::size_t r, std::size_t c) {
  return r * (r + 1) / 2 + c;
}

bool is_linear(const ReferenceElement &reference) {
  return reference.nodes == reference.dimension + 1;
}

/// Entries of what the filter sees of an element's mass, see InertiaTerm::shifts_.
std::size_t shift_entries(const ReferenceElement &reference) {
  const auto modes = static_cast<std::size_t>(reference.nodes) - 1;
  return is_linear(reference) ? 1 : modes * (modes + 1) / 2;
}

/// The mass matrix of an element, in the order of its pack, less what translations take of it: its
/// Schur complement Q'MQ - m m'/m_tt in the basis (1, ..., 1)/sqrt(nodes), Q of ElementPacks, with
/// m = Q'M 1 / sqrt(nodes) and m_tt = 1'M 1 / nodes. K + M is positive semi-definite where, and
/// only where, K + that is.
/// @param S lower triangle, (nodes - 1) rows
void schur_complement(std::size_t nodes, const double *M, double *S) {
  const double s = 1 / std::sqrt(static_cast<double>(nodes)), shared = s * s / (1 - s);
  const std::size_t modes = nodes - 1;
  const auto Q = [&](std::size_t a, std::size_t k) {
    return a == 0 ? s : (a == k + 1 ? 1 : 0) - shared;
  };
  std::array<std::array<double, most_nodes>, most_nodes> MQ{};
  std::array<double, most_nodes> row_sum{}, coupling{};
  double total = 0;
  for (std::size_t a = 0; a < nodes; ++a) {
    for (std::size_t b = 0; b < nodes; ++b) {
      row_sum[a] += M[nodes * a + b];
      for (std::size_t k = 0; k < modes; ++k) MQ[a][k] += M[nodes * a + b] * Q(b, k);
    }
    total += row_sum[a];
  }
  for (std::size_t k = 0; k < modes; ++k) {
    for (std::size_t a = 0; a < nodes; ++a) coupling[k] += Q(a, k) * row_sum[a];
  }
  for (std::size_t k = 0; k < modes; ++k) {
    for (std::size_t l = 0; l <= k; ++l) {
      double sum = 0;
      for (std::size_t a = 0; a < nodes; ++a) sum += Q(a, k) * MQ[a][l];
      S[lower(k, l)] = sum - (total > 0 ? coupling[k] * coupling[l] / total : 0);
    }
  }
}

}  // namespace

InertiaTerm::InertiaTerm(std::shared_ptr<const MassMatrix> mass, const ElementPacks &cells,
                         double damping)
    : mass_(std::move(mass)), cells_(cells), damping_(damping) {
  find_shifts();
}

void InertiaTerm::find_shifts() {
  const auto nodes = static_cast<std::size_t>(cells_.reference->nodes);
  const std::size_t entries = shift_entries(*cells_.reference);
  std::vector<double> M(nodes * nodes), packed(M.size()), S(nodes * (nodes - 1) / 2);
  shifts_.assign(static_cast<std::size_t>(cells_.packs()) * entries * lanes, 0);
  for (PetscInt cell = 0; cell < cells_.elements; ++cell) {
    const auto pack = static_cast<std::size_t>(cell / lanes);
    const auto lane = static_cast<std::size_t>(cell % lanes);
    const PetscInt *node = &mass_->mesh().cells[nodes * static_cast<std::size_t>(cell)];
    std::array<std::size_t, most_nodes> place{};  // in the cell, of a node of the pack
    for (std::size_t a = 0; a < nodes; ++a) {
      const PetscInt vertex = cells_.nodes[(nodes * pack + a) * lanes + lane];
      place[a] = static_cast<std::size_t>(std::find(node, node + nodes, vertex) - node);
    }
    mass_->of_cell(cell, M.data());
    for (std::size_t a = 0; a < nodes; ++a) {
      for (std::size_t b = 0; b < nodes; ++b) {
        packed[nodes * a + b] = M[nodes * place[a] + place[b]];
      }
    }
    schur_complement(nodes, packed.data(), S.data());
    for (std::size_t e = 0; e < entries; ++e) {
      shifts_[(entries * pack + e) * lanes + lane] = S[e];
    }
  }
}

void InertiaTerm::shift_filter(const ElementPacks &cells, PetscInt first, PetscInt count,
                               double *K) const {
  if (&cells != &cells_) return;
  const auto dim = static_cast<std::size_t>(cells.reference->dimension);
  const auto modes = static_cast<std::size_t>(cells.reference->nodes) - 1;
  const std::size_t entries = shift_entries(*cells.reference);
  const auto add = [&](std::size_t row, std::size_t column, const double *shift) {
    double *entry = K + lanes * lower(row, column);
    for (int lane = 0; lane < lanes; ++lane) entry[lane] += stiffness_ * shift[lane];
  };
  const double *shift = shifts_.data() + entries * lanes * static_cast<std::size_t>(first);
  for (PetscInt pack = 0; pack < count; ++pack, K += cells.entries() * lanes) {
    if (is_linear(*cells.reference)) {
      for (std::size_t row = 0; row < dim * modes; ++row) add(row, row, shift);
      shift += lanes;
      continue;
    }
    for (std::size_t k = 0; k < modes; ++k) {
      for (std::size_t l = 0; l <= k; ++l, shift += lanes) {
        for (std::size_t i = 0; i < dim; ++i) add(dim * k + i, dim * l + i, shift);
      }
    }
  }
}

std::vector<double> InertiaTerm::product(double factor, const std::vector<double> &w) const {
  std::vector<double> result(w.size(), 0);
  mass_->add_product(factor, w.data(), result.data());
  return result;
}

PetscErrorCode InertiaTerm::begin_step(const StepState &state) {
  const std::size_t size = mass_->mesh().coordinates.size();
  const double inertia = 1 / (state.inertia_time * state.inertia_time);
  const double damping = damping_ / state.velocity_time;
  PetscFunctionBeginUser;
  stiffness_ = inertia + damping;
  velocity_time_ = state.velocity_time;
  target_.resize(size);
  std::vector<double> drift(size);
  for (std::size_t k = 0; k < size; ++k) {
    target_[k] = (inertia * state.predicted[k] + damping * state.velocity_origin[k]) / stiffness_;
    drift[k] = target_[k] - state.velocity_origin[k];
  }
  drift_mass_ = product(1, drift);
  drift_square_ = dot(drift, drift_mass_);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InertiaTerm::add_energy(const double *u, EnergySums *sums) const {
  std::vector<double> w(target_.size());
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < w.size(); ++k) w[k] = u[k] - target_[k];
  const double square = dot(w, product(1, w));
  sums->energy += 0.5 * stiffness_ * square;
  // |u - velocity_origin|_M^2 / (2 c^2)
  sums->scale +=
      0.5 * (square + 2 * dot(w, drift_mass_) + drift_square_) / (velocity_time_ * velocity_time_);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InertiaTerm::add_energy_changes(const double *u, std::size_t size, int directions,
                                               const double *const *d, int points,
                                               const double *coefficients, double *changes) const {
  std::vector<double> w(size);
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < size; ++k) w[k] = u[k] - target_[k];
  add_quadratic_changes([this](const std::vector<double> &x) { return product(stiffness_, x); },
                        product(stiffness_, w), directions, d, points, coefficients, changes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InertiaTerm::add_gradient(const double *u, double *gradient) const {
  std::vector<double> w(target_.size());
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < w.size(); ++k) w[k] = u[k] - target_[k];
  mass_->add_product(stiffness_, w.data(), gradient);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InertiaTerm::add_hessian(const double *, StencilSink &sink) const {
  const Mesh &mesh = mass_->mesh();
  const auto nodes = static_cast<std::size_t>(mesh.nodes_per_cell());
  const auto dim = static_cast<std::size_t>(mesh.dimension());
  const std::size_t n = dim * nodes;
  std::vector<double> M(nodes * nodes), H(n * n);
  std::vector<PetscInt> dofs(n);
  PetscFunctionBeginUser;
  for (PetscInt cell = 0; cell < mesh.local_cells(); ++cell) {
    const PetscInt *node = &mesh.cells[nodes * static_cast<std::size_t>(cell)];
    mass_->of_cell(cell, M.data());
    for (std::size_t r = 0; r < n; ++r) {
      dofs[r] = 3 * node[r / dim] + static_cast<PetscInt>(r % dim);
      for (std::size_t c = r % dim; c < n; c += dim) H[n * r + c] = M[nodes * (r / dim) + c / dim];
    }
    PetscCall(sink.add({.n = static_cast<int>(n), .dofs = dofs.data(), .cell = cell}, H.data()));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

double InertiaTerm::bytes() const {
  return mass_->bytes() +
         static_cast<double>((shifts_.capacity() + target_.capacity() + drift_mass_.capacity()) *
                             sizeof(double));
}

}  // namespace trefoil
