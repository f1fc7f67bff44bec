#pragma once

namespace trefoil {

/// The eigenvalue filter: the negative part of symmetric element matrices, as plain numbers.
///
/// An element Hessian `H` with eigenpairs (lambda, v) has the negative part
///     N = sum over lambda < 0 of |lambda| v v',
/// and its filtered Hessian is `H_w = H + 2 w N`: w = 0 is Newton, w = 1/2 clamps the negative
/// eigenvalues to zero [Teran et al. 2005], w = 1 takes their absolute values [Chen et al. 2024].

/// Largest matrix that split() takes: a hexahedron of 64 nodes in 3D.
inline constexpr int largest_element_matrix = 192;

enum class SplitStatus {
  ok,              ///< every N is right
  not_finite,      ///< a matrix holds NaN or Inf
  no_convergence,  ///< LAPACK found no eigenvalues of a finite matrix
  bad_size,        ///< n or batch out of range: nothing was computed
  out_of_memory    ///< no workspace: nothing was computed
};

/// What split() has to say of a whole batch.
struct SplitResult {
  SplitStatus status = SplitStatus::ok;  ///< what is wrong with matrix `first_bad`
  int first_bad = -1;                    ///< first matrix whose N is NaN; -1: none
  long indefinite = 0;                   ///< how many matrices have a negative eigenvalue
};

/// The accuracy contract of this room, relative to the spectral norm of an n x n matrix.
[[nodiscard]] constexpr double split_accuracy(int n) {
  return n <= 30 ? 1e-13 : n * 1e-15;
}

/// Negative parts N of a batch of symmetric matrices H, each on its own.
///
/// Only the symmetric part (H + H')/2 matters, as it does to the quadratic form u'Hu; both
/// triangles are read. N is symmetric to the last bit, its error is below split_accuracy(n) ||H||.
/// An eigenvalue is negative only if lambda < -n eps max|lambda|: the rounding noise in the null
/// space of a semi-definite element (its rigid translations) is no indefiniteness. Without negative
/// eigenvalues N is exactly zero. Magnitudes do not matter: 2^k H gives 2^k N, from subnormal
/// numbers up to where N itself overflows, which takes entries of H above DBL_MAX / n.
///
/// A matrix with NaN or Inf, or that LAPACK fails on, gets an N full of NaN and the count -1; the
/// others of the batch are not affected. Thread-safe; keeps one workspace a thread, so that
/// only the first call with a larger n allocates.
///
/// @param n         rows of each matrix, 1 to largest_element_matrix
/// @param batch     number of matrices, >= 0
/// @param H         batch x n x n, one matrix after the other
/// @param N         batch x n x n, written; may not overlap H
/// @param negative  batch, written: number of negative eigenvalues; may be null
[[nodiscard]] SplitResult split(int n, int batch, const double *H, double *N,
                                int *negative) noexcept;

/// A floor under the eigenvalues of filtered matrices.
struct EigenvalueFloor {
  double share = 0;   ///< of the matrix's largest |lambda|; 0: no floor
  double weight = 1;  ///< w > 0 of the H + 2 w N that is to keep to it
};

/// split() with N such that the eigenvalues of H + 2 w N are max(|lambda|', share max|lambda|),
/// with |lambda|' what the weight alone makes of them: (2 w - 1) |lambda| of a negative one, lambda
/// of a positive one. w = 1/2 is clamping to an epsilon, w = 1 the filter of Paternain, Mokhtari
/// and Ribeiro 2019, "A Newton-based method for nonconvex optimization with fast evasion of saddle
/// points". Eigenvalues that are zero to rounding are left so: they are rigid motions. `negative`
/// and the result count the eigenvalues and matrices that change.
[[nodiscard]] SplitResult split_with_floor(int n, int batch, const double *H, double *N,
                                           int *negative, const EigenvalueFloor &floor) noexcept;

/// Whether the symmetric part of one n x n matrix is proven to have no eigenvalue below
/// -split_accuracy(n) ||H||. Much cheaper than its eigenvalues.
///
/// "False" proves nothing: the matrix is indefinite, too close to it to tell, not finite, or of a
/// bad size. Singular semi-definite elements mostly pass. Source: a Cholesky factorisation that
/// runs to its end bounds the smallest eigenvalue from below [Higham, Accuracy and Stability of
/// Numerical Algorithms, 2002, Theorem 10.3].
[[nodiscard]] bool is_positive_semidefinite(int n, const double *H) noexcept;

}  // namespace trefoil
