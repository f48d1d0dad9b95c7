// The saw: a thin toothed disc on a spindle.
#pragma once

#include "kerf/geometry.h"

namespace kerf {

/// A circular saw. Tool frame T: origin at the disc's centre, z along the spindle axis, disc in the x-y plane.
/// Defaults are the disc that the paper's tables were computed with (docs/physics.md).
struct DiscSaw {
  double diameter_mm = 22;     // 1 to 200
  double thickness_mm = 0.25;  // 0.02 to 10; the kerf's width
  int teeth = 24;              // 1 to 1000
  double E_MPa = 205000;       // steel
  double nu = 0.28;
  Vec3 p_TG_mm{0, 0, 80};  // the hand's grip in T; torques are about it

  double radius_mm() const { return 0.5 * diameter_mm; }
  double pitch_mm() const { return 3.14159265358979323846 * diameter_mm / teeth; }
  /// Throws Error naming the first value out of range.
  void Validate() const;
};

}  // namespace kerf
