#include "trefoil/material_registry.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <tuple>
#include <utility>

#include "material/material_list.hpp"

namespace trefoil {
namespace {

using Entry = std::pair<std::string, MaterialMaker>;

template <class... M>
std::vector<Entry> entries_of(std::tuple<M...> *) {
  return {{M::name, maker_of<M>()}...};
}

/// All materials; the library's own come first, whoever registers others before they are used.
std::vector<Entry> &entries() {
  static std::vector<Entry> list = entries_of(static_cast<SceneMaterials *>(nullptr));
  return list;
}

auto find(const std::string &name) {
  return std::find_if(entries().begin(), entries().end(),
                      [&](const Entry &each) { return each.first == name; });
}

std::string with_number(const char *before, double number, const char *after) {
  std::ostringstream text;
  text << before << number << after;
  return text.str();
}

}  // namespace

void register_material(const std::string &name, MaterialMaker maker) {
  const auto found = find(name);
  if (found != entries().end()) {
    found->second = maker;
  } else {
    entries().emplace_back(name, maker);
  }
}

std::vector<std::string> material_names() {
  std::vector<std::string> names;
  for (const Entry &entry : entries()) names.push_back(entry.first);
  return names;
}

std::unique_ptr<MaterialModel> make_material(const std::string &name,
                                             const MaterialParameters &parameters,
                                             InstructionSet instructions) {
  const auto found = find(name);
  if (found != entries().end()) return found->second(parameters, instructions);
  std::string list;
  for (const Entry &entry : entries()) list += (list.empty() ? "" : ", ") + entry.first;
  throw InputError("there is no material model '" + name + "'; there are: " + list);
}

void check_parameters(const std::string &name, const MaterialParameters &parameters,
                      bool has_volume_term, bool has_raw_constants, bool has_second_invariant) {
  if (parameters.volume && !has_volume_term) {
    throw InputError("material model " + name +
                     " has no volume term of its own weight; leave `volume` out");
  }
  if (parameters.lame == Lame::raw && !has_raw_constants) {
    throw InputError("material model " + name +
                     " knows no raw constants; leave `lame` out or make it physical");
  }
  if (parameters.second_invariant && !has_second_invariant) {
    throw InputError("material model " + name +
                     " has no term in the second invariant; leave `second_invariant` out");
  }
}

void check_rest(const std::string &name, const MaterialModel &model) {
  const Matrix3<double> at_rest;
  Tangent<double> A;
  double stiffness = 0;
  model.tangent(at_rest, A);
  for (std::size_t p = 0; p < 9; ++p) stiffness += std::abs(A[10 * p]);
  const double energy_density = model.energy_density(at_rest);
  if (std::abs(energy_density) <= 1e-14 * stiffness) return;
  throw InputError(with_number(("material model " + name + " has the energy density ").c_str(),
                               energy_density,
                               " at rest, where it must be 0; leave that out of energy_density() "
                               "and return it from rest_energy_density()"));
}

double MaterialParameters::volume_weight(const std::string &material, double suggested) const {
  const double weight = volume.value_or(suggested);
  if (weight >= 0) return weight;
  throw InputError(with_number(
      ("material model " + material + " would have a volume term of weight ").c_str(), weight,
      ", with which its energy has no least value; give a larger "
      "Poisson's ratio, or a `volume` that is not negative"));
}

double MaterialParameters::nonnegative_lambda(const std::string &material) const {
  const double lambda = constants.lambda();
  if (lambda >= 0) return lambda;
  throw InputError("material model " + material +
                   " has no least energy with a negative Poisson's ratio; choose another model");
}

}  // namespace trefoil
