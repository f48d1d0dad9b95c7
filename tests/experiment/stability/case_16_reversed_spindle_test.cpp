// Hard case 16: the spindle is reversed, stopped and started within a tick, in the cut, at any speed.
#include <random>

#include "base/core/high_pass.h"
#include "experiment/stability/in_kerf.h"
#include "experiment/stability/verdict.h"
#include "loop/haptics/held_saw.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::InKerf;
using test::kDt_s;

/// Returns parameters with the push at the middle of the buried part, where it causes the largest possible friction.
CoupledParams Pushed() {
  CoupledParams params = DiscParams();
  SetEffect(params.effects, "kerf_friction", "coefficient", 0.3);
  params.coupling.p_TC_mm = {0, kR - 1.5, 0};
  return params;
}

TEST(HardCase16, ReversingTheSpindleReversesOnlyTheFriction) {
  test::Verdict verdict(
      "applies in part: the scene of this case has no `tangential_force`, which would reverse; the flats' friction "
      "does");
  // The block is its own mirror image in x = 0, and so is the path except for the sense of rotation.
  double max_off_N = 0;
  double max_friction_N = 0;
  std::vector<CoupledOutput> forwards;
  for (const double rpm : {7500.0, -7500.0}) {
    const bool back = rpm < 0;
    // In a kerf 3 mm deep, the friction from the couple on the flats would amplify the difference: to 0.07 N, and with
    // voxels of 0.1 mm to 0.23 N.
    InKerf kerf(Pose{}, {26, 2, 8}, 0.2, 4, Pushed(), rpm);
    int n = 0;
    const auto look = [&](const CoupledOutput& out) {
      if (!back) {
        forwards.push_back(out);
        max_friction_N = std::max(max_friction_N, std::abs(out.f_friction_W_N.x));
        return;
      }
      const CoupledOutput& was = forwards[static_cast<std::size_t>(n++)];
      const auto off = [](const Vec3& a, const Vec3& b) {
        return std::max({std::abs(a.x + b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
      };
      max_off_N = std::max({max_off_N, off(out.f_H_W_N, was.f_H_W_N), off(out.f_cut_W_N, was.f_cut_W_N),
                            off(out.f_face_W_N, was.f_face_W_N), off(out.f_friction_W_N, was.f_friction_W_N)});
    };
    const double sign = back ? -1 : 1;
    kerf.Move(kerf.OffsetPose({0, 5, 0}), 100, rpm, look);
    kerf.Move(kerf.OffsetPose({sign * 3, 5, 0}), 300, rpm, look);
    kerf.Move(kerf.OffsetPose({sign * 1, -4, -1}), 300, rpm, look);
    kerf.invariants.CheckBone();
  }
  verdict.AtLeast("friction of the flats", max_friction_N, 1, "N");
  // Distances are accurate to 4e-7 of the radius and are rounded differently in the mirror image. At a wall of 3000
  // N/mm per point that is 0.013 N per point.
  verdict.AtMost("deviation from the mirror image", max_off_N, 0.06, "N");
}

TEST(HardCase16, SenseOfRotationOnAPathDoesNotChangeASingleBit) {
  const Bone bone = test::MakeBox(Pose{}, {20, 2, 6}, 0.2);
  std::vector<TickOutput> was;
  for (const double rpm : {7500.0, -7500.0}) {
    Simulation simulation(bone, {}, DiscPose(Pose{}, {0.3, 0, 3 + kR + 0.1}));
    const auto now = test::Stroke(simulation, Pose{}, {0.3, 0, 3 + kR + 0.1}, {1, 0.01, 3 + kR - 2}, 5, rpm);
    for (std::size_t i = 0; i < was.size(); ++i) {
      ASSERT_EQ(now[i].f_T_W_N, was[i].f_T_W_N);
      ASSERT_EQ(now[i].tau_TG_W_Nmm, was[i].tau_TG_W_Nmm);
      ASSERT_EQ(now[i].removed_mm3, was[i].removed_mm3);
    }
    was = now;
  }
  EXPECT_GT(was.back().thrust_sum_N, 0.5);
}

/// Largest force, divided by the hand's initial force, and largest step of the force in a tick, while TurnThrough()
/// applies spindle speeds in successive ticks and the hand pushes into the floor and against a wall.
struct Turned {
  double force = 0;
  double step_N = 0;
};
void TurnThrough(const std::vector<double>& speeds, Turned& turned) {
  InKerf kerf(Pose{}, {26, 2, 12}, 0.2, 4, Pushed());
  kerf.Hold(200, {0.5, 4, -4});
  const double before_N = glm::length(kerf.out.f_H_W_N);
  Vec3 f_before = kerf.out.f_H_W_N;
  for (const double rpm : speeds) {
    kerf.Hold(1, {0.5, 4, -4}, 0, rpm);
    turned.force = std::max(turned.force, glm::length(kerf.out.f_H_W_N) / before_N);
    turned.step_N = std::max(turned.step_N, glm::length(kerf.out.f_H_W_N - f_before));
    f_before = kerf.out.f_H_W_N;
  }
  kerf.invariants.CheckBone();
}

TEST(HardCase16, ReversingStoppingAndStartingInTheCutCausesNoKick) {
  test::Verdict verdict(
      "holds: only the friction reverses in a tick, and the force on the hand never exceeds the hand's push");
  Turned turned;
  TurnThrough({7500, -7500, 7500, 0, -7500, 0, 0, 1e6, -1e6, 0, 1, 0.99, -1, 1e6, 7500}, turned);
  std::mt19937_64 random(16);
  std::vector<double> speeds;
  for (int i = 0; i < static_cast<int>(2000 * test::Effort()); ++i) {
    const double all[] = {0, 7500, -7500, 1e6, -1e6, 60, -1};
    speeds.push_back(all[random() % 7]);
  }
  TurnThrough(speeds, turned);
  verdict.AtMost("force relative to the hand's push", turned.force, 1.02);
  // In a tick the tool moves at most 24 steps of half a voxel, against a spring of 1 N/mm. The motors' slew rate is
  // tested separately.
  verdict.AtMost("largest force step in a tick", turned.step_N, 24 * 0.5 * 0.2 * 1.05, "N");
}

TEST(HardCase16, DeviceForceKeepsItsSlewRateWhenTheSpindleStartsInATick) {
  test::Verdict verdict("holds");
  test::HeldSaw saw;
  test::Invariants watch(saw.simulation, saw.start);
  watch.WatchDevice(saw.device.profile());
  IntentionStep push;
  push.seconds = 10;
  push.X_WH = saw.start;
  push.push_W_N = Vec3(0, 0, -8);
  push.yield_s = 0.5;
  saw.device.SetScript(IntentionScript(saw.start, {push}));
  double largest_N = 0;
  Vec3 f_before(0);
  for (int i = 0; i < 3000; ++i) {
    const HapticTick out = saw.Step(i / 250 % 2 == 0 ? 0.0 : (i / 500 % 2 == 0 ? 1e6 : -7500.0));
    watch.Step(out);
    largest_N = std::max(largest_N, glm::length(out.force.f_H_W_N - f_before));
    f_before = out.force.f_H_W_N;
  }
  watch.CheckBone();
  EXPECT_GT(watch.removed_mm3(), 1);
  // The slew rate is 40 N in 5 ms.
  verdict.AtMost("largest step of the device force", largest_N, 40 * kDt_s / 0.005, "N");
}

TEST(HardCase16, PassesOfTheTeethCauseNoBeatInTheForce) {
  // The model averages over the passes of the teeth. At 2500 rpm, exactly one of the 24 teeth passes per tick of 1 ms.
  // At 2499 rpm the teeth would beat at 0.4 Hz with the ticks; at 1e6 rpm 400 teeth pass in a tick.
  test::Verdict verdict("holds: a tooth's force is the mean over its passes, so no speed causes a beat");
  double max_mN = 0;
  for (const double rpm : {2499.0, 2500.0, 2501.0, 1e5, 1e5 + 1, 1e6}) {
    const Pose start = DiscPose(Pose{}, {0, 0, 4 + kR - 0.05});
    CoupledSimulation simulation(test::MakeBox(Pose{}, {26, 2, 8}, 0.2), DiscParams(), start);
    std::vector<double> f;
    for (int i = 1; i <= 1500; ++i) {
      // At a steady feed the tool follows the handle, so the force is that of the teeth.
      const CoupledOutput out = simulation.Tick(test::Handle(DiscPose(Pose{}, {0, 0, 4 + kR - 0.05 - 0.002 * i}), rpm));
      ASSERT_TRUE(std::isfinite(out.f_H_W_N.z));
      if (i > 500) f.push_back(out.f_H_W_N.z);
    }
    EXPECT_GT(f.back(), 0) << rpm;
    max_mN = std::max(max_mN, 1000 * CalcHighPassRms(f, kDt_s, 20));
  }
  verdict.AtMost("force above 20 Hz at a steady feed", max_mN, 2, "mN");
}

TEST(HardCase16, ImpossibleSpindleSpeedsAreRefused) {
  InKerf kerf(Pose{}, {26, 2, 8}, 0.4, 2, DiscParams());
  const std::uint64_t hash = kerf.simulation.UpdateBone().CalcHash();
  for (const double rpm : {1.01e6, -1.01e6, 1e300, static_cast<double>(INFINITY), static_cast<double>(NAN)}) {
    kerf.Hold(1, {0, 0, -3}, 0, rpm);
    EXPECT_EQ(kerf.out.status, kCoupledBadPose);
    EXPECT_EQ(kerf.out.f_H_W_N, Vec3(0));
  }
  EXPECT_EQ(kerf.simulation.UpdateBone().CalcHash(), hash);
}

}  // namespace
}  // namespace kerf
