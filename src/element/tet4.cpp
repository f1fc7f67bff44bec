#include "element/tet4.hpp"

namespace trefoil {

Tet4 Tet4::at_rest(const double (&corner)[4][3]) {
  // Columns of D are the edges from corner 0; rows of D^-1 are the gradients of corners 1 to 3,
  // D^-1 = cof(D)' / det D.
  Matrix3<double> D;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) D(i, j) = corner[j + 1][i] - corner[0][i];
  }
  const Matrix3<double> C = cofactor(D);
  const double det = determinant(D);
  Tet4 tet{};
  tet.volume = det / 6;
  for (int i = 0; i < 3; ++i) {
    for (int a = 1; a < 4; ++a) {
      tet.gradients[a][i] = C(i, a - 1) / det;
      tet.gradients[0][i] -= tet.gradients[a][i];
    }
  }
  return tet;
}

Matrix3<double> Tet4::deformation_gradient(const double *u) const {
  Matrix3<double> F;
  for (int i = 0; i < 3; ++i) {
    F(i, i) = 1;
    for (int j = 0; j < 3; ++j) {
      for (int a = 0; a < 4; ++a) F(i, j) += u[3 * a + i] * gradients[a][j];
    }
  }
  return F;
}

void Tet4::add_force(const Matrix3<double> &P, double *force) const {
  for (int a = 0; a < 4; ++a) {
    for (int i = 0; i < 3; ++i) {
      double sum = 0;
      for (int j = 0; j < 3; ++j) sum += P(i, j) * gradients[a][j];
      force[3 * a + i] += volume * sum;
    }
  }
}

void Tet4::hessian(const Tangent<double> &A, double *H) const {
  // First contraction: B[(ij),(b,k)] = V sum_l A[(ij),(kl)] g_b[l].
  double B[9][12];
  for (int p = 0; p < 9; ++p) {
    for (int b = 0; b < 4; ++b) {
      for (int k = 0; k < 3; ++k) {
        double sum = 0;
        for (int l = 0; l < 3; ++l) {
          sum += A[static_cast<std::size_t>(9 * p + 3 * k + l)] * gradients[b][l];
        }
        B[p][3 * b + k] = volume * sum;
      }
    }
  }
  for (int a = 0; a < 4; ++a) {
    for (int i = 0; i < 3; ++i) {
      for (int q = 0; q < 12; ++q) {
        double sum = 0;
        for (int j = 0; j < 3; ++j) sum += gradients[a][j] * B[3 * i + j][q];
        H[12 * (3 * a + i) + q] = sum;
      }
    }
  }
}

}  // namespace trefoil
