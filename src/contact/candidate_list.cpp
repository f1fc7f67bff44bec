#include "contact/candidate_list.hpp"

#include <algorithm>
#include <cmath>

namespace trefoil::contact {

void CandidateList::keep(std::span<const double> x, std::span<const double> step) {
  x_.assign(x.begin(), x.end());
  step_.assign(step.begin(), step.end());
  const auto longest = std::max_element(
      step_.begin(), step_.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  longest_ = static_cast<std::size_t>(longest - step_.begin());
  if (longest == step_.end() || *longest == 0) step_.clear();
}

void CandidateList::find(const Surface &surface, std::span<const double> x,
                         const PairSearch &search) {
  PairSearch wider = search;
  slack_ = search.reach / 2;
  wider.reach += 2 * slack_;
  pairs_ = find_candidates(surface, x, wider);
  share_ = 1;
  keep(x, {});
}

void CandidateList::find(const Surface &surface, std::span<const double> x,
                         std::span<const double> step, const PairSearch &search) {
  PairSearch wider = search;
  slack_ = 1e-3 * search.reach;  // for the rounding of x + t step
  wider.reach += 2 * slack_;
  SweptCandidates found = find_candidates(surface, x, step, wider);
  pairs_.swap(found.pairs);
  share_ = found.share;
  keep(x, step);
}

bool CandidateList::covers(std::span<const double> x) const {
  if (slack_ < 0 || x.size() != x_.size()) return false;
  double t = 0;
  if (!step_.empty()) t = std::clamp((x[longest_] - x_[longest_]) / step_[longest_], 0., share_);
  for (std::size_t k = 0; k + 2 < x.size(); k += 3) {
    double square = 0;
    for (std::size_t i = k; i < k + 3; ++i) {
      const double off = x[i] - x_[i] - (step_.empty() ? 0 : t * step_[i]);
      square += off * off;
    }
    if (!(square <= slack_ * slack_)) return false;
  }
  return true;
}

double CandidateList::bytes() const {
  return static_cast<double>(pairs_.capacity() * sizeof(ContactPair) +
                             (x_.capacity() + step_.capacity()) * sizeof(double));
}

}  // namespace trefoil::contact
