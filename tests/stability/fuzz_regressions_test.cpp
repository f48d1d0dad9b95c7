// What the random sequences of hard case 40 have found, each made as short as it goes. The seed is the one that found
// it, by the generator of that time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "coupled/hands.h"
#include "devices/velocity.h"
#include "models/block.h"
#include "stability/verdict.h"

namespace kerf {
namespace {

/// Seed 1000032: where a cut ends for want of leaves, cells of pure bone next to it were counted as whole.
TEST(FuzzRegression, VolumeAddsUpWhereTheSpareLeavesRanOut) {
  test::Verdict verdict("holds");
  BlockParams block;
  block.size_mm = {12, 8, 8};
  const Bone bone = MakeBlock(block, test::OneRegionTable());
  const double before_mm3 = bone.CalcVolume();
  CoupledParams params;
  params.tool = DiscSaw{.diameter_mm = 8.25};
  params.spare_leaves = 1;
  CoupledSimulation simulation(bone, params, {Quat(1, 0, 0, 0), Vec3(5, 0, -4)});
  const CoupledOutput out = simulation.Tick(test::Handle({Quat(1, 0, 0, 0), Vec3(5.5, 0, -4)}));
  EXPECT_TRUE(out.status & kCoupledLeavesUsedUp);
  double removed_mm3 = 0;
  for (const double r : simulation.CalcRemovedByRegion()) removed_mm3 += r;
  EXPECT_GT(removed_mm3, 0.1);
  const double after_mm3 = simulation.bone().CalcVolume();
  verdict.AtMost("volume not accounted for", std::abs(before_mm3 - after_mm3 - removed_mm3) / before_mm3, 1e-12);
  double by_region_mm3 = 0;
  for (const auto& [id, volume] : simulation.bone().CalcRegionVolumes()) by_region_mm3 += volume;
  EXPECT_NEAR(by_region_mm3, after_mm3, 1e-9 * before_mm3);
}

/// Seed 20000006: a step in no time at all was an infinite velocity.
TEST(FuzzRegression, VelocityStaysFiniteHoweverShortTheTick) {
  AdaptiveVelocity velocity(0.01);
  velocity.Update({0, 0, 0}, 0.001);
  for (const double dt_s : {0.001, std::numeric_limits<double>::denorm_min(), 1e-300, 0.001, 0.001}) {
    EXPECT_TRUE(std::isfinite(velocity.Update(velocity.velocity_mm_per_s() + Vec3(0.1, 0, 0), dt_s).x)) << dt_s;
  }
}

/// Seed 1000046: turning about a coupling point far off, the tool went on an arc that nothing measured: several voxels,
/// with one look at the bone.
TEST(FuzzRegression, ATurnAboutAFarCouplingPointIsLookedAtAllTheWay) {
  test::Verdict verdict("holds");
  constexpr double kVoxel_mm = 0.2;
  const Pose start = test::DiscPose(Pose{}, {0, 0, 3 + 11 - 0.5});
  double longest_mm = 0;
  for (const double arm_mm : {80.0, 1000.0}) {
    CoupledParams params = test::DiscParams();
    params.coupling.p_TC_mm = {arm_mm, 0, 0};
    params.coupling.stiffness_N_per_mm = 100;
    params.max_substeps = 1;
    CoupledSimulation simulation(test::MakeBox(Pose{}, {26, 3, 6}, kVoxel_mm), params, start);
    Pose X_WT = start;
    for (int i = 1; i <= 50; ++i) {
      // The handle turns about the coupling point.
      Pose X_WH;
      X_WH.R_AB = glm::normalize(start.R_AB * glm::angleAxis(0.05 * i, Vec3(0, 0, 1)));
      X_WH.p_AB = start.Point(params.coupling.p_TC_mm) - X_WH.Vector(params.coupling.p_TC_mm);
      const CoupledOutput out = simulation.Tick(test::Handle(X_WH));
      if (out.engaged_teeth > 0) longest_mm = std::max(longest_mm, glm::length(out.X_WT.p_AB - X_WT.p_AB));
      X_WT = out.X_WT;
    }
  }
  EXPECT_GT(longest_mm, 0.01);
  verdict.AtMost("longest way of the disc in one look", longest_mm, 0.51 * kVoxel_mm, "mm");
}

}  // namespace
}  // namespace kerf
