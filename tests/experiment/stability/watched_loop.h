// A closed loop that checks the invariants in every tick, with the measures that its tests need.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "experiment/stability/closed_loop.h"
#include "experiment/stability/hand_orbit.h"
#include "experiment/stability/invariants.h"

namespace kerf::test {

struct WatchedLoop {
  WatchedLoop(Bone bone, const ClosedLoopSetup& setup, const Pose& X_WH_start, bool watch_bone = false)
      : loop(std::move(bone), setup, X_WH_start),
        invariants(loop.simulation(), X_WH_start, Invariants::Options{watch_bone, true}) {
    invariants.WatchDevice(setup.profile, setup.force_map);
  }

  ClosedLoopTick Step(double rpm = 7500) {
    const Vec3 before_N = loop.device().force_N();
    const ClosedLoopTick tick = loop.Step(rpm);
    if (tick.dt_s > 0) invariants.Step(tick.out, loop.setup().period_s);
    largest_N = std::max(largest_N, glm::length(loop.device().force_N()));
    largest_rise_N = std::max(largest_rise_N, glm::length(loop.device().force_N()) - glm::length(before_N));
    const PortEnergy& e = tick.energy;
    const double allowed_mJ = std::max(1e-3, 1e-3 * e.exchanged_mJ);
    overdrawn = std::max(overdrawn, -(e.motor_mJ + e.spindle_mJ) / allowed_mJ);
    return tick;
  }

  ClosedLoop loop;
  Invariants invariants;
  double largest_N = 0;       // of the motors
  double largest_rise_N = 0;  // between ticks
  /// Maximum energy that the motors returned beyond the energy supplied by hand and spindle, as a multiple of 1e-6 J or
  /// of a thousandth of the exchanged energy, whichever is larger.
  double overdrawn = 0;
};

/// Moves the hand down to the start of the orbit and along the orbit. Calls `each(tick)` after each tick of the orbit.
template <typename Each>
void FollowOrbit(WatchedLoop& saw, const HandOrbit& orbit, double rpm, Each&& each) {
  const double period_s = saw.loop.setup().period_s;
  const Intention first = orbit.At(0);
  Pose above = first.X_WH;
  above.p_AB.z = std::max(above.p_AB.z, saw.loop.X_WH_start().p_AB.z);
  // The force ramps in completely before any contact, because during the ramp more energy is returned than was
  // supplied.
  IntentionStep wait;
  wait.seconds = saw.loop.setup().force_map.ramp_in_s;
  IntentionStep down;
  down.seconds = 0.4;
  wait.X_WH = above;
  down.X_WH = first.X_WH;
  saw.loop.device().SetScript(IntentionScript(above, {wait, down}));
  for (int i = 0; i < static_cast<int>((wait.seconds + down.seconds) / period_s); ++i) saw.Step(rpm);
  for (int i = 0; i < static_cast<int>(orbit.seconds / period_s); ++i) {
    saw.loop.device().SetIntention(orbit.At(i * period_s));
    each(saw.Step(rpm));
  }
}

/// Returns a start well above the block's top, above the start of the orbit.
inline Pose AboveOrbit(const HandOrbit& orbit) {
  Pose X = orbit.At(0).X_WH;
  X.p_AB.z = 11 + 5;
  return X;
}

}  // namespace kerf::test
