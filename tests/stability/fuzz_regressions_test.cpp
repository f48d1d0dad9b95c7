// What the random sequences of hard case 40 have found, each made as short as it goes. The seed is the one that found
// it, by the generator of that time.
#include <gtest/gtest.h>

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
  const Vec3 before = velocity.Update({0.1, 0, 0}, 0.001);
  EXPECT_EQ(velocity.Update({0.2, 0, 0}, std::numeric_limits<double>::denorm_min()), before);
  const Vec3 after = velocity.Update({0.3, 0, 0}, 0.001);
  EXPECT_TRUE(std::isfinite(after.x));
}

}  // namespace
}  // namespace kerf
