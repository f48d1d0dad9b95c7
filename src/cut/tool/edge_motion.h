// How a drive moves the edge of a blade by a displacement along it. Tick-safe.
#pragma once

#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "kerf/geometry.h"

namespace kerf {

/// Displacements of the edge along itself, mm.
struct SlideRange {
  double least_mm = 0;
  double most_mm = 0;
  double size_mm() const { return most_mm - least_mm; }
};

/// A straight edge moves along y of T. An arc turns about its swing axis, which is parallel to z of T through
/// (-swing_radius_mm, 0), by the displacement divided by its radius. E is the frame that moves with the edge; without a
/// displacement it is T.
class EdgeMotion {
 public:
  EdgeMotion() = default;
  /// `swing_radius_mm`: 0 for a straight edge.
  explicit EdgeMotion(double swing_radius_mm) : radius_mm_(swing_radius_mm) {}

  bool is_straight() const { return radius_mm_ == 0; }
  double radius_mm() const { return radius_mm_; }
  /// Returns the orientation of E in T.
  Quat CalcTurn(double slide_mm) const {
    if (is_straight()) return {1, 0, 0, 0};
    const double half_rad = 0.5 * slide_mm / radius_mm_;
    return {std::cos(half_rad), 0, 0, std::sin(half_rad)};
  }
  /// Returns where a displacement takes a point of T.
  Vec3 Move(const Vec3& p_T, double slide_mm) const { return Move(p_T, slide_mm, CalcTurn(slide_mm)); }
  /// The same, for many points of one displacement. `turn`: CalcTurn(slide_mm).
  Vec3 Move(const Vec3& p_T, double slide_mm, const Quat& turn) const {
    if (is_straight()) return {p_T.x, p_T.y + slide_mm, p_T.z};
    const Vec3 axis_T(-radius_mm_, 0, 0);
    return axis_T + turn * (p_T - axis_T);
  }
  /// Returns the pose of E, for a tool at X_WT.
  Pose Move(const Pose& X_WT, double slide_mm) const {
    return {is_straight() ? X_WT.R_AB : X_WT.R_AB * CalcTurn(slide_mm), X_WT.Point(Move(Vec3(0), slide_mm))};
  }
  /// Returns the velocity of a point of the blade, tool frame, while the edge moves along itself at a speed.
  Vec3 CalcVelocity(const Vec3& p_T, double edge_mm_per_s) const {
    if (is_straight()) return {0, edge_mm_per_s, 0};
    const double rad_per_s = edge_mm_per_s / radius_mm_;
    return {-rad_per_s * p_T.y, rad_per_s * (p_T.x + radius_mm_), 0};
  }

 private:
  double radius_mm_ = 0;
};

}  // namespace kerf
