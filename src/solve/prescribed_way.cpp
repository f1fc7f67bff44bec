#include "solve/prescribed_way.hpp"

#include <algorithm>
#include <sstream>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Local displacements with what is prescribed at a time, the rest as before.
PetscErrorCode hold_at(Scene &scene, double time, std::vector<double> *u) {
  HeldDofs held;
  PetscFunctionBeginUser;
  PetscCall(scene.constraints.hold(time, &held));
  for (std::size_t k = 0; k < held.held.size(); ++k) {
    if (held.held[k]) (*u)[k] = held.value[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode find_meeting_of_prescribed(Scene &scene, const std::vector<double> &u, double from,
                                          double to, std::string *meeting) {
  constexpr double shortest = 1. / 1024;
  std::vector<double> here = u, there = u;
  double at = 0, length = 1;
  PetscFunctionBeginUser;
  meeting->clear();
  while (at < 1 && meeting->empty()) {
    AllowedMotion motion;
    length = std::min(length, 1 - at);
    const double begin = from + at * (to - from), end = from + (at + length) * (to - from);
    PetscCall(hold_at(scene, end, &there));
    PetscCall(scene.contact->find_allowed_motion(here.data(), begin, there.data(), end, &motion,
                                                 Movers::prescribed));
    if (motion.share >= 1) {
      at += length;
      length *= 2;
      here.swap(there);
    } else if (length > shortest) {
      length /= 2;
    } else if (motion.what.empty()) {  // it moves too far to be looked at
      break;
    } else {
      std::ostringstream text;
      text << "what is prescribed cannot move so far: " << motion.what
           << " would meet at t = " << begin + motion.share * (end - begin)
           << ", and neither can give way: both are prescribed";
      *meeting = text.str();
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
