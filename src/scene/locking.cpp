#include "scene/locking.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace trefoil {
namespace {

struct Measured {
  double poisson;
  double excess[2];  ///< of the stored energy, percent: triangles, tetrahedra
};

/// Linear elements, 8 cells an edge. The cube of tests/accuracy/incompressible.py against the
/// energy extrapolated there from Taylor and Hood's elements; a square that is held at two opposite
/// sides, one of them moved by half along both axes, against P2-P0 with 48 cells an edge.
constexpr Measured measured[] = {{0.46, {3.4, 8.5}},   {0.48, {4.4, 15}},   {0.49, {5.3, 25}},
                                 {0.495, {6.0, 40}},   {0.499, {7.9, 117}}, {0.4999, {11, 513}},
                                 {0.49999, {13, 2081}}};

/// How far two ratios are from each other, by what volume costs.
double distance(double one, double other) {
  return std::abs(std::log((0.5 - one) / (0.5 - other)));
}

}  // namespace

std::string warn_of_locking(int dimension, double poisson, bool has_contact) {
  const Measured &nearest = *std::min_element(
      std::begin(measured), std::end(measured), [&](const Measured &a, const Measured &b) {
        return distance(a.poisson, poisson) < distance(b.poisson, poisson);
      });
  std::ostringstream text;
  text << "linear elements lock at Poisson's ratio " << poisson
       << " (above 0.4545): the body is stiffer than it should be. At " << nearest.poisson << " a "
       << (dimension == 2 ? "sheared square" : "twisted cube") << " of 8 cells an edge stores "
       << nearest.excess[dimension - 2]
       << " % too much energy, and loads or irregular meshes are worse; "
       << (has_contact ? "contact is for linear elements alone: a ratio of 0.45 or less locks less"
                       : "-order 2 does not lock");
  return text.str();
}

}  // namespace trefoil
