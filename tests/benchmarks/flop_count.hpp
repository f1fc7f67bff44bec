#pragma once

// Floating-point operations of the kernels, an element. The material's are counted by running it
// with numbers that count; the others follow from the loops in src/element and src/filter.

#include "filter/reduced_filter.hpp"
#include "trefoil/material.hpp"

namespace trefoil {

/// A number that counts what is done with it.
struct Counted {
  double value = 0;
  static inline long operations = 0;

  Counted() = default;
  Counted(double x) : value(x) {}
  friend Counted operator+(Counted a, Counted b) { return ++operations, a.value + b.value; }
  friend Counted operator-(Counted a, Counted b) { return ++operations, a.value - b.value; }
  friend Counted operator*(Counted a, Counted b) { return ++operations, a.value * b.value; }
  friend Counted operator-(Counted a) { return -a.value; }
  friend Counted operator/(Counted a, Counted b) { return ++operations, a.value / b.value; }
  Counted &operator+=(Counted b) { return *this = *this + b; }
  friend bool operator<(Counted a, Counted b) { return a.value < b.value; }
  friend bool operator>(Counted a, Counted b) { return a.value > b.value; }
  friend Counted select(bool where, Counted a, Counted b) { return where ? a : b; }
};

template <class Work>
double count_operations(Work work) {
  Counted::operations = 0;
  work();
  return static_cast<double>(Counted::operations);
}

struct FlopCount {
  double energy, forces, hessian;
  double add;  ///< expansion, sums, and additions to the matrix

  template <class M>
  FlopCount(const M &material, double pairs_per_element) {
    const Matrix3<Counted> H;
    Tangent<Counted> A;
    const double gradient = 3 * (8 + 3 + 3 * 5);  // H of the corners' displacements
    energy =
        gradient + 5 + count_operations([&] { (void)material.energy_density(Deformation(H)); });
    forces = gradient + 3 * (3 * 7 + 4 * 3) +
             count_operations([&] { (void)material.stress(Deformation(H)); });
    hessian =
        gradient + 81 * 6 + 45 * 5 + count_operations([&] { material.tangent(Deformation(H), A); });
    add = 9 * (3 * (3 + 6) + 4 * 6) + 10 * 9 + 18 * pairs_per_element;
  }

  /// What the exact filter cannot do without, given the mean number of negative eigenvalues of the
  /// indefinite elements: LDL' of all; of the indefinite ones the tridiagonal form, and for each
  /// negative eigenvalue four steps of Laguerre, its vector, and the rank-one sum.
  static double filter(double indefinite_share, double negative_eigenvalues) {
    constexpr double n = reduced_rows;
    const double tridiagonal = 4 * n * n * n / 3, laguerre_step = 14 * n;
    const double each = 4 * laguerre_step + 6 * n + 2 * n * n + n * (n + 1);
    return n * n * n / 3 + indefinite_share * (tridiagonal + negative_eigenvalues * each);
  }
};

}  // namespace trefoil
