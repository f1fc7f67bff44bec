#include "solve/force_balance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "input/selection.hpp"
#include "mesh/boundary.hpp"
#include "scene/body_materials.hpp"
#include "scene/state_report.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

// Measured: a thin plate that is stretched has 1e-4 of what acts on its vertices for a resultant,
// and 3e-5 left where its pressure is not converged; right solves, of twisted cubes, leave up to
// 2e-5.
constexpr double least_share_of_vertices = 2e-3;

double length(const std::array<double, 3> &vector) {
  return std::hypot(vector[0], vector[1], vector[2]);
}

/// The largest force, or moment about the box's centre over the box's diagonal.
double largest_resultant(const Scene &scene, const StateReport &state) {
  const Box box = box_of(scene.mesh);
  double largest = 0;
  for (const auto *resultants : {&state.reactions, &state.loads}) {
    for (const Resultant &each : *resultants) {
      std::array<double, 3> moment = each.moment;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, l = (i + 2) % 3;
        moment[i] -= (box.low[j] + box.high[j]) / 2 * each.force[l] -
                     (box.low[l] + box.high[l]) / 2 * each.force[j];
      }
      largest = std::max({largest, length(each.force), length(moment) / box.diagonal()});
    }
  }
  return largest;
}

/// The sum over vertices of the sizes of the forces that cells exert on them. Collective.
PetscErrorCode add_up_sizes(const Scene &scene, double *sum) {
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  std::vector<double> forces(scene.mesh.coordinates.size(), 0);
  PetscFunctionBeginUser;
  PetscCall(scene.discretization.get_local(scene.displacement, &local, &u));
  PetscCall(scene.elastic->add_gradient(u, forces.data()));
  PetscCall(scene.discretization.restore_local(&local, &u));
  PetscCall(sum_at_owners(scene.mesh, &forces));
  *sum = 0;
  for (std::size_t k = 0; k < forces.size(); k += 3) {
    *sum += std::hypot(forces[k], forces[k + 1], forces[k + 2]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode find_force_balance(const Scene &scene, const StateReport &state,
                                  ForceBalance *balance) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
  std::vector<double> forces;
  double sums[4] = {};
  PetscFunctionBeginUser;
  PetscCall(add_up_sizes(scene, &sums[3]));
  PetscCall(scene.functional->nodal_gradient(scene.displacement, &forces));
  const std::vector<double> held = held_part(scene, forces);
  for (std::size_t k = 0; k < forces.size(); ++k) sums[k % 3] += forces[k] - held[k];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, comm));
  const double scale = std::max(largest_resultant(scene, state), least_share_of_vertices * sums[3]);
  balance->left = length({sums[0], sums[1], sums[2]});
  balance->share = scale > 0 ? balance->left / scale : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::string warn_of_imbalance(const Scene &scene, const ForceBalance &balance) {
  constexpr double tolerated = 0.01;
  std::ostringstream text;
  if (balance.share <= tolerated) return "";
  text << "reactions and loads are out of balance by " << std::setprecision(3) << balance.left
       << ": "
       << (is_nearly_incompressible(scene.options)
               ? "the pressure of a nearly incompressible material, which the energy hardly tells, "
                 "is not converged"
               : "the solve has ended early")
       << "; take a smaller tolerance, -snes_trefoil_energy_tolerance 1e-12";
  return text.str();
}

}  // namespace trefoil
