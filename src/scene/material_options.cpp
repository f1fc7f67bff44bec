#include "scene/material_options.hpp"

#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

std::string names_of_models() {
  std::string list;
  for (const std::string &name : material_names()) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// E and nu, or mu and lambda: two numbers, and not one of each pair.
PetscErrorCode read_constants(MPI_Comm comm, OptionReader &reader, const std::string &option,
                              ElasticConstants *constants) {
  std::optional<double> young, poisson, mu, lambda;
  PetscFunctionBeginUser;
  PetscCall(reader.number(option + "_young", "Young's modulus, force per area (1e6)", &young));
  PetscCall(reader.number(option + "_poisson", "Poisson's ratio (0.45)", &poisson));
  PetscCall(reader.number(option + "_mu", "Instead: shear modulus, force per area", &mu));
  PetscCall(reader.number(option + "_lambda", "Instead: Lame's first constant", &lambda));
  const char *name = option.c_str();
  if (mu || lambda) {
    PetscCheck(mu && lambda && !young && !poisson, comm, PETSC_ERR_USER_INPUT,
               "give -%s_young and -%s_poisson, or -%s_mu and -%s_lambda, not parts of both", name,
               name, name, name);
    PetscCheck(*mu > 0 && *mu < 1e300, comm, PETSC_ERR_USER_INPUT,
               "-%s_mu is %g; the shear modulus must be positive", name, *mu);
    PetscCheck(*lambda > -2 * *mu / 3 && *lambda < 1e300, comm, PETSC_ERR_USER_INPUT,
               "-%s_lambda is %g; it must lie above -2/3 of -%s_mu, %g", name, *lambda, name, *mu);
    *constants = ElasticConstants::from_lame(*mu, *lambda);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  constants->young = young.value_or(constants->young);
  constants->poisson = poisson.value_or(constants->poisson);
  PetscCheck(constants->young > 0 && constants->young < 1e300, comm, PETSC_ERR_USER_INPUT,
             "-%s_young is %g; Young's modulus must be positive", name, constants->young);
  PetscCheck(constants->poisson > -1 && constants->poisson < 0.5, comm, PETSC_ERR_USER_INPUT,
             "-%s_poisson is %g; Poisson's ratio must lie above -1 and below 0.5", name,
             constants->poisson);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode read_lame(MPI_Comm comm, OptionReader &reader, const std::string &option,
                         MaterialParameters *parameters) {
  std::string lame = parameters->lame == Lame::raw ? "raw" : "physical";
  PetscFunctionBeginUser;
  PetscCall(reader.text(option + "_lame",
                        "physical: E and nu of small strains; raw: the paper's constants", &lame));
  PetscCheck(lame == "physical" || lame == "raw", comm, PETSC_ERR_USER_INPUT,
             "-%s_lame knows no '%s'; it knows: physical, raw", option.c_str(), lame.c_str());
  parameters->lame = lame == "raw" ? Lame::raw : Lame::physical;
  PetscCheck(parameters->lame == Lame::physical || parameters->constants.poisson > 0, comm,
             PETSC_ERR_USER_INPUT, "-%s_lame raw needs a positive Poisson's ratio, not %g",
             option.c_str(), parameters->constants.poisson);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode read_material(MPI_Comm comm, OptionReader &reader, const std::string &prefix,
                             MaterialOptions *options) {
  MaterialParameters &parameters = options->parameters;
  PetscFunctionBeginUser;
  const std::string model = options->model;
  PetscCall(reader.text(prefix + "_model", names_of_models(), &options->model));
  if (options->model != model) {  // what only some models know is not handed on to another
    parameters.volume.reset();
    parameters.second_invariant.reset();
    parameters.lame = Lame::physical;
  }
  PetscCall(read_constants(comm, reader, prefix, &parameters.constants));
  PetscCall(read_lame(comm, reader, prefix, &parameters));
  PetscCall(reader.number(prefix + "_volume",
                          "Weight kappa of the volume term kappa/2 (J-1)^2, force per area",
                          &parameters.volume));
  PetscCall(reader.number(prefix + "_second_invariant",
                          "Mooney-Rivlin: its part of the shear modulus, 0 to 1 (0.5)",
                          &parameters.second_invariant));
  PetscCall(reader.number(prefix + "_density", "Mass per rest volume", &options->density));
  const double second_invariant = parameters.second_invariant.value_or(0);
  PetscCheck(second_invariant >= 0 && second_invariant <= 1, comm, PETSC_ERR_USER_INPUT,
             "-%s_second_invariant is %g; it must lie between 0 and 1", prefix.c_str(),
             second_invariant);
  PetscCheck(options->density >= 0 && options->density < 1e300, comm, PETSC_ERR_USER_INPUT,
             "-%s_density is %g; it must not be negative", prefix.c_str(), options->density);
  // The material says what it cannot be made of, here and not where the mesh has been read.
  const std::string complaint = complaint_of([&] { make_material(*options); });
  const std::string option = "-" + prefix + "_model " + options->model + ": ";
  PetscCall(agree_on_complaint(comm, complaint.empty() ? "" : option + complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool is_nearly_incompressible(const MaterialOptions &options) {
  Matrix3<double> identity;
  for (int i = 0; i < 3; ++i) identity(i, i) = 1;
  Tangent<double> A;  // dP_ij/dF_kl at 9 (3 i + j) + 3 k + l
  make_material(options)->tangent(identity, A);
  const double lambda = A[9 * 0 + 4], mu = A[9 * 1 + 1];
  return lambda > 10 * mu;
}

std::unique_ptr<MaterialModel> make_material(const MaterialOptions &options) {
  return make_material(options.model, options.parameters);
}

}  // namespace trefoil
