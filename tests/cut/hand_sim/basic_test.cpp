// The coupled tool in air, at rest, and fed by a constant push.
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "cut/hand_sim/hands.h"
#include "kerf/force.h"
#include "support/saw.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::Handle;
using test::PushingHand;

TEST(CoupledAir, ForceIsExactlyZeroAndTheToolIsWhereTheHandleIs) {
  const Bone bone = test::MakeBox(Pose{}, {10, 3, 6}, 0.2);
  for (const double height : {0.1, 0.4, 5.0}) {  // next to the bone, within the band, far away
    CoupledSimulation simulation(bone, DiscParams(), DiscPose(Pose{}, {0, 0, 3 + kR + height}));
    for (int i = 0; i < 20; ++i) {
      const Pose X_WH = DiscPose(Pose{}, {0.02 * i, 0.003 * i, 3 + kR + height});
      const CoupledOutput out = simulation.Tick(Handle(X_WH));
      EXPECT_EQ(out.f_H_W_N, Vec3(0));
      EXPECT_EQ(out.tau_H_W_Nmm, Vec3(0));
      EXPECT_EQ(out.X_WT.p_AB, X_WH.p_AB);
      EXPECT_EQ(out.X_WT.R_AB, X_WH.R_AB);
      EXPECT_EQ(out.hand_mJ, 0);
      EXPECT_EQ(out.removed_mm3, 0);
    }
  }
}

TEST(CoupledInput, InvalidInputKeepsTheLastValidPoseWithoutForce) {
  const Bone bone = test::MakeBox(Pose{}, {10, 3, 6}, 0.2);
  CoupledSimulation simulation(bone, DiscParams(), DiscPose(Pose{}, {0, 0, 3 + kR + 1}));
  const Pose X_good = DiscPose(Pose{}, {0, 0, 3 + kR + 0.9});
  simulation.Tick(Handle(X_good));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (int n = 0; n < 9; ++n) {
    CoupledInput in = Handle(DiscPose(Pose{}, {0, 0, kR}));
    if (n == 0) in.X_WH.p_AB.x = nan;
    if (n == 1) in.X_WH.p_AB.y = inf;
    if (n == 2) in.X_WH.R_AB.w = 2;
    if (n == 3) in.dt_s = -1e-3;
    if (n == 4) in.dt_s = 2;
    if (n == 5) in.rpm = nan;
    if (n == 6) in.v_H_W_mm_per_s.z = inf;
    if (n == 7) in.w_H_W_rad_per_s.x = nan;
    if (n == 8) in.X_WH.p_AB.z = 1e9;
    const CoupledOutput out = simulation.Tick(in);
    EXPECT_EQ(out.status, kCoupledBadPose) << n;
    EXPECT_EQ(out.f_H_W_N, Vec3(0));
    EXPECT_EQ(out.X_WT.p_AB, X_good.p_AB);
    EXPECT_EQ(out.removed_mm3, 0);
  }
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), bone.CalcHash());
}

TEST(CoupledInput, RotationThatIsOneLongOnlyToTheTolerancesIsThatOfItsDirection) {
  // A length of 1 + 9e-7 is accepted. With a lever arm of 37 mm it would move the coupling point by 0.07 um in a step,
  // and the damper would see that as a speed.
  const Bone bone = test::MakeBox(Pose{}, {10, 3, 6}, 0.2);
  CoupledParams params = DiscParams();
  params.coupling.p_TC_mm = {30, -20, 10};
  params.coupling.damping_Ns_per_mm = 0.02;
  const Pose start = DiscPose(Pose{}, {0, 0, 3 + kR});
  const auto press = [&](double length) {
    CoupledSimulation simulation(bone, params, start);
    const auto scaled = [&](const Vec3& p) {
      const Pose X = DiscPose(Pose{}, p);
      return Pose{length * X.R_AB, X.p_AB};
    };
    EXPECT_TRUE(simulation.SetDown(scaled({0, 0, 3 + kR})));
    CoupledInput in = Handle(scaled({0.01, 0.02, 3 + kR - 0.05}));
    in.rpm = 0;
    return simulation.Tick(in);
  };
  const CoupledOutput exact = press(1);
  EXPECT_GT(glm::length(exact.f_H_W_N), 1e-3);
  for (const double length : {1 - 9e-7, 1 + 9e-7}) {
    const CoupledOutput out = press(length);
    EXPECT_LE(glm::length(out.f_H_W_N - exact.f_H_W_N), 1e-9) << length;
    EXPECT_NEAR(glm::length(out.X_WT.R_AB), 1, 1e-15);
  }
}

TEST(CoupledFeed, SteadyPushFeedsAtTheRateThatTheLawPredicts) {
  // A disc that is lowered straight down: each point of the arc has the bite v cos(phi) / f, and the sum of the tooth
  // forces along the feed equals the push. The sum is integrated over the engaged arc at the tool's depth.
  const std::pair<const char*, double> pushes[] = {{"hertz_chip", 1},    {"hertz_chip", 5},    {"hertz_chip", 20},
                                                   {"two_component", 1}, {"two_component", 3}, {"two_component", 5}};
  for (const auto& [law, push_N] : pushes) {
    const Bone bone = test::MakeBox(Pose{}, {30, 2, 8}, 0.1);
    const Pose start = DiscPose(Pose{}, {0, 0, 4 + kR + 0.05});
    CoupledParams params = DiscParams();
    params.law = ForceLaw(law);
    CoupledSimulation simulation(bone, params, start);
    PushingHand hand(simulation, start);
    double z = start.p_AB.z;
    const ToothForce force = MakeToothForce(params.law, Tool(kSaw));
    const double E_star = CalcReducedModulus(kSaw.E_MPa, kSaw.nu, 19300, 0.28);
    int checked = 0;
    for (int i = 0; i < 2000 && z > 4 + kR - 3; ++i) {
      const CoupledOutput out = hand.Push({0, 0, -push_N});
      const double feed = (z - out.X_WT.p_AB.z) / 0.001;
      z = out.X_WT.p_AB.z;
      const double depth = 4 + kR - z;
      if (depth < 1) continue;
      const double alpha = std::acos(1 - depth / kR);
      double along_N = 0;
      for (int k = 0; k < 2000; ++k) {
        const double phi = alpha * ((k + 0.5) / 1000 - 1);
        const double bite = feed * std::cos(phi) / (kSaw.teeth * 7500 / 60.0);
        along_N += force(bite, Cortical(E_star)) * std::cos(phi) * kSaw.teeth / (2 * std::numbers::pi) * alpha / 1000;
      }
      // The engaged arc is known to a sixteenth of the spacing of the samples at each end, 0.02 mm of 9.5 mm, and the
      // look-ahead lengthens it by 0.5 % at 1 mm depth.
      EXPECT_NEAR(along_N / out.f_H_W_N.z, 1, 0.01) << law << " " << push_N;
      // The hand sets the coupling's stretch; only the tool's feed in this tick reduces it.
      EXPECT_NEAR(out.f_H_W_N.z, push_N - feed * 0.001, 1e-6 * push_N);
      EXPECT_EQ(out.substeps, 1);
      EXPECT_EQ(out.status, kCoupledOk);
      ++checked;
    }
    EXPECT_GT(checked, 300);
  }
}

TEST(CoupledSpindle, StoppedToolRestsOnTheBoneAgainstTheCoupling) {
  const Bone bone = test::MakeBox(Pose{}, {30, 2, 8}, 0.1);
  CoupledSimulation simulation(bone, DiscParams(), DiscPose(Pose{}, {0, 0, 4 + kR + 0.3}));
  CoupledOutput out;
  for (int i = 0; i <= 500; ++i) {
    out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, 4 + kR + 0.3 - 0.01 * i}), 0));
    EXPECT_EQ(out.removed_mm3, 0);
  }
  // 4.7 mm below the surface at 1 N/mm; the contact yields less than 10 um.
  EXPECT_NEAR(out.X_WT.p_AB.z, 4 + kR, 0.01);
  EXPECT_NEAR(out.f_H_W_N.z, 1 * (out.X_WT.p_AB.z - (4 + kR - 4.7)), 1e-6);
  EXPECT_NEAR(out.f_H_W_N.z, 4.7, 0.02);
  EXPECT_TRUE(out.status & kCoupledSpindleStopped);
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), bone.CalcHash());
}

}  // namespace
}  // namespace kerf
