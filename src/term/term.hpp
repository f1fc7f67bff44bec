#pragma once

#include <petscsys.h>

#include <memory>

#include "support/petsc_compatibility.hpp"
#include "term/packed_elements.hpp"
#include "term/stencil_sink.hpp"
#include "term/vertex_pairs.hpp"

namespace trefoil {

/// Sums over one rank's elements.
struct EnergySums {
  double energy = 0;         ///< what is minimised: 0 where body and loads are at rest
  double strain_energy = 0;  ///< of that, the sum of (psi - psi(I)) V
  double load_work = 0;      ///< and, subtracted from it, the work of the loads since rest
  double scale = 0;          ///< sum of |psi - psi(I)| V, and of the loads' work by vertices
};

/// A time step, as an integrator makes it of the states before it. Arrays hold 3 numbers for each
/// local vertex, held ones and ghosts included; they live until the step is accepted.
struct StepState {
  double time = 0;  ///< at the end of the step
  double step = 0;  ///< from its start to its end
  /// Inertia is the energy |u - predicted|_M^2 / (2 inertia_time^2).
  double inertia_time = 0;
  const double *predicted = nullptr;
  /// The velocity at the end is (u - velocity_origin) / velocity_time.
  double velocity_time = 0;
  const double *velocity_origin = nullptr;
};

/// How a term's Hessian comes about, and so the path by which it is assembled.
enum class HessianKind {
  none,      ///< it is zero: the term is linear in u
  constant,  ///< hessian_scale() times a matrix that depends on nothing in a solve, made once
  packed,    ///< of elements in packs, see batch()
  stencils   ///< of dense matrices, one after the other
};

/// By which weight w a term's Hessian H + 2 w N is filtered.
enum class FilterWeight {
  rule,  ///< the rule's
  clamp  ///< 1/2 where the rule filters at all: the negative part of a barrier is no stiffness
};

/// Energies that spread prescribed displacements over a body, see material/spreading.hpp.
enum class Spreading { harmonic, rigid };

/// One summand of a scene's energy. A scene lists its terms; a term it does not name is never made.
/// Displacements u and forces are local arrays, 3 numbers a local vertex, ghosts included. What a
/// term adds is this rank's part of a sum over all ranks. All functions that return an error code
/// are collective: every rank calls them, so that a term may talk to its other parts.
class Term {
 public:
  virtual ~Term() = default;

  virtual PetscErrorCode add_energy(const double *u, EnergySums *sums) const = 0;
  /// What reported energies have in addition: sum of psi(I) V.
  [[nodiscard]] virtual double rest_energy() const { return 0; }
  /// Sum over elements and nodes of k |g_a|^2 V, with the stiffness k of the material and the
  /// gradients g_a of the shape functions: displacements of size d without pattern have about this
  /// times d^2 of energy.
  [[nodiscard]] virtual double stiffness() const { return 0; }
  /// Adds f(u + sum_k c_k d_k) - f(u) to changes[p] for each of `points` rows c of coefficients,
  /// one for each of `directions` local arrays d. Many points at the price of one pass, where the
  /// term knows how; here one evaluation a point.
  virtual PetscErrorCode add_energy_changes(const double *u, std::size_t size, int directions,
                                            const double *const *d, int points,
                                            const double *coefficients, double *changes) const;
  virtual PetscErrorCode add_gradient(const double *u, double *gradient) const = 0;

  [[nodiscard]] virtual HessianKind hessian_kind() const = 0;
  /// The Hessian matrix by matrix, whatever its kind. For `packed` this is the slow path, for tests
  /// and for what has no batched one; `constant` ones are asked once and without their scale, and
  /// must be positive semi-definite, stencil by stencil.
  virtual PetscErrorCode add_hessian(const double *u, StencilSink &sink) const;
  /// The elements of a `packed` Hessian.
  [[nodiscard]] virtual const PackedElements *batch() const { return nullptr; }
  [[nodiscard]] virtual double hessian_scale() const { return 1; }
  /// Of a `constant` matrix: another number than before where it is another matrix.
  [[nodiscard]] virtual int hessian_version() const { return 0; }
  [[nodiscard]] virtual FilterWeight filter_weight() const { return FilterWeight::rule; }

  /// Whether the filter of the cells' elements has to see this term: an element of stiffness K and
  /// inertia S adds the negative part of K + S, although S itself enters H by this term's own path.
  [[nodiscard]] virtual bool shifts_filter() const { return false; }
  /// Adds S to the reduced matrices K of packs [first, first + count) of the cells. Of a mass
  /// matrix that mixes translations with the rest of an element, S is the Schur complement.
  virtual void shift_filter(const ElementPacks &cells, PetscInt first, PetscInt count,
                            double *K) const {
    static_cast<void>(cells), static_cast<void>(first), static_cast<void>(count);
    static_cast<void>(K);
  }

  /// Whether the term couples vertices without a common cell.
  [[nodiscard]] virtual bool couples_pairs() const { return false; }
  /// Chooses the pairs for a Hessian at u.
  /// @param changed whether pairs() are others than before, on any rank
  virtual PetscErrorCode choose_pairs(const double *u, bool *changed) {
    static_cast<void>(u), *changed = false;
    return PETSC_SUCCESS;
  }
  /// Appends this rank's pairs; one order of each is enough. Others may own the vertices.
  virtual void append_pairs(VertexPairs *pairs) const { static_cast<void>(pairs); }

  /// Loads and obstacles that move: sets the time of their formulas.
  virtual PetscErrorCode set_time(double time) {
    static_cast<void>(time);
    return PETSC_SUCCESS;
  }
  /// Before the solve of a time step; the state is the same for all solves until accept_step().
  virtual PetscErrorCode begin_step(const StepState &state) {
    static_cast<void>(state);
    return PETSC_SUCCESS;
  }
  /// After a solve whose result stands: what lags behind the displacements may follow.
  virtual PetscErrorCode accept_step(const double *u) {
    static_cast<void>(u);
    return PETSC_SUCCESS;
  }
  /// Whether steps u + a d may be too long for the term.
  [[nodiscard]] virtual bool limits_step() const { return false; }
  /// Lowers *largest to the largest step a that is allowed; steps up to `first` are wanted.
  virtual PetscErrorCode limit_step(const double *u, const double *d, double first,
                                    double *largest) const {
    static_cast<void>(u), static_cast<void>(d), static_cast<void>(first);
    static_cast<void>(largest);
    return PETSC_SUCCESS;
  }

  /// Whether the term's elements are the mesh's cells.
  [[nodiscard]] virtual bool has_cells() const { return false; }
  /// For output, of a term with cells: fills, for each local cell, det F and psi.
  virtual void describe_cells(const double *u, double *determinant, double *energy_density) const {
    static_cast<void>(u), static_cast<void>(determinant), static_cast<void>(energy_density);
  }
  /// The same elements with an energy that spreads displacements; null for terms without elements.
  [[nodiscard]] virtual std::unique_ptr<Term> spreading(Spreading) const { return nullptr; }
  [[nodiscard]] virtual double bytes() const { return 0; }
};

}  // namespace trefoil
