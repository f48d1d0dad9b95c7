// Tests of whether the hub of a disc or the handpiece is inside the bone.
#include "app/window/holder_watch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/solids.h"

namespace kerf {
namespace {

constexpr double kBlockHalf_mm = 12;  // of the block, along each axis
constexpr double kBlockVoxel_mm = 0.4;

Bone MakeBlockAroundOrigin() {
  return test::MakeBox({}, Vec3{2 * kBlockHalf_mm}, kBlockVoxel_mm);
}

// A disc of 15 mm radius, upright, that comes from above. `x_mm`: of its plane.
Pose AtDepth(double depth_mm, double x_mm) {
  const double quarter = std::sqrt(0.5);
  return {{quarter, 0, quarter, 0}, {x_mm, 0, kBlockHalf_mm + 15 - depth_mm}};  // its spindle points to +x
}

TEST(HolderWatch, TheHubIsInTheBoneFromTheDepthOfItsRim) {
  const Bone block = MakeBlockAroundOrigin();
  HolderWatch watch;
  watch.SetTool(DiscSaw{.diameter_mm = 30, .thickness_mm = 0.5});
  // The hub's radius is 22 % of the disc's.
  const double reaches_mm = 15 - 0.22 * 15;
  const double band_mm = 0.5 * block.band_mm();
  const auto in_bone = [&](double depth_mm) {
    watch.Update(block, AtDepth(depth_mm, 0));
    return watch.hub_in_bone();
  };
  EXPECT_FALSE(in_bone(5));
  EXPECT_FALSE(in_bone(reaches_mm + band_mm - 0.1));
  EXPECT_TRUE(in_bone(reaches_mm + band_mm + 0.1));
  // It stays so until the hub is out.
  EXPECT_TRUE(in_bone(reaches_mm + 0.1));
  EXPECT_FALSE(in_bone(reaches_mm - 0.1));
  EXPECT_FALSE(in_bone(reaches_mm + band_mm - 0.1));
}

TEST(HolderWatch, TheHandpieceIsInTheBoneBesideTheBlade) {
  const Bone block = MakeBlockAroundOrigin();
  HolderWatch watch;
  watch.SetTool(DiscSaw{.diameter_mm = 30, .thickness_mm = 0.5});
  // The blade is in air beside the block, with its centre at the height of the block's middle, and its handpiece points
  // to the block; then away from it.
  watch.Update(block, AtDepth(15 + kBlockHalf_mm, -kBlockHalf_mm - 10));
  EXPECT_TRUE(watch.handpiece_in_bone());
  watch.Update(block, AtDepth(15 + kBlockHalf_mm, kBlockHalf_mm + 5));
  EXPECT_FALSE(watch.handpiece_in_bone());
  EXPECT_FALSE(watch.hub_in_bone());
}

TEST(HolderWatch, KeepsWhereTheHubFirstWasInTheBoneDuringACut) {
  const Bone block = MakeBlockAroundOrigin();
  const DiscSaw saw{.diameter_mm = 30, .thickness_mm = 0.5};
  HolderWatch watch;
  watch.SetTool(saw);
  watch.Update(block, AtDepth(20, 0));
  EXPECT_FALSE(watch.places().hub_W) << "the saw did not cut there";
  watch.Update(block, AtDepth(5, 0));
  watch.NoteCut();
  EXPECT_FALSE(watch.places().hub_W) << "the hub was not in the bone";
  watch.Update(block, AtDepth(15, 4));
  watch.NoteCut();
  ASSERT_TRUE(watch.places().hub_W);
  const Vec3 first_W = *watch.places().hub_W;
  EXPECT_LT(block.SignedDistance(first_W), 0);
  EXPECT_LT(glm::length(first_W - Vec3{4, 0, kBlockHalf_mm}), 5) << "within the hub";
  watch.Update(block, AtDepth(20, -4));
  watch.NoteCut();
  EXPECT_EQ(watch.places().hub_W, first_W);
  watch.SetTool(saw);  // of another session
  EXPECT_FALSE(watch.places().hub_W);
}

TEST(HolderWatch, ABurrHasNoHub) {
  const Bone block = MakeBlockAroundOrigin();
  HolderWatch watch;
  watch.SetTool(BallBurr{});
  watch.Update(block, {});
  EXPECT_FALSE(watch.hub_in_bone());
}

}  // namespace
}  // namespace kerf
