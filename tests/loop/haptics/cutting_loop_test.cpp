// Tests of the complete loop: a simulated hand cuts into a block while another thread reads the bone and meshes it.
// Also run under ThreadSanitizer.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>

#include "base/core/heap_guard.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "device/devices/profiles.h"
#include "device/devices/simulated_device.h"
#include "kerf/surface.h"
#include "loop/haptics/bone_mirror.h"
#include "loop/haptics/haptic_loop.h"
#include "loop/haptics/step_body.h"

namespace kerf {
namespace {

Bone MakeSmallBlock() {
  BlockParams params;
  params.size_mm = {10, 10, 8};
  params.voxel_mm = 0.25;
  return MakeBlock(params, DefaultMandibleTable());
}

/// A disc in the y-z plane above a block, which a hand lowers at 8 mm/s and lifts again after one second.
struct CuttingStage {
  struct Hand : HandDriver {
    explicit Hand(SimulatedDevice& the_device, const Pose& X_start) : device(the_device), X(X_start) {}
    void Advance(double dt_s) noexcept override {
      t_s += dt_s;
      X.p_AB.z += (t_s < turn_s ? -8 : t_s < stop_s ? 8 : 0) * dt_s;
      if (t_s < stop_s) device.SetIntention({.X_WH = X});
      device.SetFaults({.not_a_number = t_s >= nan_from_s && t_s < nan_to_s});
    }
    SimulatedDevice& device;
    Pose X;
    double t_s = 0;
    double turn_s = 0.7;
    double stop_s = 1;
    double nan_from_s = 1e9;
    double nan_to_s = 1e9;
  };

  explicit CuttingStage(double slew_N_per_s = 1000)
      : simulation(MakeSmallBlock(), MakeParams(), Start()),
        simulated(FindDeviceProfile("omega_6"), FindHandModel("H4"), Start()),
        device(simulated),
        hand(simulated, Start()),
        body(simulation, device, MakeBodyParams(slew_N_per_s), &hand) {}

  static Pose Start() {
    // The tool's z is along x, so the disc is in the y-z plane.
    return {Quat(std::sqrt(0.5), 0, std::sqrt(0.5), 0), Vec3(0.1, 0, 6)};
  }
  static CoupledParams MakeParams() {
    CoupledParams params;
    DiscSaw saw;
    saw.diameter_mm = 10;
    saw.thickness_mm = 0.5;
    saw.teeth = 12;
    params.tool = saw;
    params.coupling.stiffness_N_per_mm = 2;
    return params;
  }
  static StepBodyParams MakeBodyParams(double slew_N_per_s) {
    StepBodyParams params;
    params.force_map.slew_N_per_s = slew_N_per_s;
    params.force_map.ramp_in_s = 0.1;
    return params;
  }

  CoupledSimulation simulation;
  SimulatedDevice simulated;
  GuardedDevice device;
  Hand hand;
  StepBody body;
};

TEST(CuttingLoop, AReaderThatMeshesEndsUpWithTheSameBone) {
  CuttingStage s;
  const Bone before = MakeSmallBlock();
  MonotonicClock clock;
  LoopParams params;
  params.lock_memory = false;
  HapticLoop loop(s.body, s.device, clock, params);
  BoneMirror mirror(before, loop.leaves());
  std::atomic<bool> done{false};
  std::size_t triangles = 0;
  std::uint64_t seen = 0;
  std::thread renderer([&] {
    while (!done) {
      if (mirror.Update() > 0) triangles += ExtractSurface(mirror.bone()).triangles.size();
      if (loop.state().Update()) seen = loop.state().front().last.number;
      while (loop.samples().Peek() != nullptr) loop.samples().Pop();
    }
  });
  loop.Start();
  // Waits until the hand has rested for a while and no leaf is waiting.
  while (loop.running() && loop.tick_times().total() < 1500) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  loop.Stop();
  done = true;
  renderer.join();
  while (loop.SendRemaining()) mirror.Update();
  mirror.Update();
  EXPECT_GT(triangles, 0U);
  EXPECT_GT(seen, 0U);
  EXPECT_GT(loop.counts().removed_mm3, 1);
  EXPECT_EQ(loop.counts().not_finite, 0U);
  EXPECT_EQ(mirror.bone().CalcHash(), s.simulation.UpdateBone().CalcHash());
  EXPECT_NE(mirror.bone().CalcHash(), before.CalcHash());
}

TEST(CuttingLoop, ToolStaysAtItsStartUntilTheFirstReading) {
  CuttingStage s;
  s.hand.nan_from_s = 0;
  s.hand.nan_to_s = 0.01;
  struct NoObserver : TickObserver {
    void Enter(TickStage) noexcept override {}
  } observer;
  LoopTick tick;
  for (int i = 0; i < 5; ++i) {
    s.body.Tick(0.001, observer, tick);
    EXPECT_NE(tick.faults & kHapticBadSample, 0);
    EXPECT_EQ(tick.coupled.X_WT.p_AB, CuttingStage::Start().p_AB);
    EXPECT_EQ(tick.coupled.X_WT.R_AB, CuttingStage::Start().R_AB);
  }
}

TEST(CuttingLoop, UsesNoHeapAndGivesTheSameBitsTwice) {
  std::optional<std::uint64_t> hash;
  for (int run = 0; run < 2; ++run) {
    CuttingStage s;
    VirtualClock clock;
    const HeapUseCounter heap;
    HapticLoop loop(s.body, s.device, clock, LoopParams{});
    loop.RunHere(1200);
    EXPECT_EQ(heap.count(), 0);
    EXPECT_GT(loop.counts().removed_mm3, 1);
    const std::uint64_t now = s.simulation.UpdateBone().CalcHash();
    EXPECT_EQ(now, hash.value_or(now));
    hash = now;
  }
}

TEST(CuttingLoop, MissedTicksMakeNoLargerForceStepThanTheSlewAllows) {
  // The loop stalls for up to 40 ticks during the cut, and the slew rate is so low, 0.02 N per tick, that the force
  // would exceed it.
  CuttingStage s(20);
  struct Stumbling : LoopClock {
    std::int64_t Now() noexcept override { return inner.Now(); }
    void SleepUntil(std::int64_t time_ns) noexcept override {
      ++sleeps;
      inner.SleepUntil(time_ns + (sleeps % 37 == 0 ? sleeps % 41 * 1'000'000 : 0));
    }
    void Burn(std::int64_t ns) noexcept override { inner.Burn(ns); }
    VirtualClock inner;
    std::int64_t sleeps = 0;
  } clock;
  HapticLoop loop(s.body, s.device, clock, LoopParams{});
  loop.RunHere(1000);
  EXPECT_GT(loop.counts().missed, 100U);
  EXPECT_EQ(loop.counts().ramps, 0U);
  EXPECT_GT(s.device.counts().largest_N, 0.1);
  EXPECT_LE(s.device.counts().largest_step_N, 0.02 * (1 + 1e-9));
}

TEST(CuttingLoop, NaNFromTheDeviceGivesZeroForceAndARampAfterwards) {
  CuttingStage s;
  s.hand.nan_from_s = 0.5;
  s.hand.nan_to_s = 0.52;
  VirtualClock clock;
  HapticLoop loop(s.body, s.device, clock, LoopParams{});
  double before_N = 0;
  double during_N = 0;
  double just_after_N = 0;
  int tick = 0;
  loop.RunHere(700, [&] {
    ++tick;
    const double force_N = glm::length(s.simulated.force_N());
    EXPECT_TRUE(std::isfinite(force_N));
    if (tick == 495) before_N = force_N;
    if (tick >= 500 && tick < 520) during_N = std::max(during_N, force_N);
    if (tick == 524) just_after_N = force_N;
    return true;
  });
  EXPECT_EQ(loop.end(), LoopEnd::kRequested);
  EXPECT_GT(before_N, 0.05);
  EXPECT_EQ(during_N, 0);
  EXPECT_LT(just_after_N, 0.1 * before_N);  // 5 of 100 ticks into the ramp
  EXPECT_GE(s.body.step().counts().bad_samples, 20U);
  EXPECT_EQ(s.simulated.force_N(), Vec3(0));  // after the end
}

TEST(CuttingLoop, ADeviceThatStaysDeadEndsTheLoop) {
  CuttingStage s;
  VirtualClock clock;
  s.simulated.SetFaults({.read_fails = true});
  struct Dead : HandDriver {
    void Advance(double) noexcept override {}
  } no_reader;
  StepBody body(s.simulation, s.device, CuttingStage::MakeBodyParams(1000), &no_reader);
  HapticLoop loop(body, s.device, clock, LoopParams{});
  loop.RunHere(5000);
  EXPECT_EQ(loop.end(), LoopEnd::kDeviceFailed);
  EXPECT_NEAR(static_cast<double>(loop.counts().ticks), 1000, 2);  // the loop stops after a second
}

}  // namespace
}  // namespace kerf
