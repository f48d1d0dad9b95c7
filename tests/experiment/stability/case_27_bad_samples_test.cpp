// Hard case 27: the device delivers invalid poses. The force becomes zero at once, the tool is held, the bone is
// unchanged, and the session continues with the next good sample.
#include <functional>
#include <limits>

#include "experiment/stability/invariants.h"
#include "experiment/stability/verdict.h"
#include "loop/haptics/held_saw.h"

namespace kerf {
namespace {

constexpr double kBadSamplesNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kBadSamplesInf = std::numeric_limits<double>::infinity();
constexpr double kTiny = std::numeric_limits<double>::denorm_min();
constexpr double kMax = std::numeric_limits<double>::max();

/// Simulated device whose samples a test can corrupt.
class SpoiltDevice final : public Device {
 public:
  explicit SpoiltDevice(SimulatedDevice& device) : device_(device) {}
  void Spoil(std::function<void(Pose&)> how) { how_ = std::move(how); }

  const DeviceProfile& profile() const override { return device_.profile(); }
  void Elapse(double dt_s) noexcept override { device_.Elapse(dt_s); }
  bool Read(DeviceSample& sample) noexcept override {
    const bool ok = device_.Read(sample);
    if (how_) how_(sample.X_WH);
    return ok;
  }
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override {
    return device_.Write(f_H_W_N, tau_H_W_Nmm);
  }

 private:
  SimulatedDevice& device_;
  std::function<void(Pose&)> how_;
};

struct Spoiling {
  const char* name;
  std::function<void(Pose&)> how;
};

/// Returns all kinds of invalid poses.
std::vector<Spoiling> BadPoses() {
  std::vector<Spoiling> all;
  for (const double value : {kBadSamplesNan, kBadSamplesInf, -kBadSamplesInf, kMax, 1.001e6}) {
    for (int axis = 0; axis < 3; ++axis) {
      all.push_back({"place", [=](Pose& X) { X.p_AB[axis] = value; }});
    }
  }
  for (const double value : {kBadSamplesNan, kBadSamplesInf, -kBadSamplesInf, kMax, 2.0}) {
    for (int part = 0; part < 4; ++part) {
      all.push_back({"quaternion", [=](Pose& X) { X.R_AB[part] = value; }});
    }
  }
  all.push_back({"zero quaternion", [](Pose& X) { X.R_AB = Quat(0, 0, 0, 0); }});
  all.push_back({"denormal quaternion", [](Pose& X) { X.R_AB = Quat(kTiny, -kTiny, kTiny, kTiny); }});
  all.push_back({"too short", [](Pose& X) { X.R_AB *= 0.999; }});
  all.push_back({"too long", [](Pose& X) { X.R_AB *= 1 + 3e-6; }});
  all.push_back({"all of it", [](Pose& X) {
                   X.p_AB = Vec3(kBadSamplesNan);
                   X.R_AB = Quat(kBadSamplesNan, kBadSamplesInf, -kBadSamplesInf, 0);
                 }});
  return all;
}

/// A saw pushed into the bone until the device's force has ramped in completely.
struct Cutting {
  Cutting() : device(saw.device), watch(saw.simulation, saw.start) {
    watch.WatchDevice(saw.device.profile());
    IntentionStep push;
    push.seconds = 1000;
    push.X_WH = saw.start;
    push.push_W_N = Vec3(0, 0, -5);
    push.yield_s = 0.5;
    saw.device.SetScript(IntentionScript(saw.start, {push}));
    for (int i = 0; i < 1500; ++i) Step();
  }
  const HapticTick& Step() {
    out = saw.step.Step(device, {.dt_s = test::kDt_s, .rpm = 7500});
    watch.Step(out);
    return out;
  }
  test::HeldSaw saw;
  SpoiltDevice device;
  test::Invariants watch;
  HapticTick out;
};

TEST(HardCase27, BadSampleGivesZeroForceAndTheNextGoodOneContinues) {
  test::Verdict verdict(
      "holds; the force is zero in the same tick, not ramped down. A left-handed frame cannot occur, because a pose "
      "has a quaternion");
  Cutting cut;
  ASSERT_GT(cut.out.force.f_H_W_N.z, 4);
  int refused = 0;
  int tried = 0;
  double max_first_N = 0;
  double max_gap_mm = 0;
  double max_speed = 0;
  for (const Spoiling& spoiling : BadPoses()) {
    const Pose held = cut.out.coupled.X_WT;
    const Pose good = cut.out.X_WH;
    const std::uint64_t counted = cut.saw.step.counts().bad_samples;
    cut.saw.simulation.ClearChanged();
    cut.device.Spoil(spoiling.how);
    const int ticks = 1 + tried % 4;
    for (int n = 0; n < ticks; ++n) {
      cut.Step();
      EXPECT_EQ(cut.out.faults, kHapticBadSample) << spoiling.name;
      EXPECT_EQ(cut.out.force.f_H_W_N, Vec3(0)) << spoiling.name;
      EXPECT_EQ(cut.out.force.tau_H_W_Nmm, Vec3(0)) << spoiling.name;
      EXPECT_EQ(cut.saw.device.force_N(), Vec3(0)) << spoiling.name;
      EXPECT_EQ(cut.out.X_WH.p_AB, good.p_AB) << spoiling.name;
      EXPECT_EQ(cut.out.X_WH.R_AB, good.R_AB) << spoiling.name;
      EXPECT_EQ(cut.saw.simulation.changed_count(), 0) << spoiling.name;
    }
    EXPECT_EQ(cut.saw.step.counts().bad_samples - counted, static_cast<std::uint64_t>(ticks));
    refused += ticks;
    cut.device.Spoil(nullptr);
    // One good sample restores the state, except that the force ramps in again. In the meantime the hand has moved
    // without a force.
    cut.Step();
    EXPECT_EQ(cut.out.faults, kHapticOk) << spoiling.name;
    EXPECT_GT(cut.out.coupled.f_H_W_N.z, 3) << spoiling.name;
    max_first_N = std::max(max_first_N, glm::length(cut.out.force.f_H_W_N));
    max_gap_mm = std::max(max_gap_mm, glm::length(cut.out.coupled.X_WT.p_AB - held.p_AB));
    max_speed = std::max(max_speed, glm::length(cut.out.v_H_W_mm_per_s));
    for (int n = 0; n < 20; ++n) cut.Step();
    ++tried;
  }
  cut.watch.CheckBone();
  verdict.Note("bad samples", refused);
  // After 1 ms the ramp allows 3 (t / 0.5 s)^2 of the coupling's maximum force, which may be reached because no force
  // has held the hand in the meantime.
  verdict.AtMost("force in the first good tick", max_first_N, 3 * 0.002 * 0.002 * 40, "N");
  verdict.AtMost("motion of the tool over a gap of up to 4 ticks", max_gap_mm, 0.2, "mm");
  verdict.Equal("velocity computed from the jump", max_speed, 0, "mm/s");
}

TEST(HardCase27, ForceReturnsOverTheRamp) {
  test::Verdict verdict("holds");
  Cutting cut;
  cut.device.Spoil([](Pose& X) { X.p_AB.x = kBadSamplesNan; });
  cut.Step();
  cut.device.Spoil(nullptr);
  double max_over = 0;
  for (int n = 1; n <= 600; ++n) {
    cut.Step();
    const double t = std::min(n * 0.001 / 0.5, 1.0);
    max_over = std::max(max_over, glm::length(cut.out.force.f_H_W_N) -
                                      (3 * t * t - 2 * t * t * t) * glm::length(cut.out.coupled.f_H_W_N));
  }
  verdict.AtMost("force above the ramp", max_over, 1e-9, "N");
  verdict.AtLeast("force after 0.6 s", cut.out.force.f_H_W_N.z, 4, "N");
}

TEST(HardCase27, UnusualButValidPosesAreAccepted) {
  // The following samples are valid: a length that is 1 within the rounding of a float, a quaternion of the opposite
  // sign, and a denormal component.
  Cutting cut;
  const std::function<void(Pose&)> hows[] = {[](Pose& X) { X.R_AB *= 1 + 5e-7; }, [](Pose& X) { X.R_AB *= 1 - 5e-7; },
                                             [](Pose& X) { X.R_AB = -X.R_AB; }, [](Pose& X) { X.R_AB.y += kTiny; },
                                             [](Pose& X) { X.p_AB.x += kTiny; }};
  for (const auto& how : hows) {
    const Vec3 before = cut.out.force.f_H_W_N;
    cut.device.Spoil(how);
    for (int n = 0; n < 20; ++n) {
      cut.Step();
      EXPECT_EQ(cut.out.faults, kHapticOk);
      EXPECT_NEAR(glm::length(cut.out.force.f_H_W_N - before), 0, 0.1);
    }
    cut.device.Spoil(nullptr);
    cut.Step();
  }
  cut.watch.CheckBone();
}

/// Corrupts the simulation's input directly, one number at a time.
TEST(HardCase27, AnyNumberOfATicksInputMayBeInvalid) {
  test::Verdict verdict("holds");
  Cutting cut;
  CoupledSimulation& simulation = cut.saw.simulation;
  CoupledInput good;
  good.X_WH = cut.out.X_WH;
  const CoupledOutput before = simulation.Tick(good);
  const Bone bone = simulation.UpdateBone();
  simulation.ClearChanged();
  int bad = 0;
  for (int number = 0; number < 15; ++number) {
    for (const double value : {kBadSamplesNan, kBadSamplesInf, -kBadSamplesInf, kMax, -kMax, 1e15}) {
      CoupledInput in = good;
      double* const numbers[15] = {&in.X_WH.p_AB.x,
                                   &in.X_WH.p_AB.y,
                                   &in.X_WH.p_AB.z,
                                   &in.X_WH.R_AB.w,
                                   &in.X_WH.R_AB.x,
                                   &in.X_WH.R_AB.y,
                                   &in.X_WH.R_AB.z,
                                   &in.v_H_W_mm_per_s.x,
                                   &in.v_H_W_mm_per_s.y,
                                   &in.v_H_W_mm_per_s.z,
                                   &in.w_H_W_rad_per_s.x,
                                   &in.w_H_W_rad_per_s.y,
                                   &in.w_H_W_rad_per_s.z,
                                   &in.dt_s,
                                   &in.rpm};
      *numbers[number] = value;
      const CoupledOutput out = simulation.Tick(in);
      EXPECT_EQ(out.status, kCoupledBadPose) << number << " " << value;
      EXPECT_EQ(out.f_H_W_N, Vec3(0)) << number << " " << value;
      EXPECT_EQ(out.tau_H_W_Nmm, Vec3(0)) << number << " " << value;
      EXPECT_EQ(out.X_WT.p_AB, before.X_WT.p_AB) << number << " " << value;
      EXPECT_EQ(out.removed_mm3, 0) << number << " " << value;
      ++bad;
    }
  }
  EXPECT_EQ(simulation.changed_count(), 0);
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), bone.CalcHash());
  // One good tick restores the force.
  const CoupledOutput after = simulation.Tick(good);
  EXPECT_EQ(after.status & kCoupledBadPose, 0u);
  verdict.Note("bad inputs", bad);
  verdict.AtMost("relative change of the force after the bad inputs", std::abs(after.f_H_W_N.z / before.f_H_W_N.z - 1),
                 0.1);
}

}  // namespace
}  // namespace kerf
