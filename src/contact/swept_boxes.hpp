#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "contact/sorted_grid.hpp"
#include "contact/surface.hpp"

namespace trefoil::contact {

/// The boxes of primitives while their vertices go from x to x + share step; as seen by one who
/// moves along with the mean of the steps, which changes no distance: what falls together needs no
/// room.
class Sweep {
 public:
  /// @param step    may be empty: none
  /// @param margin  added on all sides
  Sweep(std::span<const double> x, std::span<const double> step, double share, double margin);

  [[nodiscard]] std::span<const double> x() const { return x_; }
  [[nodiscard]] std::span<const double> step() const { return step_; }
  [[nodiscard]] double share() const { return share_; }

  /// Of some vertices; numbers -1 are left out.
  template <std::size_t corners>
  [[nodiscard]] Box box_of(const std::array<int, corners> &vertices) const {
    Box box = empty_box();
    for (const int vertex : vertices) {
      if (vertex >= 0) extend(box, vertex);
    }
    return box;
  }

  void extend(Box &box, int vertex) const;
  static Box empty_box();

 private:
  std::span<const double> x_, step_;
  double share_, margin_;
  Vector3 mean_;  ///< of the steps
};

/// Primitives of one kind with their boxes.
struct SweptPrimitives {
  std::vector<int> index;  ///< ascending
  std::vector<Box> boxes;
};

/// The boxes that overlap `region`.
SweptPrimitives swept_vertices(const Surface &surface, const Sweep &sweep, const Box &region);
SweptPrimitives swept_edges(const Surface &surface, const Sweep &sweep, const Box &region);
SweptPrimitives swept_facets(const Surface &surface, const Sweep &sweep, const Box &region);

/// The box of all primitives that a rank owns; a part of each of its pairs lies in it. All of space
/// for rank -1.
Box region_of_rank(const Surface &surface, const Sweep &sweep, int rank);

}  // namespace trefoil::contact
