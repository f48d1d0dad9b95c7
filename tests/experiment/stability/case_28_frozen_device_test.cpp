// Hard case 28: the device freezes and resumes elsewhere, delivers the same sample twice, or the clock goes backwards.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "device/devices/velocity.h"
#include "experiment/stability/verdict.h"
#include "loop/haptics/held_saw.h"
#include "loop/haptics/made_up.h"

namespace kerf {
namespace {

using test::HeldSaw;
using test::HeldSawOptions;
using test::kDt_s;
using test::Upright;
using test::Verdict;

/// Device with a prescribed handle pose, which may repeat.
class LedDevice : public Device {
 public:
  explicit LedDevice(const DeviceProfile& profile) : profile_(profile) {}
  const DeviceProfile& profile() const override { return profile_; }
  bool Read(DeviceSample& sample) noexcept override {
    sample.X_WH = X_WH;
    return true;
  }
  bool Write(const Vec3& f_H_W_N, const Vec3&) noexcept override {
    largest_step_N = std::max(largest_step_N, glm::length(f_H_W_N - f_N));
    f_N = f_H_W_N;
    return true;
  }
  Pose X_WH;
  Vec3 f_N{0};
  double largest_step_N = 0;

 private:
  DeviceProfile profile_;
};

/// A cut at 20 mm/s along a block of soft bone, through a coupling with the largest damping that devices allow.
struct FastStroke {
  static constexpr double kFeed = 20;
  static constexpr double kDamping = 0.01;  // N s/mm
  static HeldSawOptions MakeOptions() {
    HeldSawOptions options;
    options.damping_Ns_per_mm = kDamping;
    options.profile.max_damping_Ns_per_mm = kDamping;
    options.block_mm = {60, 6, 26};
    return options;
  }
  FastStroke() : saw(MakeOptions()), device(saw.device.profile()) {
    // The saw moves from outside the block into it from the side, 2 mm deep.
    for (int i = 0; i < 1200; ++i) Step(kDt_s, true);
  }
  HapticTick Step(double dt_s, bool fresh_sample) {
    x += kFeed * dt_s;
    if (fresh_sample) device.X_WH = Upright(Vec3(-36.5 + x, 0, 11 - 2));
    return saw.step.Step(device, {.dt_s = dt_s, .rpm = 7500});
  }
  HeldSaw saw;
  LedDevice device;
  double x = 0;
};

TEST(HardCase28, FrozenHandleThatResumesElsewhereCausesNoKick) {
  Verdict verdict("holds");
  double worst_speed = 0;
  double worst_slew = 0;  // as a fraction of the slew limit
  double worst_step_N = 0;
  for (const int frozen_ticks : {2, 5, 20, 100, 300}) {
    FastStroke stroke;
    const ForceMapParams& map = stroke.saw.step.force_map().params();
    const double slew_N =
        kDt_s * (map.slew_N_per_s > 0 ? map.slew_N_per_s : stroke.device.profile().peak_force_N / 0.005);
    ASSERT_GT(glm::length(stroke.device.f_N), 0.1);
    HapticTick before = stroke.saw.step.Step(stroke.device, {.dt_s = kDt_s, .rpm = 7500});
    stroke.device.largest_step_N = 0;
    for (int i = 0; i < frozen_ticks + 100; ++i) {
      const HapticTick out = stroke.Step(kDt_s, i >= frozen_ticks);
      worst_speed = std::max(worst_speed, glm::length(out.v_H_W_mm_per_s));
      const double step_N = glm::length(out.coupled.f_H_W_N - before.coupled.f_H_W_N);
      // Steps due to the coupling's spring, 1.5 N/mm, and the motions of handle and tool are expected and subtracted.
      const double spring_N = 1.5 * (glm::length(out.X_WH.p_AB - before.X_WH.p_AB) +
                                     glm::length(out.coupled.X_WT.p_AB - before.coupled.X_WT.p_AB));
      worst_step_N = std::max(worst_step_N, step_N - spring_N);
      before = out;
      EXPECT_EQ(out.faults, kHapticOk);
    }
    worst_slew = std::max(worst_slew, stroke.device.largest_step_N / slew_N);
  }
  // Nothing moved faster than the stroke. On an exact line the velocity window is exact, except for the encoder's
  // rounding, which does not occur here.
  verdict.AtMost("estimated handle speed at 20 mm/s", worst_speed, 1.02 * FastStroke::kFeed, "mm/s");
  // The damper releases 0.01 N s/mm * 20 mm/s once, when the hold ends. Unfiltered, the leap would give 60 N.
  verdict.AtMost("force step in excess of the spring's", worst_step_N, 1.25 * FastStroke::kDamping * FastStroke::kFeed,
                 "N");
  verdict.AtMost("largest step on the device relative to the slew limit", worst_slew, 1 + 1e-9);
}

TEST(HardCase28, DeviceSlowerThanTheLoopMovesJustAsSmoothly) {
  Verdict verdict("holds");
  double worst = 0;
  for (const int every : {2, 4}) {
    FastStroke stroke;
    double slowest = 1e9;
    double fastest = 0;
    for (int i = 0; i < 400; ++i) {
      const HapticTick out = stroke.Step(kDt_s, i % every == 0);
      if (i < 20) continue;
      slowest = std::min(slowest, out.v_H_W_mm_per_s.x);
      fastest = std::max(fastest, out.v_H_W_mm_per_s.x);
    }
    worst = std::max({worst, fastest / FastStroke::kFeed - 1, 1 - slowest / FastStroke::kFeed});
  }
  verdict.AtMost("speed error, each sample delivered 2 or 4 times", 100 * worst, 2, "%");
}

TEST(HardCase28, LeapOfTheHandleGivesNoVelocity) {
  Verdict verdict("holds");
  // There is no preceding freeze: 5 mm between two samples would be 5 m/s, and 50 N through the damper.
  FastStroke stroke;
  stroke.x += 5;
  double worst_speed = 0;
  for (int i = 0; i < 50; ++i) {
    worst_speed = std::max(worst_speed, glm::length(stroke.Step(kDt_s, true).v_H_W_mm_per_s));
  }
  verdict.AtMost("estimated handle speed at 20 mm/s", worst_speed, 1.02 * FastStroke::kFeed, "mm/s");
}

TEST(HardCase28, InvalidTimeStepIsRefusedWithoutAfterEffects) {
  Verdict verdict("applies in part: the tick has no clock; an invalid time step is refused with zero force");
  FastStroke stroke;
  const std::uint64_t hash = stroke.saw.simulation.UpdateBone().CalcHash();
  const double before_N = glm::length(stroke.device.f_N);
  int without_force = 0;
  for (const double dt_s :
       {-0.001, -1e9, 0.0, std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    const HapticTick out = stroke.saw.step.Step(stroke.device, {.dt_s = dt_s, .rpm = 7500});
    EXPECT_TRUE(std::isfinite(glm::length(out.force.f_H_W_N)));
    EXPECT_TRUE(std::isfinite(glm::length(out.v_H_W_mm_per_s)));
    without_force += out.force.f_H_W_N == Vec3(0);
  }
  verdict.Equal("invalid time steps, out of 5, with zero force", without_force, 5);
  EXPECT_EQ(stroke.saw.simulation.UpdateBone().CalcHash(), hash);
  double after_N = 0;
  for (int i = 0; i < 600; ++i) after_N = glm::length(stroke.Step(kDt_s, true).force.f_H_W_N);
  verdict.AtLeast("force 0.6 s later relative to that before", after_N / before_N, 0.8);
}

TEST(HardCase28, ClockThatGoesBackwardsOnlyMakesTheLoopWait) {
  Verdict verdict(
      "holds: the loop uses the monotonic clock; if it went back, the loop would wait and not run a burst of ticks");
  struct Backwards : LoopClock {
    std::int64_t Now() noexcept override { return inner.Now() - set_back_ns; }
    void SleepUntil(std::int64_t time_ns) noexcept override {
      inner.SleepUntil(time_ns + set_back_ns);
      if (++sleeps % 50 == 0) set_back_ns += 3'300'000;
    }
    void Burn(std::int64_t ns) noexcept override { inner.Burn(ns); }
    VirtualClock inner;
    std::int64_t set_back_ns = 0;
    std::int64_t sleeps = 0;
  } clock;
  test::RecordingDevice recording;
  GuardedDevice device(recording);
  test::FakeBody body(device);
  HapticLoop loop(body, device, clock, LoopParams{});
  std::vector<double> times;
  loop.RunHere(1000, [&] {
    times.push_back(1e-9 * static_cast<double>(clock.inner.Now()));
    return true;
  });
  EXPECT_EQ(loop.counts().ticks, 1000U);
  EXPECT_EQ(loop.end(), LoopEnd::kRequested);
  double min_dt = 1e9;
  double max_dt = 0;
  for (std::size_t i = 0; i < body.dt.count; ++i) {
    min_dt = std::min(min_dt, body.dt.values[i]);
    max_dt = std::max(max_dt, body.dt.values[i]);
  }
  double min_gap = 1e9;
  for (std::size_t i = 1; i < times.size(); ++i) min_gap = std::min(min_gap, times[i] - times[i - 1]);
  verdict.AtLeast("shortest time step of the simulation", 1e3 * min_dt, 1 - 1e-9, "ms");
  verdict.AtMost("longest time step of the simulation", 1e3 * max_dt, 1 + 1e-9, "ms");
  verdict.AtLeast("shortest true time between two ticks", 1e3 * min_gap, 1 - 1e-6, "ms");
  EXPECT_EQ(loop.counts().ramps, 0U);
}

}  // namespace
}  // namespace kerf
