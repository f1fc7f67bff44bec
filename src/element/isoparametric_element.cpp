#include "element/isoparametric_element.hpp"

#include <algorithm>

namespace trefoil {

IsoparametricElement::IsoparametricElement(const ReferenceElement &reference,
                                           const double *positions)
    : reference_(reference) {
  const int dim = reference.dimension;
  for (int q = 0; q < reference.points; ++q) {
    // J(i, j) = d(position i) / d(reference j); in the plane the third direction is left as it is.
    Matrix3<double> J;
    if (dim == 2) J(2, 2) = 1;
    for (int i = 0; i < dim; ++i) {
      for (int j = 0; j < dim; ++j) {
        for (int a = 0; a < reference.nodes; ++a) {
          J(i, j) += positions[3 * a + i] * reference.gradients[q][a][j];
        }
      }
    }
    // J^-1 = cof(J)' / det J.
    const Matrix3<double> C = cofactor(J);
    const double det = determinant(J);
    weights_[q] = det * reference.volume / reference.points;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) inverses_[q](j, i) = C(i, j) / det;
    }
    for (int a = 0; a < reference.nodes; ++a) {
      for (int i = 0; i < dim; ++i) {
        for (int j = 0; j < dim; ++j) {
          gradients_[q][a][i] += reference.gradients[q][a][j] * inverses_[q](j, i);
        }
      }
    }
  }
}

double IsoparametricElement::least_jacobian() const {
  const double weight = reference_.volume / reference_.points;
  return *std::min_element(weights_, weights_ + reference_.points) / weight;
}

Matrix3<double> IsoparametricElement::displacement_gradient(int q, const double *u) const {
  Matrix3<double> H;
  for (int i = 0; i < reference_.dimension; ++i) {
    for (int j = 0; j < reference_.dimension; ++j) {
      for (int a = 0; a < reference_.nodes; ++a) H(i, j) += u[3 * a + i] * gradients_[q][a][j];
    }
  }
  return H;
}

void IsoparametricElement::add_force(int q, const Matrix3<double> &P, double *force) const {
  for (int a = 0; a < reference_.nodes; ++a) {
    for (int i = 0; i < reference_.dimension; ++i) {
      for (int j = 0; j < reference_.dimension; ++j) {
        force[3 * a + i] += weights_[q] * P(i, j) * gradients_[q][a][j];
      }
    }
  }
}

void IsoparametricElement::add_hessian(int q, const Tangent<double> &A, double *H) const {
  const int dim = reference_.dimension, nodes = reference_.nodes, rows = dim * nodes;
  for (int b = 0; b < nodes; ++b) {
    for (int k = 0; k < dim; ++k) {
      double B[9];  // w sum_l dP_ij/dF_kl g_b[l]
      for (int p = 0; p < 9; ++p) {
        B[p] = 0;
        for (int l = 0; l < dim; ++l) {
          B[p] +=
              weights_[q] * A[static_cast<std::size_t>(9 * p + 3 * k + l)] * gradients_[q][b][l];
        }
      }
      for (int a = 0; a < nodes; ++a) {
        for (int i = 0; i < dim; ++i) {
          for (int j = 0; j < dim; ++j) {
            H[rows * (dim * a + i) + dim * b + k] += gradients_[q][a][j] * B[3 * i + j];
          }
        }
      }
    }
  }
}

}  // namespace trefoil
