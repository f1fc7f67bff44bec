#pragma once

#include <petscsys.h>

#include <memory>

namespace trefoil {

struct Mesh;
struct Tet4Packs;
class PackedElements;

/// Takes the dense Hessians of elements, one after the other: filters them and adds them up.
class ElementHessianSink {
 public:
  virtual ~ElementHessianSink() = default;
  /// @param n unknowns of the element
  /// @param dofs their local numbers, 3 * local vertex + component
  /// @param H the symmetric n x n element Hessian
  virtual PetscErrorCode add(int n, const PetscInt *dofs, const double *H) = 0;
  /// The same where the term has filtered the element itself.
  /// @param N its negative part
  /// @param negative how many eigenvalues it found negative; -1: not finite
  virtual PetscErrorCode add_split(int n, const PetscInt *dofs, const double *H, const double *N,
                                   int negative) = 0;
};

/// Sums over one rank's elements.
struct EnergySums {
  double energy = 0;     ///< sum of psi V
  double scale = 0;      ///< sum of |psi - psi(I)| V, or the work of a load: free of rest offsets
  double stiffness = 0;  ///< energy of a strain of order one: what rounding is small against
};

/// Energies that spread prescribed displacements over a body, see material/spreading.hpp.
enum class Spreading { harmonic, rigid };

/// One summand of a scene's energy. A scene lists its terms; a term it does not name is never made.
/// Displacements u and forces are local arrays, 3 numbers a local vertex, ghosts included.
class Term {
 public:
  virtual ~Term() = default;
  virtual void add_energy(const double *u, EnergySums *sums) const = 0;
  /// Adds f(u + sum_k c_k d_k) - f(u) to changes[p] for each of `points` rows c of coefficients,
  /// one for each of `directions` local arrays d. Many points at the price of one pass, where the
  /// term knows how; here one evaluation a point.
  virtual void add_energy_changes(const double *u, std::size_t size, int directions,
                                  const double *const *d, int points, const double *coefficients,
                                  double *changes) const;
  virtual void add_gradient(const double *u, double *gradient) const = 0;
  /// Whether the term has any: one that is linear in u does not.
  [[nodiscard]] virtual bool has_hessian() const { return true; }
  virtual PetscErrorCode add_hessian(const double *u, ElementHessianSink &sink) const = 0;
  /// The term's elements in packs, whose reduced Hessians reduced_hessians() makes in batches; null
  /// where it has no batched path.
  [[nodiscard]] virtual const Tet4Packs *packs() const { return nullptr; }
  /// Reduced Hessians of packs [first, first + count), see Tet4Kernels.
  virtual void reduced_hessians(PetscInt first, PetscInt count, const double *u, double *K) const {
    static_cast<void>(first), static_cast<void>(count), static_cast<void>(u), static_cast<void>(K);
  }
  /// The term's elements in packs of another kind than Tet4Packs; null where it has none.
  [[nodiscard]] virtual const PackedElements *packed_elements() const { return nullptr; }
  /// For output: fills, for each local cell, det F and psi; left alone by terms without cells.
  virtual void describe_cells(const double *u, double *determinant, double *energy_density) const {
    static_cast<void>(u), static_cast<void>(determinant), static_cast<void>(energy_density);
  }
  /// The same elements with an energy that spreads displacements; null for terms without elements.
  [[nodiscard]] virtual std::unique_ptr<Term> spreading(Spreading) const { return nullptr; }
  [[nodiscard]] virtual double bytes() const { return 0; }
};

}  // namespace trefoil
