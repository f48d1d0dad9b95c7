// A spring or damper with a limited force.
#pragma once

#include <cmath>

#include "kerf/geometry.h"

namespace kerf {

/// Force for a stretch x: K x up to `limit`, then `limit` in the direction of x. Its energy is Huber's function, which
/// is convex. Used for forces (N/mm, mm, N) and torques (N mm/rad, rad, N mm), and likewise for dampers.
struct SaturatingSpring {
  double stiffness = 0;
  double limit = 0;

  /// Returns the secant stiffness: force = Secant(|x|) x. Tick-safe.
  double Secant(double length) const { return length * stiffness <= limit ? stiffness : limit / length; }
  Vec3 Force(const Vec3& x) const { return Secant(glm::length(x)) * x; }
  double Energy(const Vec3& x) const {
    const double length = glm::length(x);
    if (length * stiffness <= limit) return 0.5 * stiffness * length * length;
    return limit * (length - 0.5 * limit / stiffness);
  }
  bool IsSaturated(const Vec3& x) const { return glm::length(x) * stiffness > limit; }
};

}  // namespace kerf
