// Sums over the ticks in which the saw touches bone.
#pragma once

#include <algorithm>
#include <optional>

#include "loop/haptics/loop_body.h"

namespace kerf {

/// Returns true if the tool's teeth or faces touch bone; Touches() is also true for the pull of an effect.
inline bool TouchesBone(const CoupledOutput& out) {
  return out.removed_mm3 > 0 || out.f_cut_W_N != Vec3{0} || out.f_face_W_N != Vec3{0};
}

/// The force on the hand counts only while the saw touches bone: a guide pulls a saw in the air, too.
struct ContactSums {
  double in_bone_s = 0;                // time in which the saw touched bone, turning or held by the hand
  double turning_force_N = 0;          // largest force on the hand meanwhile, while the spindle turned
  double stopped_force_N = 0;          // the same while it did not
  std::optional<double> bone_touch_s;  // time of the last tick in which it touched bone; none: never

  /// `since_s`: time of the tick before.
  void Take(const LoopTick& tick, double since_s) {
    if (!TouchesBone(tick.coupled)) return;
    // A stopped saw that was let go of rests in its kerf.
    if (tick.held || tick.in.rpm != 0) in_bone_s += std::max(0.0, tick.time_s - since_s);
    bone_touch_s = tick.time_s;
    double& largest_N = tick.in.rpm != 0 ? turning_force_N : stopped_force_N;
    largest_N = std::max(largest_N, glm::length(tick.coupled.f_H_W_N));
  }
};

}  // namespace kerf
