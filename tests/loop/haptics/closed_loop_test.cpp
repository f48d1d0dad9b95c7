// Tests of the complete tick with a hand: energy at the handle, and faults of the handle, the device and the clock.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "base/core/heap_guard.h"
#include "loop/haptics/held_saw.h"

namespace kerf {
namespace {

using test::HeldSaw;
using test::HeldSawOptions;
using test::kDt_s;
using test::Upright;

/// Energy that the handle supplied to the motors, compared with the limit for a passive tool behind a sampled spring.
struct Energy {
  double port_mJ = 0;       // from the true motion of the handle
  double lowest_mJ = 0;     // lowest value over time of port + sampling + spindle
  double sampling_mJ = 0;   // sum of K dx^2 / 2: energy that a spring force held over a tick can return
  double exchanged_mJ = 0;  // sum of |F . dx|
  double spindle_mJ = 0;
  double max_hand_N = 0;
};

Energy Follow(HeldSaw& saw, double K, int ticks, double rpm) {
  Energy e;
  Vec3 before = saw.device.p_WC_mm();
  for (int i = 0; i < ticks; ++i) {
    const Vec3 f = saw.device.force_N();
    const HapticTick out = saw.Step(rpm);
    const Vec3 moved = saw.device.p_WC_mm() - before;
    before = saw.device.p_WC_mm();
    e.exchanged_mJ += std::abs(glm::dot(f, moved));
    const bool touches = f != Vec3{0} || out.force.f_H_W_N != Vec3{0};
    if (touches) e.sampling_mJ += 0.5 * K * glm::dot(moved, moved);
    e.spindle_mJ += out.coupled.spindle_mJ;
    e.port_mJ = saw.device.port_mJ();
    e.lowest_mJ = std::min(e.lowest_mJ, e.port_mJ + e.sampling_mJ + e.spindle_mJ);
    e.max_hand_N = std::max(e.max_hand_N, glm::length(out.force.f_H_W_N));
  }
  return e;
}

// A spring whose force is held over a tick returns up to K dx^2 / 2 more than it received: this is due to sampling, not
// to the tool. Bone that a stopped saw is pressed against, rubbed along and released from must not return more.
TEST(ClosedLoop, StoppedSawReturnsNoExcessEnergy) {
  for (const char* hand : {"H2", "H3", "H4"}) {
    HeldSawOptions options;
    options.hand = hand;
    options.quantise = false;
    options.force_map.ramp_in_s = 0;
    HeldSaw saw(options);
    // The saw moves slowly into the top of the block, along it and out of it, so that the energy from sampling is
    // small.
    std::vector<IntentionStep> steps;
    for (int i = 0; i < 6; ++i) {
      const double x = i % 2 == 0 ? 3 : -3;
      steps.push_back(
          {.seconds = 1.5, .X_WH = Upright(Vec3(x, 0.5 * i, 11 - 4)), .saw_W_mm = Vec3(0.5, 0.5, 0.5), .saw_Hz = 2});
      steps.push_back({.seconds = 0.8, .X_WH = Upright(Vec3(x, 0, 11 + 1))});
    }
    saw.device.SetScript(IntentionScript(saw.start, steps));
    const Energy e = Follow(saw, options.stiffness_N_per_mm, 14000, 0);
    EXPECT_GT(e.max_hand_N, 0.4) << hand;  // there has been contact
    EXPECT_GT(e.exchanged_mJ, 2) << hand;
    EXPECT_GE(e.lowest_mJ, -1e-3) << hand;  // 1e-6 J
    fmt::print("stopped {}: port {:.3f} mJ, exchanged {:.1f}, sampling may give {:.3f}\n", hand, e.port_mJ,
               e.exchanged_mJ, e.sampling_mJ);
  }
}

TEST(ClosedLoop, ARunningSawGivesNoMoreThanItsSpindlePutIn) {
  for (const char* hand : {"H2", "H4"}) {
    HeldSawOptions options;
    options.hand = hand;
    options.quantise = false;
    options.force_map.ramp_in_s = 0;
    HeldSaw saw(options);
    std::vector<IntentionStep> steps;
    // The saw moves down, is pressed against one wall of the kerf, where the turning disc's friction pulls the hand
    // along, and moves up.
    for (int i = 0; i < 3; ++i) {
      const double z = 11 - 2 - i;
      const double y = i % 2 == 0 ? 3 : -3;
      steps.push_back({.seconds = 1.2, .X_WH = Upright(Vec3(0.5 * i, 0, z)), .saw_W_mm = Vec3(2, 0, 0), .saw_Hz = 2});
      steps.push_back({.seconds = 0.4, .X_WH = Upright(Vec3(0.5 * i, y, z))});
      steps.push_back({.seconds = 0.4, .X_WH = Upright(Vec3(0.5 * i, y, z)), .saw_W_mm = Vec3(1, 0, 0), .saw_Hz = 5});
      steps.push_back({.seconds = 0.4, .X_WH = Upright(Vec3(0, 0, z))});
      steps.push_back({.seconds = 0.6, .X_WH = Upright(Vec3(0, 0, 11 + 0.5))});
    }
    saw.device.SetScript(IntentionScript(saw.start, steps));
    const Energy e = Follow(saw, options.stiffness_N_per_mm, 9000, 7500);
    EXPECT_GT(e.spindle_mJ, 0.02) << hand;  // friction pulled the hand along
    EXPECT_GT(e.port_mJ, 0.2) << hand;
    EXPECT_GE(e.lowest_mJ, -1e-3) << hand;
    fmt::print("running {}: port {:.3f} mJ, exchanged {:.1f}, spindle {:.3f}, sampling may give {:.3f}\n", hand,
               e.port_mJ, e.exchanged_mJ, e.spindle_mJ, e.sampling_mJ);
  }
}

/// Pushes with 5 N for 1.5 s, then calls `disturb(i, saw, dt, off)` in each of `disturbed_ticks` ticks, then continues
/// for 2.5 s. Checks the bounds in every tick.
template <typename Disturb>
HapticTick PushThrough(HeldSaw& saw, int disturbed_ticks, Disturb&& disturb, double* lowest_during = nullptr) {
  IntentionStep push;
  push.seconds = 10;
  push.X_WH = saw.start;
  push.push_W_N = Vec3(0, 0, -5);
  push.yield_s = 0.5;
  saw.device.SetScript(IntentionScript(saw.start, {push}));
  const double peak = saw.device.profile().peak_force_N;
  const double slew = peak / 0.005;
  Vec3 before{0};
  HapticTick out;
  double lowest = 1e9;
  for (int i = -1500; i < disturbed_ticks + 2500; ++i) {
    double dt = kDt_s;
    bool off = false;
    if (i >= 0 && i < disturbed_ticks) {
      disturb(i, saw, dt, off);
    } else {
      saw.device.SetFaults({});
    }
    out = saw.Step(7500, dt, off);
    const Vec3 f = out.force.f_H_W_N;
    EXPECT_TRUE(std::isfinite(f.x) && std::isfinite(f.y) && std::isfinite(f.z)) << i;
    EXPECT_LE(glm::length(f), peak) << i;
    // A fault sets the force to zero at once. All other changes respect the slew limit.
    if (out.faults == kHapticOk) {
      EXPECT_LE(glm::length(f - before), slew * std::min(dt, 0.1) * (1 + 1e-9)) << i;
    } else {
      EXPECT_EQ(f, Vec3{0}) << i;
    }
    if (i >= 0 && i < disturbed_ticks) lowest = std::min(lowest, glm::length(f));
    before = f;
  }
  if (lowest_during != nullptr) *lowest_during = lowest;
  return out;
}

/// Checks that the saw cuts again, with the hand's push (minus the pull of its spring).
void ExpectCutsAgain(const HapticTick& out, const char* what) {
  EXPECT_EQ(out.faults, kHapticOk) << what;
  EXPECT_NEAR(out.force.f_H_W_N.z, 5, 1) << what;
  EXPECT_GT(out.coupled.thrust_sum_N, 3) << what;
}

TEST(ClosedLoop, SurvivesAHandleThatJumps) {
  for (const Vec3& jump : {Vec3(0, 0, -20), Vec3(0, 3, 0), Vec3(0, 20, 0), Vec3(100, 0, 30), Vec3(0, 0, 5)}) {
    HeldSawOptions options;
    options.block_mm = Vec3(40, 24, 26);
    HeldSaw saw(options);
    const HapticTick out =
        PushThrough(saw, 10, [&](int, HeldSaw& s, double&, bool&) { s.device.SetFaults({.jump_mm = jump}); });
    // A jump of 20 mm sideways moves the saw out of the kerf and the hand off the block.
    if (jump.y != 20) ExpectCutsAgain(out, "jump");
  }
}

TEST(ClosedLoop, SurvivesSamplesThatFreeze) {
  HeldSaw saw;
  ExpectCutsAgain(PushThrough(saw, 100, [](int, HeldSaw& s, double&, bool&) { s.device.SetFaults({.frozen = true}); }),
                  "frozen");
}

TEST(ClosedLoop, NaNReadFailureAndWatchdogGiveZeroForceAndThenARamp) {
  const char* names[] = {"nan", "read", "write", "off"};
  for (int kind = 0; kind < 4; ++kind) {
    HeldSaw saw;
    double lowest = 1;
    bool all_zero = true;
    const HapticTick out = PushThrough(
        saw, 30,
        [&](int i, HeldSaw& s, double&, bool& off) {
          if (kind == 0) s.device.SetFaults({.not_a_number = true});
          if (kind == 1) s.device.SetFaults({.read_fails = true});
          if (kind == 2) s.device.SetFaults({.write_fails = true});
          off = kind == 3;
          // The force of the motors in the previous tick. A failed write shows one tick later.
          if (i >= 1) all_zero = all_zero && s.device.force_N() == Vec3{0};
        },
        &lowest);
    EXPECT_TRUE(all_zero) << names[kind];
    EXPECT_EQ(lowest, 0) << names[kind];
    ExpectCutsAgain(out, names[kind]);
  }
}

TEST(ClosedLoop, SurvivesLateAndMissedTicks) {
  for (const double gap_s : {0.005, 0.010, 0.050, 0.2}) {
    HeldSaw saw;
    ExpectCutsAgain(PushThrough(saw, 60,
                                [&](int i, HeldSaw&, double& dt, bool&) {
                                  if (i % 20 == 0) dt = gap_s;
                                }),
                    "late");
  }
}

TEST(ClosedLoop, AllocatesNothing) {
  HeldSaw saw;
  IntentionStep push;
  push.seconds = 1;
  push.X_WH = saw.start;
  push.push_W_N = Vec3(0, 0, -5);
  saw.device.SetScript(IntentionScript(saw.start, {push}));
  HeapUseCounter counter;
  double thrust = 0;
  for (int i = 0; i < 1000; ++i) {
    const HeapGuard guard;
    thrust = saw.Step().coupled.thrust_sum_N;
  }
  EXPECT_GT(thrust, 1);
  EXPECT_EQ(counter.count(), 0);
}

TEST(ClosedLoop, TheSameCallsGiveTheSameBits) {
  const auto run = [] {
    HeldSawOptions options;
    options.damping_Ns_per_mm = 0.0005;
    HeldSaw saw(options);
    saw.device.SetScript(IntentionScript(
        saw.start, {{.seconds = 1, .X_WH = Upright(Vec3(1, 0.2, 9)), .saw_W_mm = Vec3(1, 0, 0.3), .saw_Hz = 5}}));
    Vec3 f{0};
    double sum = 0;
    for (int i = 0; i < 1000; ++i) {
      f = saw.Step().force.f_H_W_N;
      sum += glm::dot(f, Vec3(1, 2, 3));
    }
    return sum;
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace kerf
