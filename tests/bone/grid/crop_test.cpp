#include "bone/grid/crop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "bone/grid/build.h"
#include "bone/grid/parts_reader.h"
#include "bone/grid/set_leaf.h"
#include "support/solids.h"

namespace kerf {
namespace {

TEST(CropBone, IsBitIdenticalInTheBoxAndAirBeyond) {
  const Bone bone = test::MakeSphere({0, 0, 0}, 8, 0.2);
  const Box3 box{{-2, -3, 1}, {5, 20, 30}};
  const Bone part = CropBone(bone, box);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> fraction(0, 1);
  for (int i = 0; i < 2000; ++i) {
    // The point is at least a voxel inside the box, so that all neighbours used by the interpolation are also inside.
    const Vec3 in =
        box.lower + Vec3(0.2) + Vec3(fraction(random), fraction(random), fraction(random)) * (box.size() - Vec3(0.4));
    EXPECT_EQ(part.SignedDistance(in), bone.SignedDistance(in));
    EXPECT_EQ(part.ModulusAt(in), bone.ModulusAt(in));
  }
  // This point is more than a leaf (8 voxels) away from the box.
  EXPECT_GT(bone.band_mm(), 0);
  EXPECT_LT(bone.SignedDistance({-4, 0, 4}), 0);
  EXPECT_NEAR(part.SignedDistance({-4, 0, 4}), part.band_mm(), 1e-6);
  EXPECT_LT(part.CalcVolume(), bone.CalcVolume());
}

TEST(CropBone, LargeBoxGivesTheWholeBone) {
  const Bone bone = test::MakeSphere({1, 2, 3}, 4, 0.25);
  EXPECT_EQ(CropBone(bone, Box3{{-10, -10, -10}, {10, 10, 10}}).CalcHash(), bone.CalcHash());
  EXPECT_EQ(CropBone(bone, Box3{}).CalcHash(), bone.CalcHash());
}

TEST(CropBone, KeepsBothFieldsOfABoneThatWasCut) {
  Bone bone = test::MakeSphere({1, 2, 3}, 4, 0.25);
  // Rounded values do not reach the band, so leaves far from the surface are stored, with one value each.
  RoundDistances(bone, 6);
  const Box3 all{{-10, -10, -10}, {10, 10, 10}};
  CutAway(bone, all, [](const Vec3& p_W) { return 0.4 - std::abs(p_W.x - 1.03); });
  const Bone part = CropBone(bone, all);
  EXPECT_EQ(part.CalcVolume(), bone.CalcVolume());
  EXPECT_EQ(part.CalcHash(), bone.CalcHash());
  const PartsReader of_bone(GridsOf(bone)), of_part(GridsOf(part));
  for (auto leaf = GridsOf(bone).cut->tree().cbeginLeaf(); leaf; ++leaf) {
    const PhiParts was = of_bone.At(leaf->origin()), is = of_part.At(leaf->origin());
    ASSERT_TRUE(std::equal(was.whole, was.whole + 512, is.whole));
    ASSERT_TRUE(std::equal(was.cut, was.cut + 512, is.cut));
  }
}

}  // namespace
}  // namespace kerf
