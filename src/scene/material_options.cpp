#include "scene/material_options.hpp"

#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr double largest = 1e300;

/// E and nu, or mu and lambda: two numbers, and not one of each pair.
PetscErrorCode set_constants(MPI_Comm comm, const std::string &prefix, const MaterialInput &input,
                             ElasticConstants *constants) {
  const char *name = prefix.c_str();
  PetscFunctionBeginUser;
  if (input.mu || input.lambda) {
    PetscCheck(input.mu && input.lambda && !input.young && !input.poisson, comm,
               PETSC_ERR_USER_INPUT,
               "give -%s_young and -%s_poisson, or -%s_mu and -%s_lambda, not parts of both", name,
               name, name, name);
    const double mu = *input.mu, lambda = *input.lambda;
    PetscCheck(mu > 0 && mu < largest, comm, PETSC_ERR_USER_INPUT,
               "-%s_mu is %g; the shear modulus must be positive", name, mu);
    PetscCheck(lambda > -2 * mu / 3 && lambda < largest, comm, PETSC_ERR_USER_INPUT,
               "-%s_lambda is %g; it must lie above -2/3 of -%s_mu, %g", name, lambda, name, mu);
    *constants = ElasticConstants::from_lame(mu, lambda);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  constants->young = input.young.value_or(constants->young);
  constants->poisson = input.poisson.value_or(constants->poisson);
  PetscCheck(constants->young > 0 && constants->young < largest, comm, PETSC_ERR_USER_INPUT,
             "-%s_young is %g; Young's modulus must be positive", name, constants->young);
  PetscCheck(constants->poisson > -1 && constants->poisson < 0.5, comm, PETSC_ERR_USER_INPUT,
             "-%s_poisson is %g; Poisson's ratio must lie above -1 and below 0.5", name,
             constants->poisson);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_parameters(MPI_Comm comm, const std::string &prefix, const MaterialInput &input,
                              MaterialParameters *parameters) {
  PetscFunctionBeginUser;
  PetscCall(set_constants(comm, prefix, input, &parameters->constants));
  parameters->lame = input.lame == "raw" ? Lame::raw : Lame::physical;
  PetscCheck(parameters->lame == Lame::physical || parameters->constants.poisson > 0, comm,
             PETSC_ERR_USER_INPUT, "-%s_lame raw needs a positive Poisson's ratio, not %g",
             prefix.c_str(), parameters->constants.poisson);
  parameters->volume = input.volume;
  parameters->second_invariant = input.second_invariant;
  const double second_invariant = parameters->second_invariant.value_or(0);
  PetscCheck(second_invariant >= 0 && second_invariant <= 1, comm, PETSC_ERR_USER_INPUT,
             "-%s_second_invariant is %g; it must lie between 0 and 1", prefix.c_str(),
             second_invariant);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What is handed on to a region that does not say it; constants as set_constants() knows them.
MaterialInput defaults_of(const MaterialOptions &options) {
  const MaterialParameters &parameters = options.parameters;
  MaterialInput input;
  input.model = options.model;
  if (parameters.lame == Lame::raw) input.lame = "raw";
  input.volume = parameters.volume;
  input.second_invariant = parameters.second_invariant;
  return input;
}

}  // namespace

std::vector<OptionRow> material_rows(const std::string &prefix, MaterialInput &input) {
  const char *pressure = "force per area";
  return {
      {prefix + "_model", &input.model, "Energy density of strain", "", material_names(), true},
      {prefix + "_young", &input.young, "Young's modulus E (1e6)", pressure, {}, true},
      {prefix + "_poisson", &input.poisson, "Poisson's ratio nu (0.45)", "", {}, true},
      {prefix + "_mu", &input.mu, "Instead: shear modulus", pressure},
      {prefix + "_lambda", &input.lambda, "Instead: Lame's first constant", pressure},
      {prefix + "_lame",
       &input.lame,
       "E and nu of small strains, or the paper's raw constants",
       "",
       {"physical", "raw"}},
      {prefix + "_volume", &input.volume, "Weight kappa of the volume term kappa/2 (J-1)^2",
       pressure},
      {prefix + "_second_invariant", &input.second_invariant,
       "Mooney-Rivlin: its part of the shear modulus, 0 to 1 (0.5)"},
      {prefix + "_density",
       &input.density,
       "Density rho, for gravity (0)",
       "mass per rest volume",
       {},
       true},
  };
}

PetscErrorCode read_material(MPI_Comm comm, OptionReader &reader, const std::string &prefix,
                             MaterialOptions *options) {
  MaterialInput input = defaults_of(*options);
  PetscBool model_given = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(reader.read(material_rows(prefix, input).front()));
  if (input.model != options->model) {  // what only some models know is not handed on to another
    input.volume.reset();
    input.second_invariant.reset();
    input.lame = "physical";
  }
  PetscCall(reader.read(material_rows(prefix, input)));
  PetscCall(PetscOptionsHasName(nullptr, nullptr, ("-" + prefix + "_model").c_str(), &model_given));
  options->is_named =
      options->is_named || model_given || input.young || input.poisson || input.mu || input.lambda;
  options->model = input.model;
  options->density = input.density.value_or(options->density);
  PetscCall(set_parameters(comm, prefix, input, &options->parameters));
  PetscCheck(options->density >= 0 && options->density < largest, comm, PETSC_ERR_USER_INPUT,
             "-%s_density is %g; it must not be negative", prefix.c_str(), options->density);
  // The material says what it cannot be made of, here and not where the mesh has been read.
  const std::string complaint = complaint_of([&] { make_material(*options); });
  const std::string option = "-" + prefix + "_model " + options->model + ": ";
  PetscCall(agree_on_complaint(comm, complaint.empty() ? "" : option + complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Lame's constants lambda and mu of small strains about rest.
static std::array<double, 2> lame_at_rest(const MaterialOptions &options) {
  const Matrix3<double> at_rest;  // H = 0
  Tangent<double> A;              // dP_ij/dF_kl at 9 (3 i + j) + 3 k + l
  make_material(options)->tangent(at_rest, A);
  return {A[9 * 0 + 4], A[9 * 1 + 1]};
}

bool is_nearly_incompressible(const MaterialOptions &options) {
  const auto [lambda, mu] = lame_at_rest(options);
  return lambda > 10 * mu;
}

double poisson_at_rest(const MaterialOptions &options) {
  const auto [lambda, mu] = lame_at_rest(options);
  return lambda / (2 * (lambda + mu));
}

std::unique_ptr<MaterialModel> make_material(const MaterialOptions &options) {
  return make_material(options.model, options.parameters);
}

}  // namespace trefoil
