// Tests of the closed loop itself: energy balance, lost ticks, watchdog and gain.
#include "experiment/stability/closed_loop.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "device/devices/profiles.h"
#include "experiment/stability/held_block.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using test::HeldBlock;

// A push on a released handle: the push does all of the work, so the handle's energy balance is known.
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

// Energy that the spindle supplies through the friction of the flats reaches the device in the same way as its forces:
// scaled, and multiplied by the gain under test.
TEST(ClosedLoop, SpindleEnergyIsScaledLikeTheDeviceForce) {
  for (const double gain : {1.0, 2.0}) {
    ClosedLoopSetup setup = HeldBlock("omega_6", "H4");
    setup.loop_gain = gain;
    ClosedLoop loop(test::BlockOfBone(0.2, Vec3(26, 6, 12)), setup, test::OverBlock());
    double given_mJ = 0;
    ClosedLoopTick tick;
    for (int i = 0; i < 3000; ++i) {
      // The handle moves down, and then alternately to both sides against the walls of the kerf.
      Pose X = test::OverBlock(std::max(0.2 - 0.004 * i, -4.0));
      X.p_AB.x += i > 1500 ? 2 * std::sin(0.004 * (i - 1500)) : 0;
      X.p_AB.y += i > 1500 ? 4 * std::sin(0.01 * (i - 1500)) : 0;
      loop.device().SetIntention({.X_WH = X});
      tick = loop.Step();
      given_mJ += 12.0 / 28 * gain * tick.out.coupled.spindle_mJ;
      ASSERT_NEAR(tick.energy.spindle_mJ, given_mJ, 1e-12 * (1 + given_mJ)) << i;
    }
    EXPECT_GT(given_mJ, 1e-4) << gain;
    EXPECT_LT(tick.energy.lowest_mJ, tick.energy.motor_mJ + tick.energy.spindle_mJ + 1e-12);
  }
}

// A spring whose force is held over a tick returns 1/2 K dx^2 more in each tick than it stored, so after n steps of dx
// in and out it has supplied n K dx^2. A heavy hand moves in and out of the wall of a stopped saw at a steady 50 mm/s,
// without the damper that would dissipate this energy. The tolerance is 15 %, because the reversal is a curve and the
// bone yields a little.
TEST(ClosedLoop, HeldEnergyIsThatOfASpringHeldOverATick) {
  ClosedLoopSetup setup = HeldBlock("omega_6", "H4");
  setup.profile.friction_N = 0;
  setup.profile.own_damping_Ns_per_mm = 0;
  setup.quantise = false;
  setup.coupled.coupling.damping_Ns_per_mm = 0;
  setup.hand = {};
  setup.hand.mass_kg = 100;
  setup.hand.damping_Ns_per_mm = 2;
  const Pose start = test::OverBlock(1);
  ClosedLoop loop(test::BlockOfBone(0.2, Vec3(26, 6, 12)), setup, start);
  ClosedLoopTick tick;
  for (int i = 0; i < 600; ++i) tick = loop.Step(0);  // until the force has ramped in
  // The hand's damper drives a steady motion in and out.
  for (int i = 0; i < 1200; ++i) {
    const double v = i < 100 ? -50.0 * i / 100 : i < 120 ? -50 : i < 320 ? -50 + 100 * (i - 120) / 200.0 : 50;
    Intention intention{.X_WH = start, .v_W_mm_per_s = Vec3(0, 0, v)};
    loop.device().SetIntention(intention);
    tick = loop.Step(0);
  }
  fmt::print("held {:.6f} mJ, lowest {:.6f} mJ, exchanged {:.4f} mJ\n", tick.energy.held_mJ, tick.energy.lowest_mJ,
             tick.energy.exchanged_mJ);
  EXPECT_GT(tick.energy.exchanged_mJ, 0.5);
  EXPECT_NEAR(tick.energy.lowest_mJ / -tick.energy.held_mJ, 1, 0.15);
}

TEST(ClosedLoop, LostTickKeepsTheForceUntilTheWatchdogTrips) {
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
  EXPECT_EQ(tick.dt_s, 0.01);  // the upper limit, whatever the duration
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

TEST(ClosedLoop, SimulationReceivesTheTimeInWholePeriods) {
  ClosedLoop loop(test::BlockOfBone(), HeldBlock("omega_6", "H3"), test::OverBlock());
  for (const bool tail : {false, true}) {
    TimingFaults timing;
    timing.jitter = 0.5;
    timing.tail_p999_s = tail ? 0.005 : 0;
    timing.lost_share = 0.05;
    loop.SetTiming(timing);
    const double from_s = loop.Step(0).time_s;
    double reported_s = 0;
    int lost = 0;
    ClosedLoopTick tick;
    for (int i = 0; i < 20000; ++i) {
      tick = loop.Step(0);
      reported_s += tick.dt_s;
      lost += tick.dt_s == 0 ? 1 : 0;
      EXPECT_NEAR(1000 * tick.dt_s, std::round(1000 * tick.dt_s), 1e-9);
    }
    // Intervals shorter than half a period are counted as a whole period. With the tail there are many of them.
    EXPECT_NEAR(reported_s, tick.time_s - from_s, (tail ? 0.13 : 0.02) * reported_s);
    EXPECT_NEAR(lost, 1000, 150);
  }
}

TEST(ClosedLoop, GainScalesTheForceOfTheMotors) {
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

// Omni: the peak is 3.3 N and the continuous force 0.88 N; heat is the mean of the squared force over 10 s. The hand
// pushes on the wall with 3 N, and the force that holds it decreases. By the test's own heat balance, the heat never
// exceeds the continuous limit of the motors.
TEST(ClosedLoop, LongPushIsHeldWithTheContinuousForceOfTheMotors) {
  ClosedLoopSetup setup = HeldBlock("omni", "H4");
  ClosedLoop loop(test::BlockOfBone(), setup, test::OverBlock());
  loop.device().SetIntention({.X_WH = test::OverBlock(), .push_W_N = Vec3(0, 0, -3), .yield_s = 0.5});
  double warm_N2 = 0;
  double max_N = 0;
  for (int i = 0; i < 30000; ++i) {
    const double f_N = glm::length(loop.Step(0).f_device_N);
    warm_N2 += (1 - std::exp(-0.001 / 10)) * (f_N * f_N - warm_N2);
    ASSERT_LE(std::sqrt(warm_N2), 0.88 * (1 + 1e-3)) << i;
    max_N = std::max(max_N, f_N);
  }
  EXPECT_GT(max_N, 2);
  EXPECT_NEAR(glm::length(loop.device().force_N()), 0.88, 0.02);
}

// The slew rate also applies to rotation: a stopped disc is in its kerf, and from one tick to the next the hand holds
// the tool rotated by a quarter turn. The torque takes at least 5 ms from zero to the device's peak.
TEST(ClosedLoop, TorqueRisesAtTheSlewRate) {
  const ClosedLoopSetup setup = HeldBlock("virtuose_6d", "H4");
  ClosedLoop loop(test::BlockOfBone(0.2, Vec3(26, 6, 12)), setup, test::OverBlock());
  for (int i = 0; i < 3000; ++i) {
    loop.device().SetIntention({.X_WH = test::OverBlock(std::max(0.2 - 0.003 * i, -4.0))});
    loop.Step();
  }
  Pose X = test::OverBlock(-4);
  X.R_AB = glm::angleAxis(1.5, Vec3(0, 0, 1)) * X.R_AB;
  const double slew_Nmm = setup.profile.peak_torque_Nmm / 5;
  Vec3 before = loop.Step(0).out.force.tau_H_W_Nmm;
  loop.device().SetIntention({.X_WH = X});
  double max_Nmm = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 tau = loop.Step(0).out.force.tau_H_W_Nmm;
    max_Nmm = std::max(max_Nmm, glm::length(tau - before));
    before = tau;
  }
  EXPECT_LE(max_Nmm, slew_Nmm * (1 + 1e-9));
  EXPECT_GT(max_Nmm, 0.99 * slew_Nmm);
}

TEST(ClosedLoop, RefusesParametersOutOfRange) {
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
