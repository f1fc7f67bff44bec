#pragma once

#include <cmath>

#include "trefoil/pack.hpp"

namespace trefoil {

/// The basis Q of what the nodes of an element do less its translations, see ElementPacks.
template <int nodes, InstructionSet isa>
struct ElementModes {
  using Real = Pack<isa>;
  static constexpr int modes = nodes - 1;

  static double first_weight() { return 1 / std::sqrt(static_cast<double>(nodes)); }
  static double shared_weight() {
    const double s = first_weight();
    return s * s / (1 - s);
  }

  /// One component of all nodes to that of all modes: Q'x.
  static void reduce(const Real (&x)[nodes], Real (&reduced)[modes]) {
    Real sum = x[1];
    for (int a = 2; a < nodes; ++a) sum += x[a];
    const Real shift = first_weight() * x[0] - shared_weight() * sum;
    for (int k = 0; k < modes; ++k) reduced[k] = x[k + 1] + shift;
  }
  /// And back: Q y.
  static void expand(const Real (&reduced)[modes], Real (&x)[nodes]) {
    Real sum = reduced[0];
    for (int k = 1; k < modes; ++k) sum += reduced[k];
    x[0] = first_weight() * sum;
    const Real shift = shared_weight() * sum;
    for (int k = 0; k < modes; ++k) x[k + 1] = reduced[k] - shift;
  }
};

}  // namespace trefoil
