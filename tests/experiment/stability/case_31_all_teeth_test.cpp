// Hard cases 31 and 32: the disc is entirely buried, and all teeth engage in one tick.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bone/grid/build.h"
#include "cut/hand_sim/hands.h"
#include "experiment/stability/verdict.h"
#include "loop/haptics/held_saw.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;
using test::Verdict;

TEST(HardCase31, ForceAndComputationOfABuriedDiscAreBounded) {
  Verdict verdict("holds; case disc-0.1-buried of `kerf bench tick` measures the time");
  const Bone bone = test::MakeBox(Pose{}, {28, 6, 28}, 0.2);
  double worst_angle = 0;
  double max_N = 0;
  int max_iterations = 0;
  int max_substeps_made = 0;
  int not_converged = 0;
  double teeth = 1e9;
  for (const double rpm : {7500.0, 0.0}) {
    for (int direction = 0; direction < 14; ++direction) {
      // Places the handle 80 mm away along the axes and diagonals, which is twice the distance at which the coupling
      // reaches its maximum force.
      Vec3 offset(0);
      if (direction < 6) {
        offset[direction / 2] = direction % 2 == 0 ? 1 : -1;
      } else {
        const int d = direction - 6;
        offset = Vec3(d & 1 ? 1 : -1, d & 2 ? 1 : -1, d & 4 ? 1 : -1);
      }
      const Pose X = DiscPose(Pose{}, {0, 0, 0});
      CoupledSimulation simulation(bone, test::DiscParams(), X);
      Pose X_WH = X;
      X_WH.p_AB += 80.0 * glm::normalize(offset);
      for (int i = 0; i < 20; ++i) {
        const CoupledOutput out = simulation.Tick(Handle(X_WH, rpm));
        if (i == 0 && rpm != 0) teeth = std::min(teeth, out.engaged_teeth);
        ASSERT_TRUE(std::isfinite(glm::length(out.f_H_W_N)));
        max_N = std::max(max_N, glm::length(out.f_H_W_N));
        const Vec3 pull = out.X_WT.p_AB - X_WH.p_AB;
        const double cosine = glm::dot(glm::normalize(pull), glm::normalize(out.f_H_W_N));
        worst_angle = std::max(worst_angle, std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi);
        max_iterations = std::max(max_iterations, out.iterations);
        max_substeps_made = std::max(max_substeps_made, out.substeps);
        not_converged += (out.status & kCoupledIterationsUsedUp) != 0;
        EXPECT_NE(out.status & kCoupledForceLimited, 0u);
      }
    }
  }
  // At first all of the rim is engaged; then half of it has cut itself free.
  verdict.AtLeast("teeth, out of 24, engaged at once", teeth, 11.9);
  verdict.AtMost("largest force (the coupling's maximum)", max_N, 40 * (1 + 1e-12), "N");
  verdict.AtMost("direction error", worst_angle, 1e-5, "degrees");
  verdict.AtMost("iterations per substep", max_iterations, 30);
  verdict.AtMost("substeps per tick", max_substeps_made, test::DiscParams().max_substeps);
  EXPECT_EQ(not_converged, 0);
}

TEST(HardCase31, TheDevicesClampKeepsTheDirection) {
  Verdict verdict("holds");
  ForceMapParams params;
  params.ramp_in_s = 0;
  const DeviceProfile profile = FindDeviceProfile("omega_3");
  ForceMap map(profile, params);
  double worst_angle = 0;
  double largest = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 f = 100.0 * (1 + i % 7) * glm::normalize(Vec3(std::sin(1.0 * i), std::cos(2.0 * i), std::sin(0.7 * i)));
    ForceMapOutput out;
    for (int k = 0; k < 20; ++k) out = map.Calc(f, Vec3(0), 0.001);  // until the slew limit allows the full force
    largest = std::max(largest, glm::length(out.f_H_W_N) / profile.peak_force_N);
    const double cosine = glm::dot(glm::normalize(f), glm::normalize(out.f_H_W_N));
    worst_angle = std::max(worst_angle, std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi);
    EXPECT_GT(glm::length(out.f_H_W_N), 0.9 * profile.peak_force_N);
  }
  verdict.AtMost("direction error", worst_angle, 1e-5, "degrees");
  verdict.AtMost("force relative to the device's peak", largest, 1);
}

/// Returns a plate of 28 x 28 x 3 mm with its top at z = 0 and a hole with a radius 0.03 mm larger than the disc's: no
/// tooth in the middle has begun to enter the bone.
Bone MakeBoredPlate() {
  SolidField field;
  field.value = [](const Vec3& p) {
    return std::max(test::BoxDistance(p - Vec3(0, 0, -1.5), {14, 14, 1.5}), kR + 0.03 - std::hypot(p.x, p.y));
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  return MakeBone(field, Box3{{-15.5, -15.5, -4.5}, {15.5, 15.5, 1.5}}, {0.2, 0.2, {}}, test::OneRegionTable());
}

TEST(HardCase32, AllTeethEngagingAtOnceCauseNoJump) {
  Verdict verdict("holds");
  // The disc falls flat to the middle of a hole of its size, and the hand then moves sideways. At first no tooth is
  // engaged; in the next tick a third of them are.
  const Bone bone = MakeBoredPlate();
  double worst = 0;
  double teeth_step = 0;
  for (const double speed : {20.0, 100.0, 300.0}) {
    const CoupledParams params = test::DiscParams();
    const double step_mm = speed * 0.001;
    CoupledSimulation simulation(bone, params, {Quat(1, 0, 0, 0), Vec3(0, 0, 1)});
    CoupledOutput last;
    for (int i = 1; i < 200 && step_mm * i < 4.5; ++i) {  // up to 2 mm aside, in the plate
      const double down = step_mm * i;
      const Vec3 p(std::max(0.0, down - 2.5), 0, std::max(-1.5, 1 - down));
      const CoupledOutput out = simulation.Tick(Handle({Quat(1, 0, 0, 0), p}));
      // A tool that stopped at once would stretch the coupling by the handle's motion. Nothing pushes the tool back
      // further.
      worst = std::max(worst, glm::length(out.f_H_W_N - last.f_H_W_N) / (params.coupling.stiffness_N_per_mm * step_mm));
      teeth_step = std::max(teeth_step, out.engaged_teeth - last.engaged_teeth);
      last = out;
    }
    EXPECT_GT(glm::length(last.f_H_W_N), 0.1);
  }
  verdict.AtLeast("teeth that engage in one tick", teeth_step, 8);
  verdict.AtMost("largest force step relative to the coupling's for the handle motion", worst, 1.02);
}

TEST(HardCase32, StartingTheSpindleInTheBoneCausesNoJump) {
  Verdict verdict("holds");
  // The disc is entirely buried and is pulled with 5 N. Then the spindle starts, and all teeth engage.
  CoupledSimulation simulation(test::MakeBox(Pose{}, {28, 6, 28}, 0.2), test::DiscParams(),
                               DiscPose(Pose{}, {0, 0, 0}));
  Vec3 last(0);
  double worst_N = 0;
  double teeth = 0;
  for (int i = 0; i < 300; ++i) {
    const CoupledOutput out =
        simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, -std::min(5.0, 0.05 * i)}), i < 150 ? 0 : 7500));
    if (i == 150) teeth = out.engaged_teeth;
    if (i > 0) worst_N = std::max(worst_N, glm::length(out.f_H_W_N - last));
    last = out.f_H_W_N;
  }
  verdict.AtLeast("teeth that engage in one tick", teeth, 11);
  // The handle's 0.05 mm per tick correspond to 0.05 N. Once it is free, the tool moves at the feed that the teeth
  // allow at 5 N.
  verdict.AtMost("largest force step at a pull of 5 N", worst_N, 0.2, "N");
}

TEST(HardCase32, DeviceForceKeepsItsSlewRate) {
  Verdict verdict("holds");
  // The saw falls from the air 4 mm deep into the bone within one tick.
  test::HeldSawOptions options;
  options.force_map.slew_N_per_s = 200;
  test::HeldSaw saw(options);
  struct Dropped : Device {
    explicit Dropped(const DeviceProfile& the_profile) : own(the_profile) {}
    const DeviceProfile& profile() const override { return own; }
    bool Read(DeviceSample& sample) noexcept override {
      sample.X_WH = test::Upright(Vec3(0, 0, height));
      return true;
    }
    bool Write(const Vec3& f, const Vec3&) noexcept override {
      worst_N = std::max(worst_N, glm::length(f - f_N));
      max_N = std::max(max_N, glm::length(f));
      f_N = f;
      return true;
    }
    DeviceProfile own;
    double height = 11.3;
    double worst_N = 0, max_N = 0;
    Vec3 f_N{0};
  } device(options.profile);
  for (int i = 0; i < 1200; ++i) {
    if (i == 700) device.height = 7.3;
    saw.step.Step(device, {.dt_s = test::kDt_s, .rpm = 7500});
    if (i == 699) {
      EXPECT_EQ(device.f_N, Vec3(0));
    }
  }
  verdict.AtLeast("largest force", device.max_N, 2, "N");
  verdict.AtMost("largest step of the device force", device.worst_N, 0.2 * (1 + 1e-9), "N");
}

}  // namespace
}  // namespace kerf
