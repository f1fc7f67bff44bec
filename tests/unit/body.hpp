#pragma once

// An elastic body on a mesh, held as a test wants it, for the tests of assembly. Displacements are
// functions of the rest position, so that every distribution of the mesh has the same ones.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <memory>

#include "assembly/energy_functional.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/generate.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/elastic_term.hpp"

namespace trefoil::test {

/// Component i at rest position p.
using Field = std::function<double(const double *p, int i)>;
/// Whether component i is held at rest position p.
using Holding = std::function<bool(const double *p, int i)>;

inline bool nothing(const double *, int) {
  return false;
}
inline bool bottom(const double *p, int) {
  return p[2] < 1e-9;
}
/// The bottom wholly, the sides in x only.
inline bool bottom_and_sides(const double *p, int i) {
  return p[2] < 1e-9 || (i == 0 && (p[0] < 1e-9 || p[0] > 1 - 1e-9));
}

/// Noise that is the same for the same position, between -1 and 1.
inline double noise(const double *p, int i) {
  const double phase = 127.1 * p[0] + 311.7 * p[1] + 74.7 * p[2] + 1.3 * i;
  const double large = 43758.5453 * std::sin(phase);
  return 2 * (large - std::floor(large)) - 1;
}

/// A bend with noise of the size of the elements on it: some elements are inverted.
inline double crumpled(const double *p, int i) {
  return 0.1 * p[0] * p[(i + 1) % 3] + 0.12 * noise(p, i);
}
inline double at_rest(const double *, int) {
  return 0;
}

inline StableNeoHookean soft_material() {
  return StableNeoHookean({2.0, 0.4}, StableNeoHookean::Lame::physical);
}

/// Of which elements with a pressure of their own take most of the volume at its mean.
inline StableNeoHookean nearly_incompressible_material() {
  return StableNeoHookean({2.0, 0.49}, StableNeoHookean::Lame::physical);
}

struct Body {
  Mesh mesh;
  Discretization discretization;
  std::unique_ptr<EnergyFunctional> functional;
  HeldDofs held;

  /// Collective. Held components are moved as `moved` says.
  PetscErrorCode set_up(MPI_Comm comm, const CellList &whole, const Holding &holding,
                        const Field &moved = crumpled, FilterSpace space = FilterSpace::element,
                        ElementPressure pressure = ElementPressure::pointwise) {
    PetscFunctionBeginUser;
    PetscCall(distribute_mesh(comm, whole, "metis", 0, &mesh));
    held = nothing_held(mesh);
    for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
      const double *p = &mesh.coordinates[3 * v];
      for (int i = 0; i < mesh.dimension(); ++i) {
        const auto dof = 3 * v + static_cast<std::size_t>(i);
        held.held[dof] = holding(p, i);
        held.value[dof] = holding(p, i) ? moved(p, i) : 0;
      }
    }
    PetscCall(discretization.set_up(mesh, held));
    functional = std::make_unique<EnergyFunctional>(discretization);
    auto material = make_material_model(
        pressure == ElementPressure::constant ? nearly_incompressible_material() : soft_material());
    functional->add_term(std::make_unique<ElasticTerm>(mesh, std::move(material), space, pressure));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  /// A vector of unknowns with the values of a field. Collective.
  PetscErrorCode vector(const Field &field, Vec *x) const {
    PetscFunctionBeginUser;
    PetscCall(discretization.create_vector(x));
    for (std::size_t v = 0; v < mesh.owned.size(); ++v)
      for (int i = 0; mesh.owned[v] && i < 3; ++i) {
        const PetscInt dof = discretization.global_dofs()[3 * v + static_cast<std::size_t>(i)];
        if (dof >= 0)
          PetscCall(VecSetValue(*x, dof, field(&mesh.coordinates[3 * v], i), INSERT_VALUES));
      }
    PetscCall(VecAssemblyBegin(*x));
    PetscCall(VecAssemblyEnd(*x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};

struct Scene {
  const char *name, *mesh;
  PetscInt resolution;
  Holding holding;
  PetscInt block_size;  ///< of the matrix: 3 where vertices are wholly free or wholly held

  friend std::ostream &operator<<(std::ostream &stream, const Scene &scene) {
    return stream << scene.name;
  }
};

inline const std::vector<Scene> scenes{{"free_box", "box", 3, nothing, 3},
                                       {"box_on_its_bottom", "box", 3, bottom, 3},
                                       {"box_between_walls", "box", 3, bottom_and_sides, 1},
                                       {"knot", "knot", 1, bottom, 3}};

class SceneTest : public testing::TestWithParam<Scene> {
 protected:
  [[nodiscard]] static CellList mesh() {
    return generate_mesh(GetParam().mesh, GetParam().resolution, 0);
  }
  Body body_;
};

/// Owns what PETSc makes in a test.
template <class Object, PetscErrorCode (*destroy)(Object *)>
struct Owned {
  Object object = nullptr;
  Owned() = default;
  Owned(const Owned &) = delete;
  Owned &operator=(const Owned &) = delete;
  ~Owned() { static_cast<void>(destroy(&object)); }
  operator Object() const { return object; }
  Object *operator&() { return &object; }
};
using OwnedVec = Owned<Vec, VecDestroy>;
using OwnedMat = Owned<Mat, MatDestroy>;

}  // namespace trefoil::test
