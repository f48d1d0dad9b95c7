// The space that the saw passes through in one step.
#pragma once

#include <algorithm>
#include <cmath>

#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// The disc moved along a straight line in its own plane: a stadium of the disc's thickness. Tool frame of its end
/// pose.
struct DiscSweep {
  double radius_mm;
  double half_thickness_mm;
  Vec3 back_T;         // from the end centre (the origin) to the start centre, in the disc's plane, mm
  double length_mm;    // of back_T
  double inv_length2;  // 1 / length^2, 0 when it does not move

  /// Signed distance of a point of the tool frame to the swept space, mm, negative inside; exact. Tick-safe.
  double Distance(double x, double y, double z) const {
    const double t = std::clamp((x * back_T.x + y * back_T.y) * inv_length2, 0.0, 1.0);
    const double dx = x - t * back_T.x;
    const double dy = y - t * back_T.y;
    const double radial = std::sqrt(dx * dx + dy * dy) - radius_mm;
    const double axial = std::abs(z) - half_thickness_mm;
    const double out_r = std::max(radial, 0.0);
    const double out_a = std::max(axial, 0.0);
    return std::min(std::max(radial, axial), 0.0) + std::sqrt(out_r * out_r + out_a * out_a);
  }
};

/// The sweep from the centre of X_from to X_to with the orientation of X_to; the part of the motion along the spindle
/// is left to the caller, who keeps it small by sub-steps. Tick-safe.
inline DiscSweep MakeDiscSweep(const DiscSaw& saw, const Pose& X_from, const Pose& X_to) {
  Vec3 back_T = X_to.InverseVector(X_from.p_AB - X_to.p_AB);
  back_T.z = 0;
  const double length2 = glm::dot(back_T, back_T);
  return {saw.radius_mm(), 0.5 * saw.thickness_mm, back_T, std::sqrt(length2), length2 > 0 ? 1 / length2 : 0};
}

}  // namespace kerf
