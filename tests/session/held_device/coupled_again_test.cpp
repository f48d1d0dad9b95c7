// A saw that is behind the handle that pulls it into bone: when the handle is coupled to it again, nothing pulls it any
// more, so that it does not cut while the hand is still.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "device/drivers/reported_device.h"
#include "loop/haptics/step_body.h"

namespace kerf {
namespace {

using test::ReportedDevice;
using test::Served;
using test::WaitFor;

constexpr std::uint32_t kClutch = 1;
constexpr double kAhead_mm = 24;  // of the handle, from above the block into it
constexpr double kStep_mm = 2;    // below what counts as a leap, however long a round takes
const Vec3 kElsewhere_mm{4e5, 0, -50};

struct NoObserver : TickObserver {
  void Enter(TickStage) noexcept override {}
};

DeviceServoOptions MakeOptions() {
  DeviceServoOptions options = test::PatientOptions();
  options.R_WD = {1, 0, 0, 0};
  options.servo.silent_s = 2;
  options.servo.max_speed_mm_per_s = 1000;
  return options;
}

/// A turning disc in the y-z plane above a block, and a handle that pulls it down.
struct PulledSaw {
  PulledSaw()
      : simulation(
            MakeBlock({.size_mm = {10, 10, 40}, .X_WB = {}, .layers = {}, .voxel_mm = 0.25}, DefaultMandibleTable()),
            MakeParams(), Start()) {
    served.Engage(Start());
    body.set_rpm(300);  // so slow that the handle moves faster than the saw cuts
    for (double down_mm = 0; down_mm < kAhead_mm; down_mm += kStep_mm) {
      served.MoveHandle({0, 0, -down_mm - kStep_mm});
      Pass(2);
    }
  }

  static Pose Start() { return {Quat(std::sqrt(0.5), 0, std::sqrt(0.5), 0), Vec3(0.1, 0, 6)}; }
  static CoupledParams MakeParams() {
    CoupledParams params;
    params.tool = DiscSaw{.diameter_mm = 10, .thickness_mm = 0.5, .teeth = 12};
    params.coupling.stiffness_N_per_mm = 2;
    return params;
  }
  /// Passes ticks and returns the volume that they remove, mm^3.
  double Pass(int ticks) {
    double removed_mm3 = 0;
    for (int i = 0; i < ticks; ++i) {
      NoObserver observer;
      body.Tick(0.001, observer, tick);
      removed_mm3 += tick.coupled.removed_mm3;
    }
    return removed_mm3;
  }
  bool is_read() const { return (tick.faults & kHapticReadFailed) == 0; }
  double pull_mm() const { return glm::length(tick.X_WH.p_AB - tick.coupled.X_WT.p_AB); }
  bool PassUntil(ServoState state) {
    return WaitFor([&] {
      Pass(1);
      return served.servo->state() == state;
    });
  }
  void Change(const std::function<void(ReportedDevice::State&)>& change) { served.device->With(change); }

  Served served{MakeOptions()};
  CoupledSimulation simulation;
  GuardedDevice guarded{*served.servo};
  StepBody body{simulation, guarded, {}};
  LoopTick tick;
};

/// `fault` lets go of the saw; afterwards the handle is elsewhere, and holds it again.
void ExpectSawStays(PulledSaw& saw, const std::function<void()>& fault) {
  ASSERT_TRUE(saw.is_read());
  ASSERT_GT(saw.pull_mm(), 10);
  ASSERT_GT(glm::length(saw.tick.coupled.f_H_W_N), 5);
  const std::uint32_t before = saw.served.servo->TakeSample().engagements;
  const Pose X_WT = saw.tick.coupled.X_WT;
  fault();
  ASSERT_TRUE(WaitFor([&] { return saw.served.servo->TakeSample().engagements > before; }));
  ASSERT_TRUE(saw.served.device->PassRounds());
  ASSERT_TRUE(WaitFor([&] {
    saw.Pass(1);
    return saw.is_read() && saw.served.servo->TakeSample().engagements > before;
  }));
  EXPECT_LT(saw.pull_mm(), 0.1);
  const double removed_mm3 = saw.Pass(500);
  EXPECT_TRUE(saw.is_read());
  EXPECT_LT(removed_mm3, 0.05);
  EXPECT_LT(glm::length(saw.tick.coupled.X_WT.p_AB - X_WT.p_AB), 0.2);
  EXPECT_LT(glm::length(saw.tick.coupled.f_H_W_N), 0.2);
}

TEST(CoupledAgain, AfterASilence) {
  PulledSaw saw;
  ExpectSawStays(saw, [&] {
    saw.Change([](ReportedDevice::State& state) {
      state.end = RoundEnd::kNoAnswer;
      state.sample.X_DH.p_AB = kElsewhere_mm;
    });
    ASSERT_TRUE(WaitFor([&] { return saw.served.servo->state() == ServoState::kSilent; }));
    saw.Pass(20);
    saw.Change([](ReportedDevice::State& state) { state.end = RoundEnd::kSample; });
  });
}

TEST(CoupledAgain, AfterALeapThatTheLoopDoesNotSee) {
  PulledSaw saw;
  ExpectSawStays(saw,
                 [&] { saw.Change([](ReportedDevice::State& state) { state.sample.X_DH.p_AB = kElsewhere_mm; }); });
}

TEST(CoupledAgain, AfterItWasPluggedInAgain) {
  PulledSaw saw;
  ExpectSawStays(saw, [&] {
    saw.Change([](ReportedDevice::State& state) { state.is_there = false; });
    ASSERT_TRUE(saw.PassUntil(ServoState::kClosed));
    saw.Change([](ReportedDevice::State& state) {
      state.is_there = true;
      state.sample.X_DH.p_AB = kElsewhere_mm;
    });
    ASSERT_TRUE(saw.PassUntil(ServoState::kWaiting));
    saw.served.servo->Agree();
  });
}

TEST(CoupledAgain, TheClutchEndsThePullWithTheForce) {
  PulledSaw saw;
  ASSERT_GT(saw.pull_mm(), 10);
  saw.served.Press(kClutch);
  saw.Pass(60);  // 50 ms, and the tick that notices the button
  EXPECT_LT(saw.pull_mm(), 0.5);
  EXPECT_LT(saw.Pass(500), 0.5);
  // The requested pose stands, so that the teeth cannot drive the saw away.
  const Pose X_WH = saw.tick.X_WH;
  saw.served.Press(0);
  saw.Pass(500);
  EXPECT_LT(glm::length(saw.tick.X_WH.p_AB - X_WH.p_AB), 1e-6);
  EXPECT_LT(glm::length(saw.tick.coupled.f_H_W_N), 1);
}

}  // namespace
}  // namespace kerf
