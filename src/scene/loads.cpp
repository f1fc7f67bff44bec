#include "scene/loads.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "element/isoparametric_element.hpp"
#include "scene/load_formula.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/dead_load_term.hpp"
#include "term/facet_points.hpp"
#include "term/foundation_term.hpp"
#include "term/pressure_term.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

using Point = std::array<double, 3>;

/// Adds a force per area at a point of a facet, by the shape functions there.
void spread(const Point &force, const FacetPoint &point, const Facet &facet,
            std::vector<double> &forces) {
  for (int a = 0; a < facet.count(); ++a) {
    const auto first = static_cast<std::size_t>(3 * facet.begin()[a]);
    for (std::size_t i = 0; i < 3; ++i)
      forces[first + i] += force[i] * point.area * point.values[a];
  }
}

/// rho g over a cell, integrated with the shape functions. Throws InputError.
void add_weight(const Mesh &mesh, const LoadFormula &gravity, const PetscInt *cell, double density,
                double time, std::vector<double> &forces) {
  const ReferenceElement &reference = reference_element(mesh.dimension(), mesh.nodes_per_cell());
  double positions[3 * ReferenceElement::most_nodes];
  for (int a = 0; a < reference.nodes; ++a) {
    std::copy_n(&mesh.coordinates[static_cast<std::size_t>(3 * cell[a])], 3, positions + 3 * a);
  }
  const IsoparametricElement element(reference, positions);
  for (int q = 0; q < reference.points; ++q) {
    Point at{};
    for (int a = 0; a < reference.nodes; ++a) {
      for (std::size_t i = 0; i < 3; ++i) {
        at[i] += reference.values[q][a] * positions[3 * static_cast<std::size_t>(a) + i];
      }
    }
    const Point g = gravity.vector(at, time);
    for (int a = 0; a < reference.nodes; ++a) {
      for (std::size_t i = 0; i < 3; ++i) {
        forces[static_cast<std::size_t>(3 * cell[a]) + i] +=
            density * g[i] * element.weight(q) * reference.values[q][a];
      }
    }
  }
}

}  // namespace

PetscErrorCode Loads::choose(const Mesh &mesh, const LoadsOptions &options, double where_tolerance,
                             std::vector<double> density_of_cell) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  mesh_ = &mesh;
  options_ = options;
  density_of_cell_ = std::move(density_of_cell);
  if (!options.gravity.empty()) {
    double densest = 0;
    for (const double density : density_of_cell_) densest = std::max(densest, density);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &densest, 1, MPI_DOUBLE, MPI_MAX, comm));
    PetscCheck(densest > 0, comm, PETSC_ERR_USER_INPUT,
               "-load_gravity pulls at nothing: give the body a -material_density");
  }
  const double tolerance = where_tolerance * box_of(mesh).diagonal();
  for (const LoadOptions &load : options.loads) {
    Chosen chosen{load, {load.where, load.group, "-load_" + load.name, tolerance}, {}, false};
    PetscCall(depends_on_time(mesh, chosen.choice, &chosen.moves));
    if (!chosen.moves) PetscCall(choose_facets_of(&chosen, 1));
    if (chosen.facets.nearly > 0) {
      warnings_.push_back(warn_of_rest(chosen.choice, chosen.facets.nearly, "facets"));
    }
    PetscCall(check_potentials(chosen));
    chosen_.push_back(std::move(chosen));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Refuses what has no potential.
PetscErrorCode Loads::check_potentials(const Chosen &load) const {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  const char *name = load.options.name.c_str();
  bool uses_place = false;
  PetscFunctionBeginUser;
  if (!load.options.follower && load.options.spring.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!load.moves, comm, PETSC_ERR_USER_INPUT,
             "-load_%s_where depends on t, and %s must stay where it is", name,
             load.options.follower ? "a pressure that follows the body" : "a spring");
  const std::string complaint = complaint_of([&] {
    if (!load.options.follower) return;
    const std::string option = "-load_" + load.options.name + "_pressure";
    uses_place = Expression(load.options.pressure, option, box_of(*mesh_)).uses_place();
  });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscCheck(!uses_place, comm, PETSC_ERR_USER_INPUT,
             "-load_%s_pressure is '%s'; a pressure that follows the body has a potential only "
             "where it is the same on all facets: let it depend on t alone, or leave out "
             "-load_%s_follower",
             name, load.options.pressure.c_str(), name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<Support> Loads::supports() const {
  std::vector<Support> supports;
  for (const Chosen &load : chosen_) {
    if (load.options.spring.empty()) continue;
    for (const Facet &facet : load.facets.facets) {
      for (const FacetPoint &point : points_of_facet(*mesh_, facet)) {
        for (const PetscInt vertex : facet) {
          if (load.options.spring_normal) supports.push_back({vertex, point.normal});
          if (load.options.spring_normal) continue;
          supports.push_back({vertex, {1, 0, 0}});
          supports.push_back({vertex, {0, 1, 0}});
          supports.push_back({vertex, {0, 0, 1}});
        }
      }
    }
  }
  return supports;
}

bool Loads::any_follows() const {
  return std::any_of(chosen_.begin(), chosen_.end(),
                     [](const Chosen &load) { return load.options.follower; });
}

std::unique_ptr<PressureTerm> Loads::make_pressure(const Chosen &load) const {
  const auto formula = std::make_shared<LoadFormula>(*mesh_, load.options.pressure,
                                                     "-load_" + load.options.name + "_pressure",
                                                     !load.moves && !options_.is_in_time);
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  return std::make_unique<PressureTerm>(
      *mesh_, load.facets.facets, [formula, comm](double time, double *pressure) {
        PetscFunctionBeginUser;
        const std::string complaint =
            complaint_of([&] { *pressure = formula->scalar(Point{}, time); });
        PetscCall(agree_on_complaint(comm, complaint));
        PetscFunctionReturn(PETSC_SUCCESS);
      });
}

std::unique_ptr<Term> Loads::make_springs(const Chosen &load) const {
  const std::string option = "-load_" + load.options.name + "_spring";
  const bool grows = false;
  const auto formula = std::make_shared<LoadFormula>(*mesh_, load.options.spring, option, grows);
  return std::make_unique<FoundationTerm>(
      *mesh_, load.facets.facets,
      load.options.spring_normal ? FoundationTerm::Along::normal
                                 : FoundationTerm::Along::all_directions,
      [formula, option](const Point &at, double time) {
        const double stiffness = formula->scalar(at, time);
        if (stiffness < 0) throw InputError(option + ": a spring's stiffness must not be negative");
        return stiffness;
      });
}

std::vector<std::unique_ptr<Term>> Loads::make_terms() {
  std::vector<std::unique_ptr<Term>> terms;
  bool any_dead = !options_.gravity.empty();
  for (Chosen &load : chosen_) {
    const LoadOptions &options = load.options;
    any_dead = any_dead || !options.traction.empty() || !options.force.empty() ||
               (!options.pressure.empty() && !options.follower);
    if (options.follower) {
      auto pressure = make_pressure(load);
      load.follower = pressure.get();
      terms.push_back(std::move(pressure));
    }
    if (!options.spring.empty()) {
      terms.push_back(make_springs(load));
      load.springs = terms.back().get();
    }
  }
  if (any_dead) {
    terms.push_back(std::make_unique<DeadLoadTerm>(
        [this](double time, std::vector<double> *all) { return forces(time, all); }));
  }
  return terms;
}

PetscErrorCode Loads::choose_facets_of(Chosen *load, double time) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  PetscFunctionBeginUser;
  PetscCall(choose_facets(*mesh_, load->choice, time, &load->facets));
  PetscCheck(load->facets.count > 0, comm, PETSC_ERR_USER_INPUT,
             "load '%s' takes no facet of the surface: %s%s", load->options.name.c_str(),
             load->choice.text().c_str(),
             load->choice.where.empty() ? ""
             : mesh_->dimension() == 3  ? ", which must hold at all three corners"
                                        : ", which must hold at both ends");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Loads::add_load(Chosen &load, double time, std::vector<double> *forces) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  const std::string option = "-load_" + load.options.name + "_";
  const bool grows = !load.moves && !options_.is_in_time;
  PetscFunctionBeginUser;
  if (load.moves) PetscCall(choose_facets_of(&load, time));
  const std::string complaint = complaint_of([&] {
    const auto on_each_point = [&](auto force_per_area) {
      for (const Facet &facet : load.facets.facets) {
        for (const FacetPoint &point : points_of_facet(*mesh_, facet)) {
          spread(force_per_area(point), point, facet, *forces);
        }
      }
    };
    if (!load.options.traction.empty()) {
      const LoadFormula traction(*mesh_, load.options.traction, option + "traction", grows);
      on_each_point([&](const FacetPoint &point) { return traction.vector(point.position, time); });
    }
    if (!load.options.force.empty()) {
      const LoadFormula total(*mesh_, load.options.force, option + "force", grows);
      on_each_point([&](const FacetPoint &point) {
        Point force = total.vector(point.position, time);
        for (double &component : force) component /= load.facets.area;
        return force;
      });
    }
    if (!load.options.pressure.empty() && !load.options.follower) {
      const LoadFormula pressure(*mesh_, load.options.pressure, option + "pressure", grows);
      on_each_point([&](const FacetPoint &point) {
        const double p = pressure.scalar(point.position, time);
        return Point{-p * point.normal[0], -p * point.normal[1], -p * point.normal[2]};
      });
    }
  });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Loads::add_gravity(double time, std::vector<double> *forces) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  PetscFunctionBeginUser;
  const std::string complaint = complaint_of([&] {
    const LoadFormula gravity(*mesh_, options_.gravity, "-load_gravity", !options_.is_in_time);
    for (std::size_t c = 0; c < density_of_cell_.size(); ++c) {
      const PetscInt *cell = &mesh_->cells[static_cast<std::size_t>(mesh_->nodes_per_cell()) * c];
      add_weight(*mesh_, gravity, cell, density_of_cell_[c], time, *forces);
    }
  });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Loads::forces(double time, std::vector<double> *forces) {
  PetscFunctionBeginUser;
  forces->assign(mesh_->coordinates.size(), 0);
  if (!options_.gravity.empty()) PetscCall(add_gravity(time, forces));
  for (Chosen &load : chosen_) PetscCall(add_load(load, time, forces));
  PetscCall(sum_at_owners(*mesh_, forces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
