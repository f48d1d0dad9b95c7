// Flight of a chip: a ball of bone in still air, thrown from a point.
#pragma once

#include "kerf/geometry.h"

namespace kerf {

struct ChipMotion {
  Vec3 p_mm{0};
  Vec3 v_mm_per_s{0};
};

/// Model: dv/dt = g - k(|v|) v, with k from the drag of a ball according to Schiller and Naumann (1933): k = (1 + 0.15
/// Re^0.687) / tau, tau = rho d^2 / (18 mu), Re = |v| d / nu; for Re >= 1000, k follows from a drag coefficient of
/// 0.44.
class ChipFlight {
 public:
  /// `diameter_mm` > 0. `drag`: factor on the drag of a ball; 0: no drag.
  ChipFlight(double diameter_mm, double drag, const Vec3& gravity_mm_per_s2);

  /// Returns k, 1/s.
  double CalcDragRate(double speed_mm_per_s) const;
  /// Returns the motion at `age_s` >= 0. The integration uses steps whose length increases with the age, each exact for
  /// the drag rate at its middle. It is second-order accurate, with an error of 1 % of the distance flown, and stable
  /// for any age. Without drag it is exact.
  ChipMotion CalcMotion(const ChipMotion& start, double age_s) const;

 private:
  ChipMotion Step(const ChipMotion& from, double rate_per_s, double dt_s) const;

  double drag_per_s_;             // at low speed
  double reynolds_per_mm_per_s_;  // Reynolds number per mm/s
  Vec3 g_mm_per_s2_;
};

}  // namespace kerf
