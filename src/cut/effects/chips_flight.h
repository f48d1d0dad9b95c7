// The flight of a chip: a ball of bone in still air, from where it was thrown.
#pragma once

#include "kerf/geometry.h"

namespace kerf {

struct ChipMotion {
  Vec3 p_mm{0};
  Vec3 v_mm_per_s{0};
};

/// dv/dt = g - k(|v|) v, with k of a ball's drag after Schiller and Naumann (1933): k = (1 + 0.15 Re^0.687) / tau,
/// tau = rho d^2 / (18 mu), Re = |v| d / nu; from Re = 1000 on a drag coefficient of 0.44.
class ChipFlight {
 public:
  /// `diameter_mm` > 0; `drag`: times that of a ball, 0: none.
  ChipFlight(double diameter_mm, double drag, const Vec3& gravity_mm_per_s2);

  /// k, 1/s.
  double CalcDragRate(double speed_mm_per_s) const;
  /// After `age_s` >= 0. Goes there in steps that become longer with the age, each exact for the drag rate at its
  /// middle: of second order, to 1 % of the way, and stable for any age. Exact without drag.
  ChipMotion CalcMotion(const ChipMotion& start, double age_s) const;

 private:
  ChipMotion Step(const ChipMotion& from, double rate_per_s, double dt_s) const;

  double drag_per_s_;             // of a slow ball
  double reynolds_per_mm_per_s_;  // Re for each mm/s
  Vec3 g_mm_per_s2_;
};

}  // namespace kerf
