// The polar decomposition against LAPACK and its own definition, on matrices that are singular,
// inverted, nearly so, or have repeated singular values; alone and in packs.

#include "trefoil/polar.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "matrix3_support.hpp"

extern "C" void dgesvd_(const char *, const char *, const int *m, const int *n, double *A,
                        const int *lda, double *s, double *U, const int *ldu, double *V,
                        const int *ldv, double *work, const int *lwork, int *info);

namespace trefoil::test {
namespace {

/// By LAPACK, with the signs of the proper rotations: Matrix3 is row by row, so A' = V s U'.
SignedSvd<double> lapack_svd(const Matrix &F) {
  constexpr int three = 3, work_size = 64;
  int info = 0;
  double work[work_size];
  Matrix A = F;
  SignedSvd<double> svd;
  Matrix V, U;  // row by row: V' of LAPACK's first factor, which is V; and U
  dgesvd_("A", "A", &three, &three, A.entries.data(), &three, svd.stretch.data(), V.entries.data(),
          &three, U.entries.data(), &three, work, &work_size, &info);
  EXPECT_EQ(info, 0);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) svd.V(i, j) = V(j, i), svd.U(i, j) = U(i, j);
  for (Matrix *Q : {&svd.U, &svd.V}) {
    if (determinant(*Q) > 0) continue;
    for (int i = 0; i < 3; ++i) (*Q)(i, 2) = -(*Q)(i, 2);
    svd.stretch[2] = -svd.stretch[2];
  }
  return svd;
}

Matrix transpose(const Matrix &A) {
  Matrix B;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) B(i, j) = A(j, i);
  return B;
}

double distance(const Matrix &A, const Matrix &B) {
  return norm(along(A, -1, B));
}

struct Hard {
  std::string name;
  Matrix F;
};

/// Every combination of singular values of very different sizes, equal ones among them, either
/// sign, turned from both sides or from none; and matrices without structure.
std::vector<Hard> hard_set() {
  Random random(3);
  std::vector<Hard> set;
  const double values[] = {0, 1e-40, 1e-16, 1e-8, 1e-3, 0.5, 1, 1 + 1e-15, 1 + 1e-8, 2, 1e4};
  for (const double a : values)
    for (const double b : values)
      for (const double c : values) {
        const std::string name = std::to_string(a) + ' ' + std::to_string(b);
        for (const double sign : {1.0, -1.0}) {
          const Matrix D = diagonal(a, b, sign * c);
          set.push_back({name + " straight", D});
          set.push_back({name + " turned", random.rotation() * D * random.rotation()});
          set.push_back({name + " rotated", random.rotation() * D});
        }
      }
  for (int i = 0; i < 20000; ++i)
    set.push_back({"random " + std::to_string(i), random.matrix(std::pow(10, i % 9 - 4))});
  for (int i = 0; i < 2000;
       ++i) {  // symmetric and nearly diagonal, shear, and few distinct numbers
    Matrix F = diagonal(1, 1, 1);
    F(i % 3, (i + 1) % 3) = std::pow(10, random.uniform(-18, 3));
    set.push_back({"shear " + std::to_string(i), F});
    for (double &entry : F.entries) entry = std::round(random.uniform(-1.5, 1.5));
    set.push_back({"digits " + std::to_string(i), F});
  }
  return set;
}

void expect_decomposition(const Hard &hard, const SignedSvd<double> &svd) {
  const Matrix &F = hard.F;
  const auto &[U, V, s] = svd;
  const double size = norm(F);
  EXPECT_LE(distance(U * transpose(U), diagonal(1, 1, 1)), 1e-14) << hard.name;
  EXPECT_LE(distance(V * transpose(V), diagonal(1, 1, 1)), 1e-14) << hard.name;
  EXPECT_NEAR(determinant(U), 1, 1e-14) << hard.name;
  EXPECT_NEAR(determinant(V), 1, 1e-14) << hard.name;
  EXPECT_LE(distance(U * diagonal(s[0], s[1], s[2]) * transpose(V), F), 1e-14 * size) << hard.name;
  EXPECT_GE(s[0], s[1] - 1e-15 * size) << hard.name;
  EXPECT_GE(s[1], std::abs(s[2]) - 1e-15 * size) << hard.name;
}

TEST(PolarTest, DecomposesHardMatrices) {
  for (const Hard &hard : hard_set()) expect_decomposition(hard, signed_svd(hard.F));
}

TEST(PolarTest, StretchesAreLapacks) {
  for (const auto &[name, F] : hard_set()) {
    const SignedSvd<double> ours = signed_svd(F), lapack = lapack_svd(F);
    // The sign of a stretch that is zero to rounding is nobody's.
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(ours.stretch[k], lapack.stretch[k], 1e-14 * lapack.stretch[0]) << name;
  }
}

TEST(PolarTest, RotationIsLapacks) {
  for (const auto &[name, F] : hard_set()) {
    const SignedSvd<double> lapack = lapack_svd(F);
    const Matrix R = rotation_of(signed_svd(F));
    EXPECT_LE(distance(R * transpose(R), diagonal(1, 1, 1)), 1e-14) << name;
    EXPECT_NEAR(determinant(R), 1, 1e-14) << name;
    const Matrix S = transpose(R) * F;
    EXPECT_LE(distance(S, transpose(S)), 1e-14 * norm(F)) << name;
    // R is as well defined as the sum of the two smallest stretches is away from zero.
    const double gap = lapack.stretch[1] + lapack.stretch[2];
    if (gap <= 1e-12 * lapack.stretch[0]) continue;
    EXPECT_LE(distance(R, rotation_of(lapack)), 2e-14 * lapack.stretch[0] / gap) << name;
  }
}

/// Nearest is where the trace of R'F is greatest.
TEST(PolarTest, NoOtherRotationIsNearer) {
  Random random(4);
  for (const auto &[name, F] : hard_set()) {
    const double best = dot(rotation_of(signed_svd(F)), F);
    for (int i = 0; i < 3; ++i)
      EXPECT_LE(dot(random.rotation(), F), best + 1e-14 * norm(F)) << name;
  }
}

TEST(PolarTest, RotationOfARotationIsItself) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Matrix Q = random.rotation();
    EXPECT_LE(distance(rotation_of(signed_svd(Q)), Q), 1e-14);
  }
  EXPECT_EQ(distance(rotation_of(signed_svd(diagonal(1, 1, 1))), diagonal(1, 1, 1)), 0);
}

TEST(PolarTest, NotANumberStaysOne) {
  for (std::size_t k = 0; k < 9; ++k) {
    Matrix F = diagonal(1, 2, 3);
    F.entries[k] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(std::isnan(norm(rotation_of(signed_svd(F))))) << k;
  }
}

/// A lane's result is that of the matrix alone, whatever its neighbours need.
TEST(PolarTest, LanesAreIndependent) {
  using Real = Pack<InstructionSet::baseline>;
  const std::vector<Hard> set = hard_set();
  for (std::size_t first = 0; first + lanes <= set.size(); first += lanes) {
    Matrix3<Real> F;
    for (std::size_t k = 0; k < 9; ++k)
      for (int lane = 0; lane < lanes; ++lane)
        F.entries[k].v[lane] = set[first + static_cast<std::size_t>(lane)].F.entries[k];
    const SignedSvd<Real> packed = signed_svd(F);
    for (int lane = 0; lane < lanes; ++lane) {
      const Hard &hard = set[first + static_cast<std::size_t>(lane)];
      const SignedSvd<double> alone = signed_svd(hard.F);
      for (std::size_t k = 0; k < 9; ++k) {
        ASSERT_EQ(packed.U.entries[k].v[lane], alone.U.entries[k]) << hard.name;
        ASSERT_EQ(packed.V.entries[k].v[lane], alone.V.entries[k]) << hard.name;
      }
    }
  }
}

}  // namespace
}  // namespace trefoil::test
