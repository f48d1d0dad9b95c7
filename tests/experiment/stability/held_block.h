// Setup for the tests of the closed loop: the paper's saw above a block of bone, on a device of the table with its
// defaults.
#pragma once

#include <cmath>
#include <string>

#include "device/devices/profiles.h"
#include "experiment/stability/closed_loop.h"
#include "loop/haptics/coupling_limits.h"
#include "loop/haptics/held_saw.h"

namespace kerf::test {

/// Returns a block of 26 x 6 x 26 mm with its top at z = 0. The disc (radius 11 mm) comes from above.
inline Bone BlockOfBone(double voxel_mm = 0.4, const Vec3& size_mm = Vec3(26, 6, 26)) {
  return MakeBlock({.size_mm = size_mm, .X_WB = {}, .layers = {}, .voxel_mm = voxel_mm}, OneRegionTable());
}

/// Returns an upright pose with the rim `above_mm` above the block's top.
inline Pose OverBlock(double above_mm = 0.2) {
  return Upright(Vec3(0, 0, 11 + above_mm));
}

/// Returns device, hand, and the default coupling of a scene, fitted as `kerf loop` does.
inline ClosedLoopSetup HeldBlock(const std::string& profile, const std::string& hand, CouplingParams coupling = {},
                                 double period_s = 0.001) {
  ClosedLoopSetup setup;
  setup.profile = FindDeviceProfile(profile);
  setup.hand = FindHandModel(hand);
  setup.period_s = period_s;
  setup.coupled.tool = DiscSaw{};
  const ForceMap map(setup.profile, setup.force_map);
  setup.coupled.coupling = FitCoupling(setup.profile, setup.hand, coupling, map.force_scale(), map.torque_scale(),
                                       period_s, setup.delay_ticks)
                               .coupling;
  return setup;
}

/// What a hand that pushes down takes of its own push: the place that its spring holds on to follows the handle with a
/// time constant (Intention::yield_s), and its damper and that of the device oppose the motion.
class YieldingHand {
 public:
  YieldingHand(const ClosedLoopSetup& setup, double yield_s, const Pose& X_WH_start)
      : own_damping_Ns_per_mm_(setup.profile.own_damping_Ns_per_mm), yield_s_(yield_s), held_mm_(X_WH_start.p_AB.z) {}

  /// Adds the next tick; returns the force, N of the device.
  double Add(const ClosedLoopTick& tick, const HandModel& hand) {
    const double lag_mm = held_mm_ - tick.p_WC_mm.z;
    held_mm_ += std::expm1(-(tick.time_s - time_s_) / yield_s_) * lag_mm;
    time_s_ = tick.time_s;
    return hand.stiffness_N_per_mm * lag_mm - (hand.damping_Ns_per_mm + own_damping_Ns_per_mm_) * tick.v_WC_mm_per_s.z;
  }

 private:
  double own_damping_Ns_per_mm_;
  double yield_s_;
  double held_mm_;
  double time_s_ = 0;
};

}  // namespace kerf::test
