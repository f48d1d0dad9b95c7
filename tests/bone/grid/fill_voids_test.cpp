#include "bone/grid/fill_voids.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "bone/grid/grids.h"
#include "bone/material/region_table.h"
#include "kerf/surface.h"
#include "support/message_of.h"
#include "support/solids.h"

namespace kerf {
namespace {

constexpr int kSide = 40;  // five leaves; voxels at the border are outside

int Index(int x, int y, int z) {
  return (x * kSide + y) * kSide + z;
}

// Labels the face-connected parts of the voxels that are not solid: 0 for those that reach the border, 1 and up for the
// others, -1 for solid voxels. Returns the number of parts that do not reach the border.
int LabelVoids(const std::vector<bool>& solid, std::vector<int>& label) {
  label.assign(solid.size(), -1);
  std::vector<bool> seen(solid.size(), false);
  int voids = 0;
  for (int seed = 0; seed < kSide * kSide * kSide; ++seed) {
    if (solid[seed] || seen[seed]) continue;
    std::vector<int> part{seed};
    seen[seed] = true;
    bool leads_out = false;
    for (std::size_t n = 0; n < part.size(); ++n) {
      const int at[3] = {part[n] / (kSide * kSide), part[n] / kSide % kSide, part[n] % kSide};
      for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {-1, 1}) {
          int next[3] = {at[0], at[1], at[2]};
          next[axis] += side;
          if (next[axis] < 0 || next[axis] >= kSide) {
            leads_out = true;
            continue;
          }
          const int i = Index(next[0], next[1], next[2]);
          if (solid[i] || seen[i]) continue;
          seen[i] = true;
          part.push_back(i);
        }
      }
    }
    if (!leads_out) ++voids;
    for (const int i : part) label[i] = leads_out ? 0 : voids;
  }
  return voids;
}

TEST(FillVoids, FieldWithoutASurfaceIsRefusedAsEmpty) {
  openvdb::FloatTree field(1);
  std::vector<openvdb::Coord> filled;
  EXPECT_EQ(FillVoids(field, 0.1, filled).count, 0u);
  // Mixed blocks, in none of which a voxel is inside: thinner than a voxel, for example.
  SolidField solid;
  solid.value = [](const Vec3&) { return 1.0; };
  solid.classify = [](const Vec3&, double) { return BlockClass::kMixed; };
  solid.region = [](const Vec3&) { return 1; };
  solid.is_distance = false;
  FilledVoids voids;
  BuildOptions options{0.2, 0.2, {}};
  options.fill_voids = &voids;
  EXPECT_EQ(test::MessageOf([&] {
              MakeBone(solid, Box3{Vec3(0), Vec3(4)}, options, DefaultMandibleTable());
            }),
            "the bone is empty: no point within the box is inside it");
}

TEST(FillVoids, FillsVoxelsThatAFloodFromOutsideDoesNotReach) {
  std::mt19937 random(4);
  for (const double fraction : {0.1, 0.3, 0.5, 0.7}) {
    std::vector<bool> solid(kSide * kSide * kSide);
    std::bernoulli_distribution is_solid(1 - fraction);
    for (int x = 8; x < kSide - 8; ++x) {
      for (int y = 8; y < kSide - 8; ++y) {
        for (int z = 8; z < kSide - 8; ++z) solid[Index(x, y, z)] = is_solid(random);
      }
    }
    openvdb::FloatTree field(1.0f);
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        for (int z = 0; z < kSide; ++z) {
          field.setValueOn(openvdb::Coord(x, y, z), solid[Index(x, y, z)] ? -0.25f : 0.5f);
        }
      }
    }
    std::vector<int> label;
    const int voids = LabelVoids(solid, label);
    std::vector<openvdb::Coord> blocks;
    const FilledVoids filled = FillVoids(field, 0.5, blocks);
    EXPECT_EQ(filled.count, static_cast<std::size_t>(voids)) << fraction;
    EXPECT_TRUE(blocks.empty());
    int changed = 0;
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        for (int z = 0; z < kSide; ++z) {
          const int i = Index(x, y, z);
          const float expected = solid[i] ? -0.25f : label[i] == 0 ? 0.5f : -1.0f;
          ASSERT_EQ(field.getValue(openvdb::Coord(x, y, z)), expected) << x << " " << y << " " << z;
          changed += label[i] > 0 ? 1 : 0;
        }
      }
    }
    EXPECT_DOUBLE_EQ(filled.mm3, changed * 0.125);
  }
}

// A hollow so large that whole blocks of it have no voxels in the grid.
TEST(FillVoids, LargeHollowBecomesSolid) {
  SolidField ball = test::SphereField({0.03, -0.02, 0.01}, 8);
  ball.is_distance = false;
  SolidField shell = ball;
  shell.value = [ball](const Vec3& p) { return std::max(ball.value(p), 6 - glm::length(p)); };
  shell.classify = ClassifyByDistance(shell.value);
  BuildOptions options;
  const Box3 box = Box3{Vec3(-8), Vec3(8)}.Grown(2);
  const Bone hollow = MakeBone(shell, box, options, test::OneRegionTable());
  FilledVoids filled;
  options.fill_voids = &filled;
  const Bone solid = MakeBone(shell, box, options, test::OneRegionTable());
  EXPECT_EQ(filled.count, 1u);
  const double hollow_mm3 = 4.0 / 3 * std::numbers::pi * 216;
  EXPECT_NEAR(filled.mm3, hollow_mm3, 0.01 * hollow_mm3);
  EXPECT_NEAR(solid.CalcVolume() - hollow.CalcVolume(), hollow_mm3, 0.01 * hollow_mm3);
  // The result equals a bone that was solid from the start.
  options.fill_voids = nullptr;
  EXPECT_EQ(solid.CalcHash(), MakeBone(ball, box, options, test::OneRegionTable()).CalcHash());
}

TEST(Pieces, CrumbsBelowTheSmallestVolumeAreNotPieces) {
  SolidField field;
  // The balls' centres are voxel centres. A ball of 0.05 mm radius has 0.0005 mm3, and its one voxel counts 0.008 mm3.
  field.value = [](const Vec3& p) {
    return std::min({glm::length(p) - 2, glm::length(p - Vec3(4, 0, 0)) - 0.05, glm::length(p - Vec3(0, 4, 0)) - 0.25});
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Bone bone = MakeBone(field, Box3{Vec3(-6), Vec3(6)}, {0.2, 0.2, {}}, test::OneRegionTable());
  const Pieces split = SplitPieces(bone);
  ASSERT_EQ(split.pieces.size(), 2u);
  EXPECT_GT(split.pieces[1].CalcVolume(), kSmallestPiece_mm3);
  EXPECT_EQ(split.dust_count, 1u);
  EXPECT_GT(split.dust_mm3, 0);
  EXPECT_EQ(split.dust.CalcVolume(), split.dust_mm3);
  EXPECT_LT(split.dust_mm3, kSmallestPiece_mm3);
  EXPECT_NEAR(split.pieces[0].CalcVolume() + split.pieces[1].CalcVolume() + split.dust_mm3, bone.CalcVolume(), 1e-9);
}

}  // namespace
}  // namespace kerf
