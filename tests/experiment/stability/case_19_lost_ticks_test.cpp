// Hard case 19: ticks are lost and the force on the device grows old. (Results of a graphics card that come late do not
// apply: none takes part in a tick.)
#include "experiment/stability/held_block.h"
#include "experiment/stability/invariants.h"
#include "experiment/stability/verdict.h"

namespace kerf {
namespace {

using test::HeldBlock;

struct Lost {
  double share = 0;
  double burst_s = 0;
};

struct Seen {
  double most_step_N = 0;  // of the device's force, from write to write
  double most_N = 0;
  double stale_change_N = 0;  // of the force while nobody works it out
  double late_N = 0;          // left when the watchdog should have bitten
  double most_ramp = 0;       // force over what was asked for, in the first 50 ms after it has bitten
  double removed_mm3 = 0;
  int lost = 0;
};

/// Three strokes into the block, with ticks lost.
PortEnergy Saw(const std::string& hand, const Lost& lost, Seen& seen) {
  const ClosedLoopSetup setup = HeldBlock("omega_6", hand);
  ClosedLoop loop(test::BlockOfBone(), setup, test::OverBlock());
  test::Invariants watch(loop.simulation(), test::OverBlock());
  watch.WatchDevice(setup.profile);
  TimingFaults timing;
  timing.lost_share = lost.share;
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
    seen.most_N = std::max(seen.most_N, glm::length(tick.f_device_N));
    if (tick.dt_s == 0) {
      ++seen.lost;
      silent_s += setup.period_s;
      // The motors hold what they have until the watchdog bites, in the period in which 50 ms are over.
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
      seen.most_step_N = std::max(seen.most_step_N, glm::length(now_N - written_N) / slew_N);
      ramp_s += tick.dt_s;
      if (ramp_s < 0.05) {
        const double asked_N = 12.0 / 28 * glm::length(tick.out.coupled.f_H_W_N);
        seen.most_ramp = std::max(seen.most_ramp, glm::length(now_N) / std::max(asked_N, 0.1));
      }
    }
    written_N = now_N;
    HapticStepInput in;
    in.dt_s = tick.dt_s;
    in.slew_dt_s = setup.period_s;
    watch.Step(in, tick.out);
  }
  watch.CheckBone();
  seen.removed_mm3 += watch.removed_mm3();
  return tick.energy;
}

TEST(HardCase19, LostTicksLeaveAnOldForceForAtMostTheWatchdogsTimeAndNoBlowAfterwards) {
  test::Verdict verdict(
      "holds, but a lost tick's force is held, not extrapolated or faded: the motors keep it until the watchdog's 50 "
      "ms, "
      "then it is zero and ramped in");
  Seen seen;
  double beyond = 0;
  double given_back_mJ = 0;
  for (const char* hand : {"H2", "H3"}) {
    Seen none;
    // Even so some comes out: the handle sinks in while the force is ramped in, and is lifted again.
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
  EXPECT_GT(seen.most_N, 1);
  EXPECT_GT(seen.removed_mm3, 1);
  EXPECT_EQ(seen.stale_change_N, 0);
  verdict.AtMost("largest step of the device's force when ticks come again, of its slew", seen.most_step_N, 1 + 1e-9);
  verdict.Equal("force after 50 ms without a tick", seen.late_N, 0, "N");
  verdict.AtMost("force in the first 50 ms of the ramp after that, of what is asked for", seen.most_ramp, 0.03);
  verdict.AtMost("energy that lost ticks let out, of what holding a spring's force can give back", beyond, 1);
  verdict.Note("energy that ramps after the watchdog lift the handle with", given_back_mJ, "mJ");
}

}  // namespace
}  // namespace kerf
