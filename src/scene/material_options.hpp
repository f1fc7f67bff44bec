#pragma once

#include <petscsys.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "input/option_table.hpp"
#include "trefoil/material_registry.hpp"

namespace trefoil {

/// A material as the user describes it.
struct MaterialOptions {
  std::string model = "stable_neo_hookean";
  MaterialParameters parameters{{1e6, 0.45}};
  double density = 0;     ///< mass per rest volume; for gravity
  bool is_named = false;  ///< whether the user says what it is, be it a part
};

/// What the options say of a material, before it is known whether they make one.
struct MaterialInput {
  std::string model, lame = "physical";
  std::optional<double> young, poisson, mu, lambda, volume, second_invariant, density;
};

/// The options -PREFIX_model, _young, _poisson or _mu, _lambda, and the rest.
std::vector<OptionRow> material_rows(const std::string &prefix, MaterialInput &input);

/// Reads them, each with what `options` has as its default. Values out of range, and what no
/// material can be made of, are errors with one sentence on all ranks. Collective.
PetscErrorCode read_material(MPI_Comm comm, OptionReader &reader, const std::string &prefix,
                             MaterialOptions *options);

/// Whether Lame's constants at rest have lambda > 10 mu, a Poisson's ratio above 0.4545.
bool is_nearly_incompressible(const MaterialOptions &options);

/// Poisson's ratio of small strains about rest.
double poisson_at_rest(const MaterialOptions &options);

/// The material; read_material() has made sure that there is one.
std::unique_ptr<MaterialModel> make_material(const MaterialOptions &options);

}  // namespace trefoil
