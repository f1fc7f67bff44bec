#pragma once

#include <memory>
#include <string>
#include <vector>

#include "trefoil/input_error.hpp"
#include "trefoil/material_model.hpp"

namespace trefoil {

/// Makes a material from what the user says; throws InputError where that makes none. A bare
/// pointer: the library it points into may be unloaded before this list goes.
using MaterialMaker = std::unique_ptr<MaterialModel> (*)(const MaterialParameters &,
                                                         InstructionSet);

/// Makes a material known by a name; a later one of the same name replaces it. Not thread-safe.
void register_material(const std::string &name, MaterialMaker maker);

/// The same for a class that meets the concept SceneMaterial. It may also have
/// - a member M::has_volume_term: it uses MaterialParameters::volume
/// - a member M::has_raw_constants: it uses MaterialParameters::lame
/// - a member M::has_second_invariant: it uses MaterialParameters::second_invariant
/// Without them a user who gives these is told so.
template <SceneMaterial M>
void register_material();

/// All names, in the order of registration, the library's own first.
std::vector<std::string> material_names();

/// A material by its name. InputError for an unknown name, which lists the known ones, or for
/// parameters that the material refuses.
std::unique_ptr<MaterialModel> make_material(
    const std::string &name, const MaterialParameters &parameters,
    InstructionSet instructions = chosen_instruction_set());

// ---- implementation of the template

/// Refuses parameters that a material would not look at.
void check_parameters(const std::string &name, const MaterialParameters &parameters,
                      bool has_volume_term, bool has_raw_constants, bool has_second_invariant);

/// Refuses an energy density that is not 0 at rest: at small strains it would have no digits left.
void check_rest(const std::string &name, const MaterialModel &model);

template <SceneMaterial M>
MaterialMaker maker_of() {
  return [](const MaterialParameters &parameters, InstructionSet instructions) {
    check_parameters(
        M::name, parameters, requires { M::has_volume_term; }, requires { M::has_raw_constants; },
        requires { M::has_second_invariant; });
    auto model = make_material_model(M(parameters), instructions);
    check_rest(M::name, *model);
    return model;
  };
}

template <SceneMaterial M>
void register_material() {
  register_material(M::name, maker_of<M>());
}

}  // namespace trefoil
