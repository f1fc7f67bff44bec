#pragma once

// The materials that the tests go through, and deformations of every kind.

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "../../examples/own_material/own_material.cpp"  // a user's passes the same tests
#include "material/material_list.hpp"
#include "matrix3_support.hpp"
#include "trefoil/polar.hpp"

namespace trefoil::test {

/// How far F is, by its stretches, from where psi is not smooth.
using Room = double (*)(const std::array<double, 3> &stretch);

inline double endless(const std::array<double, 3> &) {
  return std::numeric_limits<double>::infinity();
}
/// For energies that are infinite where J <= 0.
inline double to_inversion(const std::array<double, 3> &stretch) {
  return stretch[2];
}
/// For energies of the rotation, which jumps where two stretches cancel.
inline double to_jump_of_rotation(const std::array<double, 3> &stretch) {
  return stretch[1] + stretch[2];
}

/// `volume` in units of Young's modulus, where a case gives it.
constexpr double given_volume = 0.7;

struct Candidate {
  const char *name;
  std::function<AnyMaterial(const ElasticConstants &)> make;
  std::function<double(const ElasticConstants &)> small_strain_lambda;
  Room room;
  double least_poisson;  ///< what the material takes, inclusive
  bool obeys_young_and_poisson = true;
};

template <class M>
AnyMaterial make(const ElasticConstants &constants) {
  return AnyMaterial(M(MaterialParameters{constants}));
}

/// With the weight of the volume term given.
template <class M>
AnyMaterial make_with_volume(const ElasticConstants &constants) {
  return AnyMaterial(M(MaterialParameters{constants, given_volume * constants.young}));
}

/// Mooney-Rivlin with all of the shear modulus from one invariant.
template <int second_invariant>
AnyMaterial make_mooney_rivlin(const ElasticConstants &constants) {
  return AnyMaterial(
      MooneyRivlin(MaterialParameters{constants, {}, Lame::physical, second_invariant}));
}

inline double hookes_lambda(const ElasticConstants &constants) {
  return constants.lambda();
}
inline double lambda_of_volume(const ElasticConstants &constants) {
  return given_volume * constants.young;
}

// At rest the raw energy has lambda (1 - alpha) = -mu in front of d cof/dF, whose entry (ij, kl) is
// delta_ij delta_kl - delta_il delta_jk: that takes mu from lambda, and gives the shear its
// symmetry.
inline const std::vector<Candidate> materials{
    {"stable_neo_hookean", make<StableNeoHookean>, hookes_lambda, endless, -0.5},
    {"stable_neo_hookean_raw",
     [](const ElasticConstants &c) { return AnyMaterial(StableNeoHookean(c, Lame::raw)); },
     [](const ElasticConstants &c) { return c.lambda() - c.mu(); }, endless, 0.01, false},
    {"neo_hookean", make<NeoHookean>, hookes_lambda, to_inversion, 0},
    {"mooney_rivlin", make<MooneyRivlin>, hookes_lambda, endless, -0.49},
    {"mooney_rivlin_first", make_mooney_rivlin<0>, hookes_lambda, endless, -0.5},
    {"mooney_rivlin_second", make_mooney_rivlin<1>, hookes_lambda, endless, 0},
    {"mooney_rivlin_volume", make_with_volume<MooneyRivlin>,
     [](const ElasticConstants &c) { return lambda_of_volume(c) - c.mu() / 2; }, endless, -0.5,
     false},
    {"arap", make<Arap>, hookes_lambda, to_jump_of_rotation, 0},
    {"arap_volume", make_with_volume<Arap>, lambda_of_volume, to_jump_of_rotation, -0.5, false},
    {"symmetric_dirichlet", make<SymmetricDirichlet>, hookes_lambda, to_inversion, 0},
    {"symmetric_dirichlet_volume", make_with_volume<SymmetricDirichlet>, lambda_of_volume,
     to_inversion, -0.5, false},
    {"corotated", make<Corotated>, hookes_lambda, to_jump_of_rotation, -0.5},
    {"own_material", make<Mine>, hookes_lambda, endless, -0.5},
    {"st_venant_kirchhoff", make<StVenantKirchhoff>, hookes_lambda, endless, -0.5},
};

struct State {
  std::string name;
  Matrix F;
  double step;  ///< small for F, whatever its size, and for the room around it
};

/// Deformations of every kind that leave a material room: by their singular values, the last one
/// negative where inverted; and random ones.
inline std::vector<State> all_states(Room room) {
  struct Kind {
    const char *name;
    double a, b, c;
  };
  const Kind kinds[] = {{"rest", 1, 1, 1},
                        {"uniform", 2, 2, 2},
                        {"two equal", 0.7, 0.7, 1.6},
                        {"two nearly equal", 0.7, 0.7 + 1e-9, 1.6},
                        {"generic", 1.4, 0.9, 0.6},
                        {"flattened", 2, 1, 0.02},
                        {"nearly singular", 1.2, 0.8, 1e-8},
                        {"singular", 1.2, 0.8, 0},
                        {"line", 1.5, 0, 0},
                        {"point", 0, 0, 0},
                        {"inverted", 1.3, 0.8, -.5},
                        {"nearly cancelling", 1.3, 0.8, -.79},
                        {"reflected", 1, 1, -1},
                        {"inside out", -1, -1, -1},
                        {"thread", 1e3, 1, 1},
                        {"sheet", 1e3, 1e3, 1e-8},
                        {"huge", 1e4, 1e4, 1e4},
                        {"huge inverted", 300, 2, -40}};
  Random random(1);
  std::vector<State> list;
  const auto add = [&](const std::string &name, const Matrix &F) {
    const double distance = room(signed_svd(F).stretch);
    if (distance < 1e-3) return;
    const double size = std::max(1.0, std::cbrt(std::abs(determinant(F))));
    list.push_back({name, F, 1e-3 * std::min(size, distance)});
  };
  for (const Kind &kind : kinds) {
    const Matrix D = diagonal(kind.a, kind.b, kind.c);
    add(kind.name, D);
    add(std::string(kind.name) + ", rotated", random.rotation() * D);
    add(std::string(kind.name) + ", turned", random.rotation() * D * random.rotation());
  }
  for (int i = 0; i < 40; ++i) add("random " + std::to_string(i), random.matrix(1.5));
  return list;
}

struct Case {
  Candidate candidate;
  ElasticConstants constants;

  [[nodiscard]] AnyMaterial material() const { return candidate.make(constants); }
  [[nodiscard]] std::vector<State> states() const { return all_states(candidate.room); }
  [[nodiscard]] double small_strain_lambda() const {
    return candidate.small_strain_lambda(constants);
  }

  friend std::ostream &operator<<(std::ostream &stream, const Case &each) {
    return stream << each.candidate.name << " nu " << each.constants.poisson;
  }
};

inline std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const Candidate &candidate : materials)
    for (const double poisson : {-0.5, 0.0, 0.05, 0.2, 0.3, 0.45, 0.495, 0.4999})
      if (poisson >= candidate.least_poisson) cases.push_back({candidate, {3.0, poisson}});
  return cases;
}

inline std::string case_name(const testing::TestParamInfo<Case> &info) {
  const int poisson = static_cast<int>(std::lround(1e4 * info.param.constants.poisson));
  return std::string(info.param.candidate.name) + (poisson < 0 ? "_nu_minus_" : "_nu_") +
         std::to_string(std::abs(poisson));
}

}  // namespace trefoil::test
