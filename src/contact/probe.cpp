#include "contact/probe.h"

#include <algorithm>
#include <cmath>

namespace kerf {

double CalcTravel(const Pose& from, const Pose& to, double reach_mm) {
  // Half the chord between two unit quaternions (of the nearer sign) is the sine of a quarter of the angle.
  const Quat d = glm::dot(from.R_AB, to.R_AB) < 0 ? from.R_AB + to.R_AB : from.R_AB - to.R_AB;
  const double angle = 4 * std::asin(std::min(1.0, 0.5 * std::sqrt(glm::dot(d, d))));
  return glm::length(to.p_AB - from.p_AB) + angle * reach_mm;
}

}  // namespace kerf
