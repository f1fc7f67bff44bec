#pragma once

#include <span>
#include <vector>

#include "contact/candidates.hpp"

namespace trefoil::contact {

/// The pairs that may be in contact at positions on a segment, or near it: found once, used for as
/// long as the positions stay there.
class CandidateList {
 public:
  /// All pairs within search.reach of each other wherever vertices move by up to half that reach
  /// from x.
  void find(const Surface &surface, std::span<const double> x, const PairSearch &search);
  /// Those at any point of [x, x + share() step], share() <= 1 as find_candidates() chooses it.
  void find(const Surface &surface, std::span<const double> x, std::span<const double> step,
            const PairSearch &search);

  /// Whether pairs() has all pairs within the reach at x.
  [[nodiscard]] bool covers(std::span<const double> x) const;
  [[nodiscard]] const std::vector<ContactPair> &pairs() const { return pairs_; }
  [[nodiscard]] double share() const { return share_; }
  [[nodiscard]] double bytes() const;

 private:
  void keep(std::span<const double> x, std::span<const double> step);

  std::vector<ContactPair> pairs_;
  std::vector<double> x_, step_;  ///< of the segment; without a step: a point
  std::size_t longest_ = 0;       ///< the step's largest component
  double share_ = 1;
  double slack_ = -1;  ///< vertices may be so far from the segment; < 0: nothing was found yet
};

}  // namespace trefoil::contact
