#pragma once

#include <compare>
#include <span>
#include <vector>

#include "contact/distances.hpp"
#include "contact/surface.hpp"

namespace trefoil::contact {

/// A pair of primitives: vertex `first` and facet `second`, or edges first < second.
struct ContactPair {
  PairKind kind = PairKind::vertex_triangle;
  int first = 0, second = 0;
  auto operator<=>(const ContactPair &) const = default;
};

/// Which pairs are asked for.
struct PairSearch {
  double reach = 0;          ///< that come at most so near to each other: dhat, or dhat and a skin
  bool self_contact = true;  ///< also of one body
  /// Without it, pairs have a free vertex; with it, one that is no obstacle's: for the motion of
  /// what is prescribed.
  bool prescribed = false;
  int rank = -1;  ///< only those that this rank owns, see owner_of_pair(); -1: all
};

/// The two primitives of a pair.
const Primitive &first_of(const Surface &surface, const ContactPair &pair);
const Primitive &second_of(const Surface &surface, const ContactPair &pair);

/// The vertices of a pair in the order of PairPoints; -1: none.
std::array<int, 4> vertices_of(const Surface &surface, const ContactPair &pair);

/// Where they are; a point that is not used is zero.
PairPoints points_of(const std::array<int, 4> &vertices, std::span<const double> x);

/// Whether a search is for pairs of two such primitives: by role, body and rank.
bool is_asked_for(const Primitive &a, const Primitive &b, const PairSearch &search);

/// Whether it is for this pair: that, and no common vertex.
bool may_touch(const Surface &surface, const ContactPair &pair, const PairSearch &search);

/// The pairs of a search that are no farther apart than search.reach, sorted. With a rank, only
/// what overlaps the box of this rank's own primitives is looked at.
/// @param x  finite, 3 a vertex
std::vector<ContactPair> find_candidates(const Surface &surface, std::span<const double> x,
                                         const PairSearch &search);

/// Pairs that serve every point of a segment.
struct SweptCandidates {
  std::vector<ContactPair> pairs;
  double share = 1;  ///< of the step: the segment is [x, x + share step]
};

/// All pairs of a search that may come nearer than search.reach while the vertices go straight from
/// x to x + step, sorted; and few others: those whose boxes come so near, and for which the plane
/// between the nearest points at x does not keep them apart.
///
/// Where the step is so long that boxes overlap in masses, some twenty edges of motion against
/// others, only a share of it, a power of 1/4, is looked at: the boxes of a wild step would all
/// have to be compared with each other. A step that is not finite gets the share 0 and no pairs.
/// @param x     finite, 3 a vertex
/// @param step  likewise 3 a vertex
SweptCandidates find_candidates(const Surface &surface, std::span<const double> x,
                                std::span<const double> step, const PairSearch &search);

}  // namespace trefoil::contact
