// Setup for the tests of the closed loop: the paper's saw above a block of bone, on a device of the table with its
// defaults.
#pragma once

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

}  // namespace kerf::test
