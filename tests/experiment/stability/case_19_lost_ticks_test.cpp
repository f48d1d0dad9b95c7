// Hard case 19: ticks are lost, and the force on the device becomes stale. (Late results of a graphics card do not
// apply, because no tick uses one.)
#include "experiment/stability/held_block.h"
#include "experiment/stability/invariants.h"
#include "experiment/stability/verdict.h"

namespace kerf {
namespace {

using test::HeldBlock;

struct Lost {
  double fraction = 0;
  double burst_s = 0;
};

struct Seen {
  double max_step_N = 0;  // of the device's force, between writes
  double max_N = 0;
  double stale_change_N = 0;  // of the force while no tick computes it
  double late_N = 0;          // force left after the watchdog should have tripped
  double max_ramp = 0;        // ratio of the force to the requested force, in the first 50 ms after the trip
  double removed_mm3 = 0;
  int lost = 0;
};

/// Makes three strokes into the block, with lost ticks.
PortEnergy Saw(const std::string& hand, const Lost& lost, Seen& seen) {
  const ClosedLoopSetup setup = HeldBlock("omega_6", hand);
  ClosedLoop loop(test::BlockOfBone(), setup, test::OverBlock());
  test::Invariants watch(loop.simulation(), test::OverBlock());
  watch.WatchDevice(setup.profile);
  TimingFaults timing;
  timing.lost_share = lost.fraction;
  timing.burst_s = lost.burst_s;
  timing.burst_every_s = lost.burst_s > 0 ? 0.4 : 0;
  timing.seed = 19;
  loop.SetTiming(timing);
  const double slew_N = setup.profile.peak_force_N / 0.005 * setup.period_s;
  Vec3 written_N(0);
  double silent_s = 0;
  double ramp_s = 1;
  ClosedLoopTick tick;
  const int ticks = static_cast<int>(3000 * std::min(1.0, test::Effort()));
  for (int i = 0; i < ticks; ++i) {
    Intention intention;
    intention.X_WH = test::OverBlock();
    intention.X_WH.p_AB.x += 3 * std::sin(0.004 * i);
    intention.push_W_N = Vec3(0, 0, -2);
    loop.device().SetIntention(intention);
    tick = loop.Step(7500);
    seen.max_N = std::max(seen.max_N, glm::length(tick.f_device_N));
    if (tick.dt_s == 0) {
      ++seen.lost;
      silent_s += setup.period_s;
      // The motors keep their force until the watchdog trips, in the period in which the 50 ms elapse.
      const Vec3 now_N = loop.device().force_N();
      if (silent_s < 0.0495) seen.stale_change_N = std::max(seen.stale_change_N, glm::length(now_N - written_N));
      if (silent_s > 0.0505) seen.late_N = std::max(seen.late_N, glm::length(now_N));
      continue;
    }
    if (silent_s > 0.0505) {
      EXPECT_EQ(tick.out.faults, kHapticForceOff);
      ramp_s = 0;
    }
    silent_s = 0;
    const Vec3 now_N = tick.out.force.f_H_W_N;
    if (tick.out.faults == kHapticOk) {
      seen.max_step_N = std::max(seen.max_step_N, glm::length(now_N - written_N) / slew_N);
      ramp_s += tick.dt_s;
      if (ramp_s < 0.05) {
        const double asked_N = 12.0 / 28 * glm::length(tick.out.coupled.f_H_W_N);
        seen.max_ramp = std::max(seen.max_ramp, glm::length(now_N) / std::max(asked_N, 0.1));
      }
    }
    written_N = now_N;
    watch.Step(tick.out, setup.period_s);
  }
  watch.CheckBone();
  seen.removed_mm3 += watch.removed_mm3();
  return tick.energy;
}

TEST(HardCase19, LostTicksHoldTheForceUntilTheWatchdogTripsWithoutABlowAfterwards) {
  test::Verdict verdict(
      "holds, but when a tick is lost, the force is held, not extrapolated or faded: the motors keep it until the "
      "watchdog trips after 50 ms; then it is zero and ramps in again");
  Seen seen;
  double beyond = 0;
  double given_back_mJ = 0;
  for (const char* hand : {"H2", "H3"}) {
    Seen none;
    // Even without lost ticks some energy is returned: the handle sinks in during the ramp and is lifted again.
    const PortEnergy whole = Saw(hand, {}, none);
    for (const Lost& lost :
         {Lost{0.01, 0}, Lost{0.05, 0}, Lost{0.2, 0}, Lost{0, 0.005}, Lost{0, 0.01}, Lost{0, 0.05}, Lost{0, 0.2}}) {
      const PortEnergy energy = Saw(hand, lost, seen);
      const double more_mJ = whole.lowest_mJ - energy.lowest_mJ;
      if (lost.burst_s < 0.05) {
        beyond = std::max(beyond, more_mJ / energy.held_mJ);
      } else {
        given_back_mJ = std::max(given_back_mJ, more_mJ);
      }
    }
  }
  EXPECT_GT(seen.lost, 1000 * std::min(1.0, test::Effort()));
  EXPECT_GT(seen.max_N, 1);
  EXPECT_GT(seen.removed_mm3, 1);
  EXPECT_EQ(seen.stale_change_N, 0);
  verdict.AtMost("largest step of the device force when ticks resume, relative to the slew limit", seen.max_step_N,
                 1 + 1e-9);
  verdict.Equal("force after 50 ms without a tick", seen.late_N, 0, "N");
  verdict.AtMost("force in the first 50 ms of the next ramp relative to the requested force", seen.max_ramp, 0.03);
  verdict.AtMost("energy returned by lost ticks relative to what a held spring force can return", beyond, 1);
  verdict.Note("energy with which the ramp after a watchdog trip lifts the handle", given_back_mJ, "mJ");
}

}  // namespace
}  // namespace kerf
