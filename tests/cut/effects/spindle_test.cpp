// The spindle in the tick: its speed in air, under load, stalled and free again, and with hands that push too hard.
#include "cut/effects/spindle/spindle.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "base/core/heap_guard.h"
#include "cut/effects/plan.h"
#include "cut/effects/tangential_force.h"
#include "cut/hand_sim/hands.h"
#include "cut/hand_sim/internals.h"
#include "experiment/stability/closed_loop.h"
#include "experiment/stability/held_block.h"
#include "experiment/stability/measures.h"
#include "kerf/error.h"
#include "support/message_of.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;

void TurnOn(EffectChoices& effects, double stall_torque_Nmm = 300) {
  effects.emplace_back("tangential_force");
  SetEffect(effects, "spindle", "stall_torque_Nmm", stall_torque_Nmm);
}

CoupledParams Params(double stall_torque_Nmm = 300) {
  CoupledParams params = test::DiscParams();
  params.law = ForceLaw("hertz_chip");
  TurnOn(params.effects, stall_torque_Nmm);
  return params;
}

const SpindleEffect& SpindleOf(const EffectPlan& plan) {
  return SpindleEffect::In(plan);
}

/// Returns the sum of thrusts at which a motor stalls: thrust / ratio times the radius equals the motor's remaining
/// torque.
double StallThrust(double stall_torque_Nmm) {
  return 1.6 * (stall_torque_Nmm - 5) / kR;
}

TEST(Spindle, NeedsTheTangentialForce) {
  EffectChoices effects{EffectChoice("spindle")};
  EXPECT_THAT(test::MessageOf([&] { CheckEffects(effects); }),
              testing::HasSubstr("spindle needs the effect tangential_force"));
}

TEST(Spindle, RunsUpAndDownInTheAirForAnyTick) {
  for (const double dt_s : {0.00025, 0.001, 0.0101, 1.0}) {
    for (const double rpm : {7500.0, -60000.0}) {
      CoupledSimulation simulation(test::MakeBox(Pose{}, {4, 4, 4}, 0.4), Params(), DiscPose(Pose{}, {0, 0, 60}));
      const SpindleEffect& spindle = SpindleOf(EffectsOf(simulation));
      Motor motor = spindle.motor();
      const double set = rpm * std::numbers::pi / 30;
      motor.no_load_rad_per_s = std::abs(set);
      EXPECT_EQ(spindle.rpm(), 0);
      double t_s = 0;
      for (int i = 0; i < 40; ++i) {
        t_s += dt_s;
        const CoupledOutput out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, 60}), rpm, dt_s));
        EXPECT_EQ(out.status & kCoupledSpindleStopped, 0u);
        ASSERT_NEAR(spindle.rpm(), RunMotor(motor, set, 0, 0, 0, t_s).w_rad_per_s * 30 / std::numbers::pi,
                    1e-9 * std::abs(rpm));
      }
      const double from = spindle.rpm() * std::numbers::pi / 30;
      t_s = 0;
      for (int i = 0; i < 40; ++i) {
        t_s += dt_s;
        simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, 60}), 0, dt_s));
        ASSERT_NEAR(spindle.rpm(), RunMotor(motor, 0, 0, 0, from, t_s).w_rad_per_s * 30 / std::numbers::pi,
                    1e-9 * std::abs(rpm));
      }
      if (dt_s > 0.01) {
        EXPECT_EQ(spindle.rpm(), 0);
        EXPECT_NE(simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, 60}), 0, dt_s)).status & kCoupledSpindleStopped, 0u);
      }
      EXPECT_FALSE(spindle.stalled());
    }
  }
}

/// A tool on a path that cuts a kerf 3 mm deep.
struct Slot {
  explicit Slot(double stall_torque_Nmm, double voxel_mm = 0.4)
      : simulation(test::MakeBox(Pose{}, {60, 3, 10}, voxel_mm), MakeParams(stall_torque_Nmm), At(-42)) {}
  static SimulationParams MakeParams(double stall_torque_Nmm) {
    SimulationParams params;
    params.law = ForceLaw("hertz_chip");
    TurnOn(params.effects, stall_torque_Nmm);
    return params;
  }
  static Pose At(double x) { return DiscPose(Pose{}, {x, 0, 5 + kR - 3}); }
  TickOutput Feed(double mm_per_s, double rpm, double dt_s = 0.001) {
    x += mm_per_s * dt_s;
    return simulation.Tick({At(x), dt_s, rpm});
  }
  Simulation simulation;
  double x = -42;
};

TEST(Spindle, SlowsDownUnderLoadAlongItsCharacteristic) {
  for (const double rpm : {7500.0, -7500.0}) {
    Slot slot(300);
    const SpindleEffect& spindle = SpindleOf(EffectsOf(slot.simulation));
    TickOutput out;
    MotorRun run;
    double load_mJ = 0, cut_mJ = 0;
    for (int i = 0; i < 5000; ++i) {
      out = slot.Feed(5, rpm);
      load_mJ += spindle.run().load_mJ;
      cut_mJ += TangentialForceEffect::In(EffectsOf(slot.simulation)).figures().power_W;  // W times 1 ms = mJ
    }
    const double torque = kR * out.thrust_sum_N / 1.6;
    EXPECT_GT(torque, 20);
    // 0.5 % allows for the variation of the engaged arc from tick to tick due to the voxels.
    EXPECT_NEAR(spindle.load_Nmm(), torque, 0.005 * torque);
    const double w = std::abs(spindle.rpm()) * std::numbers::pi / 30;
    const Motor& m = spindle.motor();
    EXPECT_NEAR(m.CalcTorque(7500 * std::numbers::pi / 30, w), torque + m.friction_Nmm + m.viscous_Nmms * w,
                0.005 * torque);
    EXPECT_EQ(spindle.rpm() > 0, rpm > 0);
    EXPECT_LT(std::abs(spindle.rpm()), 7200);
    // The motor's work on the load equals the teeth's work, except for a lag of one tick.
    EXPECT_NEAR(load_mJ, cut_mJ, 0.002 * cut_mJ);
    std::vector<double> channels(EffectsOf(slot.simulation).channel_count());
    EffectsOf(slot.simulation).Report(channels);
    EXPECT_EQ(channels[4], spindle.rpm());
    EXPECT_EQ(channels[5], spindle.load_Nmm());
    EXPECT_NEAR(channels[6], 1e-3 * w * m.CalcTorque(7500 * std::numbers::pi / 30, w), 0.005 * channels[6]);
    EXPECT_EQ(channels[7], 0);
  }
}

TEST(Spindle, StalledOnAPathCutsNothingUntilSwitchedOff) {
  Slot slot(20);
  const SpindleEffect& spindle = SpindleOf(EffectsOf(slot.simulation));
  int stalls = 0;
  for (int i = 0; i < 3000; ++i) {
    const bool was = spindle.stalled();
    const TickOutput out = slot.Feed(10, 7500);
    stalls += spindle.stalled() && !was;
    if (spindle.stalled()) {  // including the tick in which it stalls: in the rest of that turn the bite could have any
                              // value
      EXPECT_EQ(out.removed_mm3, 0);
      EXPECT_EQ(out.thrust_sum_N, 0);
    }
  }
  EXPECT_EQ(stalls, 1);
  EXPECT_TRUE(spindle.stalled());
  for (int i = 0; i < 10; ++i) slot.Feed(0, 0);
  EXPECT_FALSE(spindle.stalled());
  for (int i = 0; i < 200; ++i) slot.Feed(0, 7500);
  EXPECT_GT(spindle.rpm(), 4000);  // 4700 at most: the motor's 20 N mm act against losses of at least 5 N mm
}

TEST(Spindle, BiteOfADrillThatStallsOnAPathIsTheFeedSinceALipLastPassed) {
  SimulationParams params;
  const TwistDrill drill{.diameter_mm = 2};
  params.tool = drill;
  params.law = ForceLaw("two_component");
  TurnOn(params.effects, 15);
  Pose X_WT{.R_AB = {1, 0, 0, 0}, .p_AB = {0, 0, 6.05}};
  Simulation simulation(test::MakeBox(Pose{}, {12, 12, 12}, 0.4), params, X_WT);
  const SpindleEffect& spindle = SpindleOf(EffectsOf(simulation));
  constexpr double kFeed_mm_per_s = 0.5;
  constexpr double kDt_s = 0.001;
  const double outwards_mm_per_s = kFeed_mm_per_s * std::sin(0.5 * drill.point_angle_deg / kDegreesPerRad);
  double since_s = 0;
  double steady_um = 0;  // of the last tick
  double bite_um = 0;
  for (int i = 0; i < 2000 && !spindle.stalled(); ++i) {
    X_WT.p_AB.z -= kFeed_mm_per_s * kDt_s;
    const TickOutput out = simulation.Tick({X_WT, kDt_s, 1000});
    const double passes_per_s = 2 * spindle.run().angle_rad / (2 * std::numbers::pi) / kDt_s;
    constexpr int kSteps = 1000;
    double mean_s = 0;
    for (int k = 0; k < kSteps; ++k) {
      mean_s += since_s / kSteps;
      since_s += kDt_s / kSteps * (1 - since_s * passes_per_s);
    }
    if (out.engaged_teeth < 0.5) continue;  // later than a few passes after the motor has run up
    bite_um = 1000 * out.mean_bite_mm;
    // Euler's method with steps of 1 us has an error of 1 us / T, and T is 30 ms.
    ASSERT_NEAR(bite_um, 1000 * outwards_mm_per_s * mean_s, 0.001 * bite_um) << i;
    steady_um = 1000 * outwards_mm_per_s / passes_per_s;
  }
  EXPECT_TRUE(spindle.stalled());
  EXPECT_GT(steady_um, 2 * bite_um) << "the feed over the speed, which has no bound";
}

// ---- in a hand

/// A saw that is pushed straight down into a long block. The handle keeps its orientation and its x and y, which
/// resists the sideways pull.
struct Pushed {
  explicit Pushed(const CoupledParams& params, double voxel_mm = 0.4)
      : simulation(test::MakeBox(Pose{}, {60, 3, 60}, voxel_mm), params, Start()),
        spindle(SpindleOf(EffectsOf(simulation))) {
    out.X_WT = Start();
  }
  static Pose Start() { return DiscPose(Pose{}, {0, 0, 30 + kR}); }
  const CoupledOutput& Push(double force_N, double rpm = 7500, double dt_s = 0.001, double tilt_rad = 0) {
    Pose X = DiscPose(Pose{}, {0, 0, out.X_WT.p_AB.z - force_N / simulation.params().coupling.stiffness_N_per_mm});
    X.R_AB = X.R_AB * glm::angleAxis(tilt_rad, Vec3(1, 0, 0));
    const bool was = spindle.stalled();
    const HeapGuard guard;
    out = simulation.Tick(Handle(X, rpm, dt_s));
    stalls += spindle.stalled() && !was;
    starts += !spindle.stalled() && was;
    hand_mJ += out.hand_mJ;
    spindle_mJ += out.spindle_mJ;
    max_mJ = std::max(max_mJ, std::abs(hand_mJ) + spindle_mJ);
    EXPECT_GE(hand_mJ + spindle_mJ, -1e-7 * (1 + max_mJ));
    EXPECT_TRUE(IsValid(out.X_WT) && std::isfinite(glm::length(out.f_H_W_N)) && std::isfinite(spindle.rpm()));
    return out;
  }
  CoupledSimulation simulation;
  const SpindleEffect& spindle;
  CoupledOutput out;
  int stalls = 0, starts = 0;
  double hand_mJ = 0, spindle_mJ = 0, max_mJ = 0;
};

TEST(Spindle, StallsUnderARisingPushAndRestartsWhenReleased) {
  for (const double rpm : {7500.0, -7500.0}) {
    Pushed saw(Params(100));
    double push_N = 0, last_rpm = 1e9, thrust_at_stall_N = 0;
    int rises = 0;
    for (int i = 0; i < 3000 && !saw.spindle.stalled(); ++i) {
      push_N = 0.01 * i;
      saw.Push(push_N, rpm);
      // Once the spindle has reached its speed, it only slows down.
      if (i > 100 && std::abs(saw.spindle.rpm()) > last_rpm + 1) ++rises;
      last_rpm = std::abs(saw.spindle.rpm());
      if (saw.out.thrust_sum_N > 0) thrust_at_stall_N = saw.out.thrust_sum_N;
    }
    ASSERT_TRUE(saw.spindle.stalled());
    EXPECT_EQ(rises, 0);
    // 2 % allows for the lag of 4 ms, in which the push grows by 0.04 N, and for a few more ms at the steep end of the
    // characteristic.
    EXPECT_NEAR(thrust_at_stall_N, StallThrust(100), 0.02 * StallThrust(100));
    // A stalled tool acts as a solid: it cuts nothing, does not move, and bears the push.
    const double z = saw.out.X_WT.p_AB.z;
    for (int i = 0; i < 500; ++i) {
      saw.Push(push_N, rpm);
      EXPECT_EQ(saw.out.removed_mm3, 0);
      EXPECT_EQ(saw.spindle.rpm(), 0);
      EXPECT_NE(saw.out.status & kCoupledSpindleStopped, 0u);
    }
    EXPECT_NEAR(saw.out.X_WT.p_AB.z, z, 0.07);  // a sixth of a voxel: the edge settles on the uneven floor
    EXPECT_NEAR(saw.out.f_H_W_N.z, push_N, 0.05 * push_N);
    // The hand lets go; the spindle starts when the pressure requires at most 0.7 of its available torque.
    double hold_at_start = 0, push_at_start_N = 0;
    for (int i = 0; i < 3000; ++i) {
      push_N = std::max(0.5, push_N - 0.01);
      const double hold = saw.spindle.hold_Nmm();
      saw.Push(push_N, rpm);
      if (saw.starts == 1 && push_at_start_N == 0) push_at_start_N = push_N, hold_at_start = hold;
    }
    EXPECT_EQ(saw.stalls, 1);
    EXPECT_EQ(saw.starts, 1);
    EXPECT_NEAR(hold_at_start, 0.7 * 95, 0.02 * 95);
    EXPECT_GT(push_at_start_N, 1);
    EXPECT_GT(std::abs(saw.spindle.rpm()), 6000);
    const double removed = saw.out.removed_mm3;
    EXPECT_GT(removed, 0);
  }
}

TEST(Spindle, DoesNotFlutterBetweenTurningAndStall) {
  // Constant pushes close to the stalling push, with variations within the hysteresis; straight and tilted, with and
  // without the flats' friction, which adds to the load.
  std::string table = "push / stall, tilt mrad: stalls, starts\n";
  for (const bool friction : {true, false}) {
    for (const double tilt : {0.0, 0.01}) {
      for (const double fraction : {0.9, 1.05, 1.1, 1.15, 1.2, 1.25, 1.3, 2.0}) {
        CoupledParams params = Params(100);
        if (!friction) RemoveEffect(params.effects, "kerf_friction");
        Pushed saw(params);
        for (int i = 0; i < 400; ++i) saw.Push(4, 7500, 0.001, 0);
        saw.stalls = saw.starts = 0;
        for (int i = 0; i < 2000; ++i) {
          const double ramp = std::min(1.0, i / 300.0);
          saw.Push(4 + ramp * (fraction * StallThrust(100) * (1 + 0.05 * std::sin(0.02 * i)) - 4), 7500, 0.001,
                   ramp * tilt);
        }
        table += fmt::format("{:.2f} {:2.0f} {}: {} {}\n", fraction, 1e3 * tilt, friction, saw.stalls, saw.starts);
        EXPECT_LE(saw.stalls, 1) << fraction << " " << tilt << " " << friction;
        EXPECT_LE(saw.starts, 1) << fraction << " " << tilt << " " << friction;
      }
    }
  }
  std::puts(table.c_str());
}

TEST(Spindle, SpeedAndStallsStayBoundedForAnyTick) {
  for (const double dt_s : {0.0001, 0.004, 0.03, 0.3, 1.0}) {
    for (const double push_N : {5.0, 13.0, 16.0, 30.0}) {
      Pushed saw(Params(100));
      for (int i = 0; i < 300; ++i) saw.Push(push_N, i < 150 ? 7500 : -7500, dt_s);
      EXPECT_LE(std::abs(saw.spindle.rpm()), 7500);
      EXPECT_LE(saw.stalls, 2) << dt_s << " " << push_N;
    }
  }
}

TEST(Spindle, RandomHandsAndSwitchingCreateNoEnergy) {
  // For any hand and motor, and however the spindle is switched, no energy is created, the heap is not used and all
  // values are finite.
  for (int seed = 0; seed < 16; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed) * 131 + 7);
    const auto log_uniform = [&](double lower, double upper) {
      return std::exp(std::uniform_real_distribution<double>(std::log(lower), std::log(upper))(random));
    };
    CoupledParams params = Params(log_uniform(1, 1000));
    SetEffect(params.effects, "tangential_force", "ratio", log_uniform(0.6, 5));
    SetEffect(params.effects, "spindle", "inertia_gmm2", log_uniform(1, 1e5));
    SetEffect(params.effects, "spindle", "no_load_rpm", seed % 3 == 0 ? 10000.0 : 0.0);
    SetEffect(params.effects, "spindle", "brakes", EffectValue(seed % 2 == 0));
    SetEffect(params.effects, "spindle", "restart_share", log_uniform(0.2, 1));
    params.coupling.stiffness_N_per_mm = log_uniform(0.2, 100);
    const double dts[] = {0.00025, 0.001, 0.004, 0.1};
    const double dt_s = dts[random() % 4];
    Pushed saw(params);
    std::normal_distribution<double> normal;
    double push = 5, tilt = 0;
    for (int i = 0; i < 1500; ++i) {
      push = std::clamp(push + normal(random), -5.0, 60.0);
      tilt = 0.98 * tilt + 0.002 * normal(random);
      const double set[] = {7500, 0, -3000, 60000};
      saw.Push(push, set[i / 300 % 4], dt_s, tilt);
      const MotorRun& run = saw.spindle.run();
      ASSERT_GE(run.load_mJ, 0);
      ASSERT_TRUE(std::isfinite(run.motor_mJ));
      if (saw.spindle.stalled()) {
        ASSERT_EQ(saw.spindle.rpm(), 0);
      }
    }
  }
}

TEST(Spindle, HandOnADeviceCanStallItAndContinue) {
  // The hand pushes harder and harder, keeps pushing while the spindle is stalled, and then lets go.
  std::string table = "device hand: stalls, starts, force above 20 Hz while stalled mN, largest step N\n";
  for (const char* device : {"omega_6", "omega_3"}) {
    for (const char* hand : {"H1", "H2", "H3", "H4"}) {
      ClosedLoopSetup setup = test::HeldBlock(device, hand);
      const double scale = ForceMap(setup.profile, setup.force_map).force_scale();
      TurnOn(setup.coupled.effects, 60);
      const Pose start = test::OverBlock(0.05);
      ClosedLoop loop(test::BlockOfBone(0.4, {80, 4, 40}), setup, start);
      const SpindleEffect& spindle = SpindleOf(EffectsOf(loop.simulation()));
      const double max_N = 1.6 * StallThrust(60) * scale;
      std::vector<IntentionStep> steps(3);
      steps[0] = {.seconds = 2.5, .X_WH = start, .push_W_N = Vec3(0, 0, -max_N), .yield_s = 0.3, .push_on_s = 2.3};
      steps[1] = {.seconds = 1.2, .X_WH = start, .push_W_N = Vec3(0, 0, -max_N), .yield_s = 0.3};
      steps[2] = {.seconds = 2, .X_WH = start, .push_W_N = Vec3(0, 0, -0.1 * max_N), .yield_s = 0.3, .push_on_s = 1};
      loop.device().SetScript(IntentionScript(start, steps));
      int stalls = 0, starts = 0;
      double max_step_N = 0, removed_after = 0;
      std::vector<Vec3> held;
      Vec3 before(0);
      ClosedLoopTick tick;
      for (int i = 0; i < 5700; ++i) {
        const bool was = spindle.stalled();
        tick = loop.Step(7500);
        stalls += spindle.stalled() && !was;
        starts += !spindle.stalled() && was;
        max_step_N = std::max(max_step_N, glm::length(tick.f_device_N - before));
        before = tick.f_device_N;
        if (i >= 2900 && i < 3700) {
          EXPECT_TRUE(spindle.stalled()) << device << " " << hand << " " << i;
          held.push_back(tick.f_device_N);
        }
        if (i >= 4700) removed_after += tick.out.coupled.removed_mm3;
        ASSERT_GE(tick.energy.motor_mJ + tick.energy.spindle_mJ, -1e-3 - 2e-3 * tick.energy.exchanged_mJ) << i;
      }
      const double noise_mN = 1e3 * CalcNoise(held, setup.period_s);
      table += fmt::format("{} {}: {} {} {:.2f} {:.3f}\n", device, hand, stalls, starts, noise_mN, max_step_N);
      EXPECT_EQ(stalls, 1) << device << " " << hand;
      EXPECT_EQ(starts, 1) << device << " " << hand;
      // At a stall and at a start the motor keeps pushing: the sideways pull remains, and only the edge's friction
      // changes.
      EXPECT_LE(max_step_N, 0.06 * max_N + 0.1) << device << " " << hand;
      EXPECT_LE(noise_mN, 20) << device << " " << hand;
      EXPECT_GT(removed_after, 0);
      EXPECT_GT(spindle.rpm(), 4000);
    }
  }
  std::puts(table.c_str());
}

}  // namespace
}  // namespace kerf
