#pragma once

#include <memory>
#include <string>
#include <vector>

#include "input/selection.hpp"
#include "mesh/mesh.hpp"
#include "output/run_report.hpp"
#include "scene/scene_options.hpp"
#include "scene/support.hpp"
#include "term/pressure_term.hpp"

namespace trefoil {

/// What pulls at a body: gravity, and loads on parts of its surface. Formulas that do not depend on
/// t are scaled by it: at t = 1, where a scene is solved unless in steps, they are what they say;
/// the stiffness of springs is not scaled. In time
/// nothing is.
class Loads {
 public:
  /// Chooses the facets at rest. Collective; `mesh` must outlive this. Errors, one sentence on all
  /// ranks: a malformed formula, a load that takes no facet, gravity on a body without mass.
  /// @param density_of_cell mass per rest volume of each local cell
  /// @param where_tolerance share of the box's diagonal, see Choice
  PetscErrorCode choose(const Mesh &mesh, const LoadsOptions &options, double where_tolerance,
                        std::vector<double> density_of_cell);

  [[nodiscard]] bool any() const { return !options_.gravity.empty() || !chosen_.empty(); }

  /// Where springs hold the body, this rank's.
  [[nodiscard]] std::vector<Support> supports() const;
  /// Whether a pressure follows the body.
  [[nodiscard]] bool any_follows() const;

  /// The terms of the energy, which must live as long as this: dead forces in one, follower
  /// pressures and springs one each. Once, after choose().
  std::vector<std::unique_ptr<Term>> make_terms();

  /// The dead forces at time t on the vertices that this rank owns, 3 a local vertex. Collective; a
  /// malformed formula is an error with one sentence on all ranks.
  PetscErrorCode forces(double time, std::vector<double> *forces);

  /// Whether dead forces that are written in t do not grow about in proportion to it. Facets that
  /// move with t are left out. Collective.
  PetscErrorCode have_own_way(bool *own);

  /// Counts and areas, and with them force and moment at time t on the body displaced by u, 3 a
  /// local vertex. Collective.
  PetscErrorCode report(double time, const double *u, std::vector<LoadReport> *reports);

  /// The work of the loads at time t on displacements u, with which they enter the energy: of dead
  /// forces sum f.u, else what the potential falls short of rest. Collective.
  PetscErrorCode work(double time, const double *u, double *work);

  /// Adds what the forces of pressures that follow the body are more than the gradients of their
  /// potentials, at the vertices of rims; owned vertices, 3 a local one. Collective.
  PetscErrorCode add_at_rims(const double *u, std::vector<double> *gradient) const;

  /// What rims that are free make of pressures that follow the body: the forces that only their
  /// potentials have there, as a share of the pressures' own, both summed over vertices and
  /// directions without their signs; 0 without such a pressure. `dofs` are negative where the body
  /// is held. Collective.
  PetscErrorCode share_of_loose_rims(const double *u, const std::vector<PetscInt> &dofs,
                                     double *share) const;

  /// Sentences about choices that the tolerance would change.
  [[nodiscard]] const std::vector<std::string> &warnings() const { return warnings_; }

 private:
  struct Chosen {
    LoadOptions options;
    Choice choice;
    ChosenFacets facets;
    bool moves = false;  ///< `where` depends on t
    const PressureTerm *follower = nullptr;
    const Term *springs = nullptr;
  };

  [[nodiscard]] bool are_written_in_time() const;
  PetscErrorCode choose_facets_of(Chosen *load, double time);
  PetscErrorCode check_potentials(const Chosen &load) const;
  std::unique_ptr<PressureTerm> make_pressure(const Chosen &load) const;
  std::unique_ptr<Term> make_springs(const Chosen &load) const;
  PetscErrorCode add_load(Chosen &load, double time, std::vector<double> *forces);
  PetscErrorCode add_gravity(double time, std::vector<double> *forces);
  PetscErrorCode resultant(const std::vector<double> &forces, const double *u,
                           Resultant *resultant) const;

  const Mesh *mesh_ = nullptr;
  LoadsOptions options_;
  std::vector<Chosen> chosen_;
  std::vector<double> density_of_cell_;
  std::vector<std::string> warnings_;
};

}  // namespace trefoil
