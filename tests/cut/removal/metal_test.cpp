// Metal in the bone is not removed.
#include <gtest/gtest.h>

#include "cut/removal/cutter.h"
#include "cut/removal/metal_voxels.h"
#include "strokes.h"

namespace kerf {
namespace {

using test::Step;

constexpr double kVoxel_mm = 0.2;
constexpr int kBone = 24;
constexpr int kMetal = 35;

/// A block with a ball of another region in it, which is metal or bone.
Bone MakeBlockWithBall(Tissue ball) {
  SolidField solid;
  solid.value = [](const Vec3& p) { return test::BoxDistance(p, Vec3(4, 3, 3)); };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = [](const Vec3& p) { return glm::length(p - Vec3(1, 0, 0)) < 1.5 ? kMetal : kBone; };
  MaterialTable table = test::OneRegionTable(kBone);
  table.Add({.id = kMetal, .name = "ball", .tissue = ball, .E_MPa = 1e5, .nu = 0.3, .source = "test"});
  return MakeBone(solid, Box3{Vec3(-6), Vec3(6)}, {kVoxel_mm, 0.3, {}}, table);
}

std::vector<Step> DrawStrokes(const Tool& tool) {
  std::mt19937 random(7);
  return test::DrawSteps(random, tool, test::StrokeKind::kFree, kVoxel_mm, 6, 40);
}

TEST(Metal, StaysAndTheRestIsCutAsIfItWereBone) {
  DiscSaw disc;
  disc.diameter_mm = 12;
  BallBurr ball;
  ball.diameter_mm = 3;
  for (const auto& [tool, with] :
       {std::pair{Tool(disc), CutWith::kWholeTool}, {Tool(disc), CutWith::kEdge}, {Tool(ball), CutWith::kWholeTool}}) {
    const std::vector<Step> steps = DrawStrokes(tool);
    const Bone initial = MakeBlockWithBall(Tissue::kMetal);
    Bone with_metal = initial, with_bone = MakeBlockWithBall(Tissue::kCortical);
    Bone first = initial;
    BoneField before(first), metal(with_metal), bone(with_bone);
    EXPECT_TRUE(metal.has_metal());
    EXPECT_FALSE(bone.has_metal());
    Cutter metal_cutter(metal, tool, with), bone_cutter(bone, tool, with);
    double sum_mm3 = test::CutAll(metal_cutter, steps);
    test::CutAll(bone_cutter, steps);
    double lost_vox = 0;
    int kept = 0;
    const LeafIndex low = before.lowest(), high = before.highest();
    for (int x = low.x; x <= high.x; ++x) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int z = low.z; z <= high.z; ++z) {
          const LeafIndex leaf{x, y, z};
          for (int i = 0; i < BoneField::kLeafVoxels; ++i) {
            const Vec3 p = kVoxel_mm * Vec3(8 * x + i / 64, 8 * y + i / 8 % 8, 8 * z + i % 8);
            const float old = before.Read(leaf)[i], now = metal.Read(leaf)[i], cut = bone.Read(leaf)[i];
            if (before.is_metal(before.RegionAt(p))) {
              ASSERT_EQ(now, old);
              kept += cut != old ? 1 : 0;
            } else {
              ASSERT_EQ(now, cut);
            }
            const auto occupancy = [](double phi) { return std::clamp(0.5 - phi / kVoxel_mm, 0.0, 1.0); };
            lost_vox += occupancy(static_cast<double>(old)) - occupancy(static_cast<double>(now));
          }
        }
      }
    }
    EXPECT_GT(kept, 100);
    EXPECT_NEAR(sum_mm3, lost_vox * std::pow(kVoxel_mm, 3), 1e-3 * sum_mm3);
    EXPECT_EQ(metal_cutter.CalcRemovedByRegion()[kMetal], 0) << "lost bone beside metal is no metal";
    EXPECT_GT(metal_cutter.CalcRemovedByRegion()[kBone], 0);
    // Repeated, the same motion removes nothing more.
    EXPECT_EQ(test::CutAll(metal_cutter, steps), 0);
  }
}

TEST(Metal, TakesNoMemoryWhereThereIsNone) {
  Bone bone = MakeBlockWithBall(Tissue::kCortical);
  BoneField field(bone);
  EXPECT_EQ(MetalVoxels(field).CalcMemoryBytes(), 0u);
  EXPECT_EQ(MetalVoxels(field).Find(field.lowest()), nullptr);
}

}  // namespace
}  // namespace kerf
