#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "contact/candidates.hpp"

namespace trefoil::contact {

/// The contact energy B = sum over pairs of kappa w m b(d): the barrier b of their distance, the
/// mollifier m of near-parallel edges, rest areas w, and the stiffness kappa of the softer partner.
struct ContactLaw {
  double distance = 0;    ///< dhat: no force beyond it
  double stiffening = 1;  ///< times kappa, where a run needed more
};

/// kappa w of a pair, Pa m^2 (in the plane Pa m): the area is a quarter of a vertex's, or of the
/// sum of two edges'; in the plane half of a vertex's length. Each place of a surface meets the
/// other twice, by vertices of either side, and in space once more by edges [Li et al. 2023,
/// "Convergent incremental potential contact"]. An obstacle's area counts for no more than that of
/// what it touches: it may be a floor of two triangles.
double pair_stiffness(const Surface &surface, const ContactPair &pair);

/// lambda = kappa w m |b'| of a pair nearer than dhat: the force that presses it apart.
double pair_force(const Surface &surface, const ContactLaw &law, const ContactPair &pair,
                  const PairPoints &points, double distance);

/// B of the pairs; infinite where one touches. Sums in the order given.
double contact_energy(const Surface &surface, const ContactLaw &law,
                      std::span<const ContactPair> pairs, std::span<const double> x);

/// Adds dB/dx, 3 a vertex. Contact forces are its negative.
void add_contact_gradient(const Surface &surface, const ContactLaw &law,
                          std::span<const ContactPair> pairs, std::span<const double> x,
                          std::span<double> gradient);

/// The Hessian of one pair by its points, 12 x 12, and its negative part N: H + 2 w N is filtered,
/// H + N clamped. Rows of a vertex -1 are zero, and so are, in the plane, those of z.
struct PairHessian {
  std::array<int, 4> vertices;
  std::array<double, 144> H, N;
};

/// Calls take(hessian) for each pair nearer than dhat, in the order given.
/// @return how many of them have a negative eigenvalue
long contact_hessians(const Surface &surface, const ContactLaw &law,
                      std::span<const ContactPair> pairs, std::span<const double> x,
                      const std::function<void(const PairHessian &)> &take);

/// The least distance of a list of pairs, and the first pair that has it; infinity and -1 without
/// pairs.
struct LeastGap {
  double gap = std::numeric_limits<double>::infinity();
  int pair = -1;
};
LeastGap least_gap(const Surface &surface, std::span<const ContactPair> pairs,
                   std::span<const double> x);

/// Those of the pairs nearer than `distance`, in the order given.
std::vector<ContactPair> pairs_within(const Surface &surface, std::span<const ContactPair> pairs,
                                      std::span<const double> x, double distance);

}  // namespace trefoil::contact
