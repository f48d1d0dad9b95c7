// Tests that compare the distance of a tool to a tissue with the closed form.
#include "session/score/region_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>

#include "bone/grid/build.h"
#include "bone/material/region_table.h"
#include "session/scene/exercise.h"

namespace kerf {
namespace {

constexpr double kVoxel_mm = 0.2;
constexpr double kCanal_mm = 1.4;  // radius; its axis is the x axis

/// Returns a block of 30 x 20 x 20 mm with a canal through it.
Bone MakeCanalBlock() {
  SolidField solid;
  solid.value = [](const Vec3& p) {
    const Vec3 out = glm::abs(p) - Vec3(15, 10, 10);
    return std::max({out.x, out.y, out.z});
  };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = [](const Vec3& p) { return std::hypot(p.y, p.z) < kCanal_mm ? 34 : 32; };
  BuildOptions options;
  options.voxel_mm = kVoxel_mm;
  options.region_voxel_mm = kVoxel_mm;
  return MakeBone(solid, Box3{Vec3(-16.5, -11.5, -11.5), Vec3(16.5, 11.5, 11.5)}, options, DefaultMandibleTable());
}

/// Returns an upright pose of a disc of 8 mm above the canal, in the plane x = 0, with its lowest point at z.
Pose Standing(double z_mm) {
  const Quat turn = glm::angleAxis(0.5 * std::numbers::pi, Vec3(0, 1, 0));
  return {turn, Vec3(0, 0, z_mm + 4)};
}

TEST(RegionDistance, MatchesACylinderInsideAndOutside) {
  const RegionDistance distance(MakeCanalBlock(), Tissue::kCanal);
  ASSERT_FALSE(distance.empty());
  DiscSaw saw;
  saw.diameter_mm = 8;
  // The canal's voxels end within half a voxel of its wall. Inside the canal, the deepest ball counts.
  for (const double z_mm : {9.0, 4.0, 2.0, 1.5, 1.0, 0.5}) {
    EXPECT_NEAR(distance.Calc(saw, Standing(z_mm)), z_mm - kCanal_mm, kVoxel_mm) << z_mm;
  }
  // Through the canal's axis and beyond, the depth is at most the canal's radius.
  EXPECT_NEAR(distance.Calc(saw, Standing(-1)), -kCanal_mm, kVoxel_mm);
  // If the disc lies flat above the canal, its flat is nearest.
  EXPECT_NEAR(distance.Calc(saw, {Quat(1, 0, 0, 0), Vec3(3, 0, 5)}), 5 - 0.125 - kCanal_mm, kVoxel_mm);
  EXPECT_NEAR(distance.Calc(BallBurr{}, {Quat(1, 0, 0, 0), Vec3(3, 0, 6)}), 6 - 3 - kCanal_mm, kVoxel_mm);
}

TEST(RegionDistance, ChangesByAtMostTheMotionAndIgnoresSpindleRotation) {
  const Bone bone = MakeCanalBlock();
  const RegionDistance distance(bone, Tissue::kCanal);
  // Moving by d changes the distance by at most d, and rotating about the spindle does not change it.
  const Quat turn = glm::normalize(Quat(0.7, 0.2, -0.5, 0.3));
  double last_mm = 0;
  for (int i = 0; i < 60; ++i) {
    const Pose X{turn, Vec3(-12 + 0.4 * i, 2, 12 - 0.2 * i)};
    const double now_mm = distance.Calc(DiscSaw{}, X);
    EXPECT_TRUE(i == 0 || std::abs(now_mm - last_mm) <= std::hypot(0.4, 0.2) + 1e-9) << i;
    const Pose turned{turn * glm::angleAxis(1.0, Vec3(0, 0, 1)), X.p_AB};
    EXPECT_NEAR(distance.Calc(DiscSaw{}, turned), now_mm, 1e-9);
    last_mm = now_mm;
  }
}

// A planned cut across the canal, whose floor is above, at or below the canal's wall, and one that ends beside it.
TEST(RegionDistance, OfAWantedCutIsThatOfItsFloorOrEnd) {
  const RegionDistance distance(MakeCanalBlock(), Tissue::kCanal);
  SceneExercise exercise;
  const auto from = [&](const Vec3& start_mm, const Vec3& end_mm, double depth_mm) {
    exercise.start_mm = start_mm;
    exercise.end_mm = end_mm;
    exercise.depth_mm = depth_mm;
    const WantedCut cut = MakeWantedCut(exercise, DiscSaw{});
    return distance.CalcFrom(std::span(&cut, 1));
  };
  for (const double depth_mm : {3.0, 6.0, 8.0}) {
    EXPECT_NEAR(from({0, -10, 10}, {0, 10, 10}, depth_mm), 10 - depth_mm - kCanal_mm, kVoxel_mm) << depth_mm;
  }
  EXPECT_LT(from({0, -10, 10}, {0, 10, 10}, 9), 0);
  // Along the canal, 4 mm beside its axis; the disc is 0.25 mm thick.
  EXPECT_NEAR(from({-5, 4, 10}, {5, 4, 10}, 12), 4 - 0.5 * DiscSaw{}.thickness_mm - kCanal_mm, kVoxel_mm);
}

TEST(RegionDistance, BoneWithoutTheTissueHasNone) {
  const RegionDistance distance(MakeCanalBlock(), Tissue::kTooth);
  EXPECT_TRUE(distance.empty());
  EXPECT_GT(distance.Calc(DiscSaw{}, Pose{}), 1e8);
}

}  // namespace
}  // namespace kerf
