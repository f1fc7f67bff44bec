#include "term/pressure_term.hpp"

#include <array>
#include <cmath>

#include "term/facet_points.hpp"

namespace trefoil {
namespace {

using Vector = std::array<double, 3>;

Vector cross(const Vector &a, const Vector &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Vector &a, const Vector &b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector sum(const Vector &a, double s, const Vector &b) {
  return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}

/// What the swept volume needs at a point of quadrature. With A = a / 2 + p / 3, B = b / 2 + q / 3
/// its density is v = u . m, its derivative by the displacement of node c, whose shape function is
/// N with derivatives N1 and N2, is N m + N2 u x A + N1 B x u.
struct SweptPoint {
  Vector u{}, A{}, B{}, m{};
  Vector normal{};  ///< of the area where it is, as long as that is large
  double weight = 0;

  SweptPoint(const Mesh &mesh, const Facet &facet, int point, const double *displacements) {
    const FacetRule &rule = rule_of(facet);
    Vector a{}, b{}, p{}, q{};
    if (rule.dimension == 1) b = {0, 0, 1};  // an edge, and the direction out of the plane
    for (int c = 0; c < rule.nodes; ++c) {
      const auto first = static_cast<std::size_t>(3 * facet.begin()[c]);
      const double *N = rule.gradients[point][c];
      for (std::size_t i = 0; i < 3; ++i) {
        const double X = mesh.coordinates[first + i], moved = displacements[first + i];
        u[i] += rule.values[point][c] * moved;
        a[i] += N[0] * X, p[i] += N[0] * moved;
        if (rule.dimension == 2) b[i] += N[1] * X, q[i] += N[1] * moved;
      }
    }
    weight = rule.weights[point];
    const Vector zero{};
    normal = cross(sum(a, 1, p), sum(b, 1, q));
    A = sum(sum(zero, 0.5, a), 1. / 3, p);
    B = sum(sum(zero, 0.5, b), 1. / 3, q);
    m = sum(sum(sum(cross(a, b), 0.5, cross(a, q)), 0.5, cross(p, b)), 1. / 3, cross(p, q));
  }
};

/// Adds s [w]x, the matrix of w x, to the dim x dim block at `to` of a matrix with n columns.
void add_cross(const Vector &w, double s, int dim, int n, double *to) {
  if (dim == 3) {
    to[2] += s * w[1], to[n + 2] -= s * w[0];
    to[2 * n] -= s * w[1], to[2 * n + 1] += s * w[0];
  }
  to[1] -= s * w[2], to[n] += s * w[2];
}

/// Adds s times the second derivative of the swept volume at a point.
void add_second(const FacetRule &rule, int point, const SweptPoint &swept, double s, double *H) {
  const int dim = rule.dimension + 1, n = dim * rule.nodes;
  for (int c = 0; c < rule.nodes; ++c) {
    const double N = rule.values[point][c], *D = rule.gradients[point][c];
    for (int d = 0; d < rule.nodes; ++d) {
      const double M = rule.values[point][d], *E = rule.gradients[point][d];
      double *block = H + n * dim * c + dim * d;
      add_cross(swept.B, s * (D[0] * M - N * E[0]), dim, n, block);
      if (dim == 2) continue;
      add_cross(swept.A, s * (N * E[1] - D[1] * M), dim, n, block);
      add_cross(swept.u, s * (D[1] * E[0] - D[0] * E[1]) / 3, dim, n, block);
    }
  }
}

}  // namespace

PetscErrorCode PressureTerm::add_energy(const double *u, EnergySums *sums) const {
  PetscFunctionBeginUser;
  for (const Facet &facet : facets_) {
    double volume = 0;
    for (int k = 0; k < rule_of(facet).points; ++k) {
      const SweptPoint swept(mesh_, facet, k, u);
      volume += swept.weight * dot(swept.u, swept.m);
    }
    sums->energy += pressure_ * volume;
    sums->scale += std::abs(pressure_ * volume);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PressureTerm::add_gradient(const double *u, double *gradient) const {
  PetscFunctionBeginUser;
  for (const Facet &facet : facets_) {
    const FacetRule &rule = rule_of(facet);
    for (int k = 0; k < rule.points; ++k) {
      const SweptPoint swept(mesh_, facet, k, u);
      const Vector uA = cross(swept.u, swept.A), Bu = cross(swept.B, swept.u);
      const double s = pressure_ * swept.weight;
      for (int c = 0; c < rule.nodes; ++c) {
        const double N = rule.values[k][c], *D = rule.gradients[k][c];
        const double D1 = rule.dimension == 2 ? D[1] : 0;
        double *force = gradient + 3 * facet.begin()[c];
        for (int i = 0; i <= rule.dimension; ++i) {
          const auto j = static_cast<std::size_t>(i);
          force[i] += s * (N * swept.m[j] + D1 * uA[j] + D[0] * Bu[j]);
        }
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void PressureTerm::add_surface_force(const double *u, double *force) const {
  for (const Facet &facet : facets_) {
    const FacetRule &rule = rule_of(facet);
    for (int k = 0; k < rule.points; ++k) {
      const SweptPoint swept(mesh_, facet, k, u);
      const double s = -pressure_ * swept.weight;
      for (int c = 0; c < rule.nodes; ++c) {
        for (std::size_t i = 0; i < 3; ++i) {
          force[static_cast<std::size_t>(3 * facet.begin()[c]) + i] +=
              s * rule.values[k][c] * swept.normal[i];
        }
      }
    }
  }
}

PetscErrorCode PressureTerm::add_hessian(const double *u, StencilSink &sink) const {
  constexpr int most = 3 * FacetRule::most_nodes;
  std::array<double, most * most> H{};
  std::array<PetscInt, most> dofs{};
  PetscFunctionBeginUser;
  if (pressure_ == 0) PetscFunctionReturn(PETSC_SUCCESS);
  for (const Facet &facet : facets_) {
    const FacetRule &rule = rule_of(facet);
    const int dim = rule.dimension + 1;
    H.fill(0);
    for (int k = 0; k < rule.points; ++k) {
      const SweptPoint swept(mesh_, facet, k, u);
      add_second(rule, k, swept, pressure_ * swept.weight, H.data());
    }
    for (int k = 0; k < dim * rule.nodes; ++k) {
      dofs[static_cast<std::size_t>(k)] = 3 * facet.begin()[k / dim] + k % dim;
    }
    PetscCall(sink.add({.n = dim * rule.nodes, .dofs = dofs.data()}, H.data()));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
