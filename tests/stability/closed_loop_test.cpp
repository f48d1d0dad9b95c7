// The closed loop's own workings: the account of energy, and what lost ticks, the watchdog and the gain do.
#include "stability/closed_loop.h"

#include <gtest/gtest.h>

#include "devices/profiles.h"
#include "kerf/error.h"
#include "stability/held_block.h"

namespace kerf {
namespace {

using test::HeldBlock;

// A push on a released handle: all the work that comes in is the push's, so the account of the handle is known.
TEST(ClosedLoop, TheHandlesEnergyIsTheWorkOfThePush) {
  ClosedLoopSetup setup = HeldBlock("omega_6", "H0");
  setup.quantise = false;
  ClosedLoop loop(test::BlockOfBone(), setup, test::OverBlock());
  const Vec3 push(0.3, 0.1, -3);
  loop.device().SetIntention({.X_WH = test::OverBlock(), .push_W_N = push});
  const Vec3 from = loop.device().p_WC_mm();
  ClosedLoopTick tick;
  for (int i = 0; i < 1500; ++i) {
    tick = loop.Step(0);
    ASSERT_NEAR(tick.energy.handle_mJ, glm::dot(push, tick.p_WC_mm - from), 1e-9) << i;
  }
  EXPECT_GT(tick.energy.handle_mJ, 0.1);
  EXPECT_GT(glm::length(tick.f_device_N), 0.5);
  EXPECT_GT(tick.energy.exchanged_mJ, std::abs(tick.energy.motor_mJ));
}

TEST(ClosedLoop, ALostTickLeavesTheForceAndTheWatchdogTakesIt) {
  ClosedLoopSetup setup = HeldBlock("omega_6", "H3");
  setup.watchdog_ms = 20.5;
  ClosedLoop loop(test::BlockOfBone(), setup, test::OverBlock());
  Intention push;
  push.X_WH = test::OverBlock();
  push.push_W_N = Vec3(0, 0, -3);
  loop.device().SetIntention(push);
  for (int i = 0; i < 1000; ++i) loop.Step(0);
  TimingFaults timing;
  timing.burst_every_s = 1;
  timing.burst_s = 0.0405;
  loop.SetTiming(timing);
  while (loop.Step(0).dt_s > 0) {
  }
  const Vec3 held = loop.device().force_N();
  ASSERT_GT(glm::length(held), 1);
  int lost = 1;
  ClosedLoopTick tick;
  for (tick = loop.Step(0); tick.dt_s == 0; tick = loop.Step(0)) {
    ++lost;
    EXPECT_EQ(tick.f_device_N, lost <= 20 ? held : Vec3{0}) << lost;
  }
  EXPECT_NEAR(lost, 40, 1);
  EXPECT_EQ(tick.dt_s, 0.01);  // no more than that, however long it was
  EXPECT_EQ(tick.out.faults, kHapticForceOff);
  Vec3 before = loop.device().force_N();
  EXPECT_EQ(before, Vec3{0});
  for (int i = 0; i < 900; ++i) {
    tick = loop.Step(0);
    const Vec3 f = loop.device().force_N();
    EXPECT_LE(glm::length(f - before), 12 / 0.005 * 0.001 * (1 + 1e-9)) << i;
    EXPECT_LT(glm::length(f), i < 20 ? 0.1 * glm::length(held) : 12) << i;
    before = f;
  }
  EXPECT_NEAR(before.z, held.z, 0.3);
}

TEST(ClosedLoop, TheSimulationIsToldTheTimeInWholePeriods) {
  ClosedLoop loop(test::BlockOfBone(), HeldBlock("omega_6", "H3"), test::OverBlock());
  for (const bool tail : {false, true}) {
    TimingFaults timing;
    timing.jitter = 0.5;
    timing.tail_p999_s = tail ? 0.005 : 0;
    timing.lost_share = 0.05;
    loop.SetTiming(timing);
    const double from_s = loop.Step(0).time_s;
    double told_s = 0;
    int lost = 0;
    ClosedLoopTick tick;
    for (int i = 0; i < 20000; ++i) {
      tick = loop.Step(0);
      told_s += tick.dt_s;
      lost += tick.dt_s == 0 ? 1 : 0;
      EXPECT_NEAR(1000 * tick.dt_s, std::round(1000 * tick.dt_s), 1e-9);
    }
    // Periods shorter than half of one are told as a whole one: with the tail there are many.
    EXPECT_NEAR(told_s, tick.time_s - from_s, (tail ? 0.13 : 0.02) * told_s);
    EXPECT_NEAR(lost, 1000, 150);
  }
}

TEST(ClosedLoop, TheGainIsTheMotors) {
  for (const double gain : {0.5, 1.0, 2.0}) {
    ClosedLoopSetup setup = HeldBlock("omega_6", "H4");
    setup.loop_gain = gain;
    ClosedLoop loop(test::BlockOfBone(), setup, test::OverBlock());
    Intention push;
    push.X_WH = test::OverBlock();
    push.push_W_N = Vec3(0, 0, -3);
    loop.device().SetIntention(push);
    ClosedLoopTick tick;
    for (int i = 0; i < 1500; ++i) tick = loop.Step(0);
    EXPECT_NEAR(loop.device().force_N().z, gain * tick.out.force.f_H_W_N.z, 1e-12) << gain;
    EXPECT_GT(tick.out.force.f_H_W_N.z, 0.1) << gain;
  }
}

TEST(ClosedLoop, RefusesWhatIsOutOfRange) {
  ClosedLoopSetup setup = HeldBlock("omega_6", "H3");
  setup.loop_gain = -1;
  EXPECT_THROW(ClosedLoop(test::BlockOfBone(), setup, test::OverBlock()), Error);
  setup = HeldBlock("omega_6", "H3");
  setup.period_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ClosedLoop(test::BlockOfBone(), setup, test::OverBlock()), Error);
  ClosedLoop loop(test::BlockOfBone(), HeldBlock("omega_6", "H3"), test::OverBlock());
  TimingFaults timing;
  timing.lost_share = 1;
  EXPECT_THROW(loop.SetTiming(timing), Error);
}

}  // namespace
}  // namespace kerf
