// A saw coupled to a simulated hand on a block of bone, in virtual time.
#pragma once

#include <string>

#include "bone/models/block.h"
#include "cut/hand_sim/internals.h"
#include "device/devices/profiles.h"
#include "device/devices/simulated_device.h"
#include "loop/haptics/haptic_step.h"
#include "support/solids.h"

namespace kerf::test {

inline constexpr double kDt_s = 0.001;
inline constexpr double kHalfPi = 1.57079632679489661923;

/// Returns a pose with the disc upright, its spindle along y and its centre at p_W.
inline Pose Upright(const Vec3& p_W) {
  return {glm::angleAxis(-kHalfPi, Vec3(1, 0, 0)), p_W};
}

/// Returns a device with the given resolution and stiffness and no friction, strong enough to output the
/// simulated force unscaled (force scale 1).
inline DeviceProfile MakeDevice(double resolution_mm, double stiffness_N_per_mm) {
  DeviceProfile profile = FindDeviceProfile("omega_3");
  profile.name = "test";
  profile.peak_force_N = 40;
  profile.continuous_force_N = 0;
  profile.friction_N = 0;
  profile.resolution_mm = resolution_mm;
  profile.max_stiffness_N_per_mm = stiffness_N_per_mm;
  return profile;
}

struct HeldSawOptions {
  DeviceProfile profile = MakeDevice(0.006, 1.5);
  std::string hand = "H2";
  double stiffness_N_per_mm = 1.5;
  double damping_Ns_per_mm = 0;
  double voxel_mm = 0.2;
  Vec3 block_mm{26, 6, 80};
  bool whole_voxels = false;
  bool quantise = true;
  int delay_ticks = 0;
  double above_mm = 0.2;  // initial height of the rim above the block's top
  ForceMapParams force_map;
  ForceLaw law = ForceLaw();
};

inline ComparedParams MakeComparedParams(const HeldSawOptions& o) {
  ComparedParams params;
  params.tool = DiscSaw{};
  params.law = o.law;
  params.coupling.stiffness_N_per_mm = o.stiffness_N_per_mm;
  params.coupling.damping_Ns_per_mm = o.damping_Ns_per_mm;
  params.whole_voxel_removal = o.whole_voxels;
  params.spare_leaves = 20000;
  return params;
}

struct HeldSaw {
  explicit HeldSaw(const HeldSawOptions& o = {})
      : start(Upright(Vec3(0, 0, 11 + o.above_mm))),
        simulation(MakeComparedSimulation(
            MakeBlock({.size_mm = o.block_mm, .X_WB = {}, .layers = {}, .voxel_mm = o.voxel_mm}, OneRegionTable()),
            MakeComparedParams(o), start)),
        device(o.profile, FindHandModel(o.hand), start, MakeDeviceOptions(o)),
        step(simulation, o.profile, o.force_map) {
    device.SetIntention({.X_WH = start});
  }

  static SimulatedDeviceOptions MakeDeviceOptions(const HeldSawOptions& o) {
    SimulatedDeviceOptions options;
    options.quantise = o.quantise;
    options.delay_ticks = o.delay_ticks;
    return options;
  }
  HapticTick Step(double rpm = 7500, double dt_s = kDt_s, bool force_off = false) {
    return step.Step(device, {.dt_s = dt_s, .rpm = rpm, .flags = force_off ? kRecordedForceOff : 0u});
  }

  Pose start;
  CoupledSimulation simulation;
  SimulatedDevice device;
  HapticStep step;
};

}  // namespace kerf::test
