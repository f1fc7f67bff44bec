#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "mesh/mesh.hpp"

namespace trefoil {

/// What tells a mesh from others, however it is distributed: what its elements are, how many
/// vertices and cells it has, which vertices each cell has, and where they are at rest.
struct MeshFingerprint {
  std::string element;
  PetscInt vertices = 0, cells = 0;
  std::uint64_t connectivity = 0;       ///< a hash
  std::array<double, 3> coordinates{};  ///< sums of them, each vertex with a weight of its own
  double size = 0;  ///< the same of their absolute values: sums are the same within rounding of it

  /// Collective.
  PetscErrorCode take(const Mesh &mesh);
  [[nodiscard]] nlohmann::ordered_json json() const;
  /// One sentence's end, what is another in a file's fingerprint, or nothing.
  [[nodiscard]] std::string difference(const nlohmann::ordered_json &other) const;
};

}  // namespace trefoil
