#include "bone/models/block.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "bone/material/region_table.h"
#include "kerf/error.h"
#include "support/message_of.h"

namespace kerf {
namespace {

Quat RandomRotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(Quat{normal(random), normal(random), normal(random), normal(random)});
}

std::string MessageOf(const BlockParams& params, const MaterialTable& table = DefaultMandibleTable()) {
  return test::MessageOf([&] { MakeBlock(params, table); }, "accepted");
}

TEST(Block, VolumeIsThatOfTheBoxInAnyPose) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> offset(-50, 50);
  BlockParams params;
  params.size_mm = {9, 7, 5.3};
  params.voxel_mm = 0.2;
  const double volume = 9 * 7 * 5.3;
  for (int n = 0; n < 12; ++n) {
    params.X_WB = {n == 0 ? Quat{1, 0, 0, 0} : RandomRotation(random),
                   {offset(random), offset(random), offset(random)}};
    const Bone bone = MakeBlock(params, DefaultMandibleTable());
    // Faces are exact; along the 85 mm of edges, the piecewise-linear corner loses less than half a voxel's
    // cross-section.
    EXPECT_NEAR(bone.CalcVolume(), volume, 85.2 * 0.5 * 0.2 * 0.2) << n;
  }
}

TEST(Block, DistanceIsExactInsideAndOut) {
  std::mt19937 random(5);
  BlockParams params;
  params.size_mm = {8, 6, 4};
  params.X_WB = {RandomRotation(random), {3, -2, 7}};
  const auto at = [&](double x, double y, double z) { return CalcBlockDistance(params, params.X_WB.Point({x, y, z})); };
  EXPECT_NEAR(at(0, 0, 0), 0, 1e-12);          // middle of the top face
  EXPECT_NEAR(at(0, 0, 1.5), 1.5, 1e-12);      // above it
  EXPECT_NEAR(at(0, 0, -2), -2, 1e-12);        // the centre
  EXPECT_NEAR(at(3.5, 0, -2), -0.5, 1e-12);    // near a side
  EXPECT_NEAR(at(7, 7, -2), 5, 1e-12);         // off an edge: a 3-4-5 triangle
  EXPECT_NEAR(at(4 + 2, 3 + 3, 6), 7, 1e-12);  // off a corner: sqrt(2^2 + 3^2 + 6^2) = 7
}

TEST(Block, LayersBeginAtTheirDepthInAnyPose) {
  std::mt19937 random(8);
  BlockParams params;
  params.size_mm = {10, 8, 9};
  params.layers = {{1.7, 24}, {3.1, kCancellousRegion}, {0.9, 13}, {1, 6}};  // the last layer fills 3.3 mm
  const double borders[] = {1.7, 4.8, 5.7};
  const int regions[] = {24, kCancellousRegion, 13, 6};
  const double thickness[] = {1.7, 3.1, 0.9, 3.3};
  for (int n = 0; n < 5; ++n) {
    params.X_WB = {n == 0 ? Quat{1, 0, 0, 0} : RandomRotation(random), {0.03, 0.04, 0.05}};
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(CalcBlockRegion(params, params.X_WB.Point({1, 2, -borders[i] + 1e-9})), regions[i]);
      EXPECT_EQ(CalcBlockRegion(params, params.X_WB.Point({1, 2, -borders[i] - 1e-9})), regions[i + 1]);
    }
    const Bone bone = MakeBlock(params, DefaultMandibleTable());
    // In the grid, a border is known to half a voxel's diagonal.
    const double slack = 0.5 * std::sqrt(3.0) * params.voxel_mm;
    for (double depth = 0.05; depth < 9; depth += 0.05) {
      int layer = 0;
      double to_border = 1e9;
      for (const double border : borders) {
        layer += depth > border ? 1 : 0;
        to_border = std::min(to_border, std::abs(depth - border));
      }
      if (to_border > slack) {
        EXPECT_EQ(bone.RegionAt(params.X_WB.Point({0.5, -1, -depth})), regions[layer]) << depth;
      }
    }
    const std::map<int, double> volumes = bone.CalcRegionVolumes();
    ASSERT_EQ(volumes.size(), 4u);
    for (int i = 0; i < 4; ++i) {
      // A cell belongs to one region, so each of a layer's two borders may be off by half a voxel.
      EXPECT_NEAR(volumes.at(regions[i]), 80 * thickness[i], 80 * params.voxel_mm) << n;
    }
  }
}

TEST(Block, ThePlateIsCorticalCancellousCortical) {
  const BlockParams plate = MakePlateParams();
  double sum = 0;
  for (const MaterialLayer& layer : plate.layers) sum += layer.thickness_mm;
  EXPECT_DOUBLE_EQ(sum, plate.size_mm.z);
  EXPECT_EQ(CalcBlockRegion(plate, {0, 0, -1}), 24);
  EXPECT_EQ(CalcBlockRegion(plate, {0, 0, -6}), kCancellousRegion);
  EXPECT_EQ(CalcBlockRegion(plate, {0, 0, -13}), 24);
}

TEST(Block, BadParametersAreNamed) {
  const BlockParams good{{5, 5, 5}, {}, {}, 0.5};
  EXPECT_EQ(MessageOf(good), "accepted");
  BlockParams p = good;
  p.size_mm.y = -1;
  EXPECT_EQ(MessageOf(p), "block: size_y_mm = -1 is below 0.1; valid range 0.1 to 1000 mm");
  p = good;
  p.size_mm.z = std::nan("");
  EXPECT_EQ(MessageOf(p), "block: size_z_mm = nan is not a finite number; valid range 0.1 to 1000 mm");
  p = good;
  p.voxel_mm = 0;
  EXPECT_EQ(MessageOf(p), "block: voxel_mm = 0 is below 0.02; valid range 0.02 to 4 mm");
  p = good;
  p.X_WB.R_AB = {0, 0, 0, 0};
  EXPECT_THAT(MessageOf(p), testing::HasSubstr("quaternion that is not of unit length"));
  p = good;
  p.layers = {{1, 99}};
  EXPECT_EQ(MessageOf(p), "block: layer 1 has region 99, which is not in the region table");
  p.layers = {{1, 24}, {-2, 6}};
  EXPECT_EQ(MessageOf(p), "block: layer 2: thickness_mm = -2 is below 0.001; valid range 0.001 to 1000 mm");
  p.layers = {{6, 24}, {2, 6}};
  EXPECT_EQ(MessageOf(p), "block: layer 2 would begin 6 mm below the top of a block 5 mm high");
  p = good;
  p.size_mm = {1000, 1000, 1000};
  p.voxel_mm = 0.02;
  EXPECT_THAT(MessageOf(p), testing::HasSubstr("2^36 voxels"));
}

}  // namespace
}  // namespace kerf
