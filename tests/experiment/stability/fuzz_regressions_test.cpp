// Failures found by the random sequences of hard case 40, each reduced to its shortest form. The seed is the one that
// found the failure with the generator of that time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bone/models/block.h"
#include "cut/hand_sim/hands.h"
#include "device/devices/velocity.h"
#include "experiment/stability/verdict.h"

namespace kerf {
namespace {

/// Seed 1000032: where a cut ended because no spare leaves were left, adjacent cells of solid bone were counted as
/// whole.
TEST(FuzzRegression, VolumeAddsUpWhereTheSpareLeavesRanOut) {
  test::Verdict verdict("holds");
  BlockParams block;
  block.size_mm = {12, 8, 8};
  const Bone bone = MakeBlock(block, test::OneRegionTable());
  const double before_mm3 = bone.CalcVolume();
  CoupledParams params;
  params.tool = DiscSaw{.diameter_mm = 8.25};
  params.spare_leaves = 64;
  CoupledSimulation simulation(bone, params, {Quat(1, 0, 0, 0), Vec3(5, 0, -4)});
  const CoupledOutput out = simulation.Tick(test::Handle({Quat(1, 0, 0, 0), Vec3(5.5, 0, -4)}));
  EXPECT_TRUE(out.status & kCoupledLeavesUsedUp);
  double removed_mm3 = 0;
  for (const double r : simulation.CalcRemovedByRegion()) removed_mm3 += r;
  EXPECT_GT(removed_mm3, 0.1);
  const double after_mm3 = simulation.UpdateBone().CalcVolume();
  verdict.AtMost("relative volume unaccounted for", std::abs(before_mm3 - after_mm3 - removed_mm3) / before_mm3, 1e-12);
  double by_region_mm3 = 0;
  for (const auto& [id, volume] : simulation.UpdateBone().CalcRegionVolumes()) by_region_mm3 += volume;
  EXPECT_NEAR(by_region_mm3, after_mm3, 1e-9 * before_mm3);
}

/// Seed 20000006: a step in zero time gave an infinite velocity.
TEST(FuzzRegression, VelocityStaysFiniteHoweverShortTheTick) {
  AdaptiveVelocity velocity(0.01);
  velocity.Update({0, 0, 0}, 0.001);
  for (const double dt_s : {0.001, std::numeric_limits<double>::denorm_min(), 1e-300, 0.001, 0.001}) {
    EXPECT_TRUE(std::isfinite(velocity.Update(velocity.velocity() + Vec3(0.1, 0, 0), dt_s).x)) << dt_s;
  }
}

/// Seed 1000046: when the tool rotated about a distant coupling point, it moved along an arc whose length was not
/// measured: several voxels with a single look-up of the bone.
TEST(FuzzRegression, BoneIsLookedUpAllAlongATurnAboutADistantCouplingPoint) {
  test::Verdict verdict("holds");
  constexpr double kFuzzVoxel_mm = 0.2;
  const Pose start = test::DiscPose(Pose{}, {0, 0, 3 + 1.25 - 0.5});
  double longest_mm = 0;
  for (const double arm_mm : {80.0, 1000.0}) {
    CoupledParams params = test::DiscParams();
    params.coupling.p_TC_mm = {arm_mm, 0, 0};
    params.coupling.max_force_N = 0.1;  // the bone holds the disc, and the hand turns it
    params.tool = DiscSaw{.diameter_mm = 2.5, .E_MPa = 1000};
    params.max_iterations = 1;
    params.max_substeps = 1;
    CoupledSimulation simulation(test::MakeBox(Pose{}, {26, 3, 6}, kFuzzVoxel_mm), params, start);
    Pose X_WT = start;
    for (int i = 1; i <= 50; ++i) {
      const Pose X_WH{glm::normalize(start.R_AB * glm::angleAxis(0.2 * i, Vec3(0, 0, 1))), start.p_AB};
      const CoupledOutput out = simulation.Tick(test::Handle(X_WH, 7500, 0.02));
      if (out.engaged_teeth > 0) longest_mm = std::max(longest_mm, glm::length(out.X_WT.p_AB - X_WT.p_AB));
      X_WT = out.X_WT;
    }
  }
  EXPECT_GT(longest_mm, 0.01);
  verdict.AtMost("longest motion of the disc in one look-up", longest_mm, 0.5 * kFuzzVoxel_mm * (1 + 1e-6), "mm");
}

/// Seed 1000016: after setting down far from the origin, the coupling's energy was computed from poses in two different
/// frames.
TEST(FuzzRegression, SettingDownFarFromTheOriginStoresTheRightSpringEnergy) {
  test::Verdict verdict("holds");
  const Vec3 there(0.9 * kWorldReach_mm, -0.8 * kWorldReach_mm, 0);
  const Pose X_WB{Quat(1, 0, 0, 0), there};
  const Pose start = test::DiscPose(X_WB, {0, 0, 3 + 11 - 0.5});
  CoupledSimulation simulation(test::MakeBox(X_WB, {26, 3, 6}, 0.4), test::DiscParams(), start);
  simulation.Tick(test::Handle(start, 0));
  ASSERT_TRUE(simulation.SetDown(test::DiscPose(X_WB, {0.1, 0, 3 + 11 - 0.5})));
  const CoupledOutput out = simulation.Tick(test::Handle(start, 0));
  // A spring of 1 N/mm is stretched by 0.1 mm.
  verdict.AtMost("energy of the next tick", std::abs(out.stored_mJ) + std::abs(out.hand_mJ), 0.0051, "mJ");
}

/// Seeds 2000029 and 4000009: the slab's guide is stiff, and a rotation about a distant coupling point stretched it
/// further than the step had assumed. This created energy, several joules in a long tick.
TEST(FuzzRegression, TurnAgainstTheSlabsGuideCreatesNoEnergy) {
  test::Verdict verdict("holds");
  double lowest_mJ = 0, moved_mJ = 0;
  int in_slab = 0;
  for (const double arm_mm : {0.0, 80.0, 1000.0}) {
    for (const int max_substeps : {1, 24}) {
      // The tool is small, so that the hand can tilt it against the guide.
      CoupledParams params;
      params.tool = DiscSaw{.diameter_mm = 2, .teeth = 100};
      params.coupling.p_TC_mm = {arm_mm, 0, 0};
      params.coupling.max_force_N = 0.1;
      params.coupling.max_torque_Nmm = 1e6;
      params.max_substeps = max_substeps;
      const Pose start = test::DiscPose(Pose{}, {0, 0, 4 + 1 - 0.3});
      CoupledSimulation simulation(test::MakeBox(Pose{}, {12, 4, 8}, 0.2), params, start);
      double lost_mJ = 0;
      Pose X_WH = start;
      for (int i = 0; i < 600; ++i) {
        simulation.SetFidelity(Fidelity::kSlab);
        X_WH.p_AB = test::DiscPose(Pose{}, {0, 0, 4 + 1 - 0.3 - 0.005 * std::min(i, 300)}).p_AB;
        if (i > 300) {
          const double tilt = 0.01 * std::min(i - 300, 100);
          X_WH.R_AB = glm::normalize(start.R_AB * glm::angleAxis(tilt, Vec3(1, 0, 0)) *
                                     glm::angleAxis(0.05 * (i - 300), Vec3(0, 0, 1)));
        }
        const CoupledOutput out = simulation.Tick(test::Handle(X_WH));
        in_slab += out.fidelity == Fidelity::kSlab;
        lost_mJ += out.cut_mJ + out.friction_mJ + out.numerical_mJ;
        moved_mJ += std::abs(out.hand_mJ) + std::abs(out.spindle_mJ);
        lowest_mJ = std::min(lowest_mJ, lost_mJ);
      }
    }
  }
  EXPECT_GT(in_slab, 100);
  EXPECT_GT(moved_mJ, 1);
  verdict.AtLeast("minimum energy lost to bone and time steps", lowest_mJ, -1e-6, "mJ");
}

}  // namespace
}  // namespace kerf
