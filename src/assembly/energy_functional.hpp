#pragma once

#include <petscsnes.h>

#include <memory>
#include <vector>

#include "assembly/discretization.hpp"
#include "assembly/hessian_assembler.hpp"
#include "term/term.hpp"
#include "trefoil.h"

namespace trefoil {

/// The energy of a scene, a sum of terms on one discretization, as SNES wants it: objective,
/// gradient, and Hessian with its element-wise negative part.
class EnergyFunctional {
 public:
  EnergyFunctional(const EnergyFunctional &) = delete;
  EnergyFunctional &operator=(const EnergyFunctional &) = delete;
  explicit EnergyFunctional(const Discretization &discretization)
      : discretization_(discretization), hessian_(discretization, terms_) {}

  void add_term(std::unique_ptr<Term> term) { terms_.push_back(std::move(term)); }

  /// f(x) and its parts, less energy_at_rest(). Collective.
  PetscErrorCode energy(Vec x, EnergySums *sums) const;
  /// The size of the energy at x: EnergySums::scale, but no less than what rounding leaves any
  /// digits of. Collective.
  PetscErrorCode size_of_energy(Vec x, double *scale) const;
  /// f(x + sum_k c_k d_k) - f(x) at `points` rows c of coefficients, one for each of `directions`
  /// (one or two) vectors d. Collective.
  PetscErrorCode energy_changes(Vec x, PetscInt directions, const Vec d[], PetscInt points,
                                const PetscReal coefficients[], PetscReal changes[]) const;
  /// The sum of psi(I) V: a constant that reported energies have in addition. Collective.
  PetscErrorCode energy_at_rest(double *energy) const;
  /// The elements of the first term that has cells, in packs; null where there are none.
  [[nodiscard]] const PackedElements *cells() const;
  /// The gradient of f, for the unknowns. Collective.
  PetscErrorCode gradient(Vec x, Vec g) const;
  /// df/du of every vertex that this rank owns, held components as well, 3 a local vertex: where a
  /// component is held, the force that holds it. Collective.
  PetscErrorCode nodal_gradient(Vec x, std::vector<double> *gradient) const;
  /// H, and N in *negative (see TrefoilSplitJacobianFunction, whose contract this is). Where terms
  /// couple vertices without a common cell, H may get another pattern and *negative be made anew.
  /// Collective.
  PetscErrorCode hessian(Vec x, Mat H, Mat *negative, TrefoilSplitStatistics *statistics,
                         const HessianFilter &filter = {});

  /// H + 2 w N in H, at once: where hessian_has_product(). Collective.
  PetscErrorCode filtered_hessian(Vec x, Mat H, TrefoilSplitStatistics *statistics, double weight);
  /// Hp of the unfiltered Hessian where filtered_hessian() was last, element by element.
  /// Collective.
  PetscErrorCode multiply_by_hessian(Vec p, Vec Hp) const;
  /// Whether both can be done.
  [[nodiscard]] bool hessian_has_product() const { return hessian_.filters_at_once(); }

  /// The constant parts of H alone: in time the masses, as inertia and damping weigh them.
  /// Collective.
  PetscErrorCode constant_hessian(Mat P) { return hessian_.assemble_constants(P); }

  /// Sets the time of loads and of all else that moves. Collective.
  PetscErrorCode set_time(double time);
  /// Tells the terms of the time step that is to be solved. Collective.
  PetscErrorCode begin_step(const StepState &state);
  /// Tells them that x is its result. Collective.
  PetscErrorCode accept_step(Vec x);
  /// The largest step a <= first along d that all terms allow. Collective.
  PetscErrorCode largest_step(Vec x, Vec d, double first, double *largest) const;
  /// The farthest that a direction d takes any vertex: max |d_v|. Collective.
  PetscErrorCode largest_move(Vec d, double *largest) const;

  /// The same elements with energies that spread displacements. Shares what is prepared; this
  /// object must outlive it.
  [[nodiscard]] std::unique_ptr<EnergyFunctional> spreading(Spreading kind) const;

  /// For each local cell: det F, energy density and number of negative eigenvalues of its Hessian.
  struct CellReport {
    std::vector<double> determinant, energy_density, negative_eigenvalues;
  };
  /// @param counts_negative whether eigenvalues are counted, which takes a decomposition a cell
  PetscErrorCode describe_cells(Vec x, CellReport *report, bool counts_negative = true) const;
  /// Cells with det F <= 0, over all ranks. Collective.
  PetscErrorCode count_inverted(Vec x, PetscInt64 *inverted) const;

  /// How the Jacobian and its negative part are made.
  enum class Assembly {
    split,  ///< from a callback that makes H and N at once, in batches where a term has them
    plain,  ///< the same, one element at a time by LAPACK and MatSetValues: the slow reference
    hook    ///< from the plugin's watch on the Mat, as in a code that knows nothing of it
  };
  /// Finds the places of the elements in matrices like H, once, before the first Hessian; done
  /// there if not here. Collective.
  PetscErrorCode prepare(Mat H) { return hessian_.prepare(H); }

  /// Gives SNES the callbacks. Collective; this object must outlive the SNES.
  PetscErrorCode attach(SNES snes, Mat H, Assembly assembly);
  /// Lets it do without N, where that can be. After attach(). Collective.
  PetscErrorCode do_without_negative(SNES snes);

  [[nodiscard]] double bytes() const;

 private:
  const Discretization &discretization_;
  std::vector<std::unique_ptr<Term>> terms_;
  HessianAssembler hessian_;
  std::vector<double> filtered_at_;  ///< local displacements, see multiply_by_hessian()
};

}  // namespace trefoil
