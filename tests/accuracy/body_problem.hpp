#pragma once

// An elastic body on a mesh, with prescribed displacements and dead loads, solved by the plugin,
// and how far its solution is from a known one. For the accuracy tests.

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "assembly/energy_functional.hpp"
#include "element/reference_element.hpp"
#include "mesh/mesh.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/dead_load_term.hpp"
#include "term/elastic_term.hpp"

namespace trefoil::accuracy {

/// The displacement that is prescribed for component i at rest position p; nothing: it is free.
using Prescribed = std::function<std::optional<double>(const double *p, int i)>;
/// Three numbers at rest position p.
using VectorField = std::function<std::array<double, 3>(const double *p)>;
/// The deformation gradient at rest position p.
using TensorField = std::function<Matrix3<double>(const double *p)>;

/// A point of quadrature in a cell at rest, for errors and loads.
struct CellPoint {
  double position[3];
  double weight;  ///< volume it stands for
  double values[ReferenceElement::most_nodes];
  double gradients[ReferenceElement::most_nodes][3];
};

class Problem {
 public:
  Problem() = default;
  Problem(const Problem &) = delete;
  Problem &operator=(const Problem &) = delete;
  ~Problem();

  /// Collective.
  PetscErrorCode set_up(const CellList &whole, std::unique_ptr<MaterialModel> material,
                        const Prescribed &prescribed,
                        ElementPressure pressure = ElementPressure::pointwise);

  /// Adds the forces of a body force, per rest volume.
  void add_body_force(const VectorField &force);
  /// Adds a force of `total`, spread evenly over the edges of plane cells that lie in x = `x`.
  void add_edge_force(double x, const std::array<double, 2> &total);
  /// Multiplies all forces.
  void scale_forces(double factor);

  /// Minimises the energy from the present state. Collective; not converged is an error.
  PetscErrorCode solve(double energy_tolerance = 1e-14);
  /// Starts from a displacement. Collective.
  PetscErrorCode start_from(const VectorField &displacement);

  /// Displacements of the local vertices, 3 each. Collective.
  PetscErrorCode displacements(std::vector<double> *u) const;
  /// What the elements exert on their vertices, held ones included: 3 a local vertex.
  [[nodiscard]] std::vector<double> forces(const std::vector<double> &u) const;
  /// The elastic energy.
  [[nodiscard]] double elastic_energy(const std::vector<double> &u) const;
  /// The forces' work in the displacement u.
  [[nodiscard]] double work(const std::vector<double> &u) const;

  struct Errors {
    double L2 = 0, H1 = 0;  ///< of the displacement and of its gradient, relative to their norms
  };
  [[nodiscard]] Errors errors(const std::vector<double> &u, const VectorField &displacement,
                              const TensorField &gradient) const;

  /// Points of a rule of degree 7 or more in a cell.
  [[nodiscard]] std::vector<CellPoint> points(PetscInt cell) const;

  Mesh mesh;
  Discretization discretization;
  int iterations = 0;
  double solve_seconds = 0;

 private:
  PetscErrorCode solve_by(const char *filter, double energy_tolerance);

  std::vector<double> forces_;            ///< 3 a local vertex, this rank's contribution
  const ElasticTerm *elastic_ = nullptr;  ///< of the functional
  std::unique_ptr<EnergyFunctional> functional_;
  Mat H_ = nullptr;
  Vec x_ = nullptr;
};

}  // namespace trefoil::accuracy
