#pragma once

#include <string>

#include "scene/scene.hpp"

namespace trefoil {

/// How small a direction has to be that ends a step in time.
class TimeTolerance {
 public:
  explicit TimeTolerance(const Scene &scene);

  /// Of a step of this length, in units of length; 0: directions end none.
  [[nodiscard]] double of_step(double length) const;
  /// The same in a sentence, for people.
  [[nodiscard]] std::string text() const;

 private:
  const TimeOptions &options_;
  double diagonal_;  ///< of the body's box
  double asked_;     ///< by the user, a velocity
  double velocity_;  ///< that counts
};

}  // namespace trefoil
