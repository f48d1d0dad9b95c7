// The table of leaves that the tick reads and writes, compared with the grids themselves.
#include "bone/grid/field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "base/core/heap_guard.h"
#include "bone/grid/ct_modulus.h"
#include "kerf/error.h"
#include "support/message_of.h"
#include "support/solids.h"

namespace kerf {
namespace {

/// Makes a box with two tissues and CT numbers, whose interior contains an entire upper node of the tree (128 voxels
/// along each edge).
Bone MakeLargeBox() {
  const Vec3 half(75, 45, 40);
  SolidField field;
  field.value = [=](const Vec3& p) { return test::BoxDistance(p - Vec3(32), half); };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3& p) { return p.z < 20 ? 32 : 24; };
  MaterialTable table = test::OneRegionTable();
  table.Add({32, "cancellous", Tissue::kCancellous, 1370, 0.4, true, "test"});
  Bone bone = MakeBone(field, Box3{Vec3(32) - half, Vec3(32) + half}.Grown(4), {0.5, 1.3, {}}, table);
  SetHu(
      bone, [](const Vec3& p) { return 1000 + 8 * p.x - 3 * p.y + 2 * p.z; }, 2.1);
  CtLaw law;
  law.name = "linear";
  law.tissue = "test";
  law.density = "qct";
  law.calibration = {{0, 0}, {3000, 3}};
  law.bands = {{0.1, 2, 0, 1000, 1}};
  law.tag = 'D';
  law.source = "test";
  UseCtModulus(bone, law, false);
  return bone;
}

Vec3 Draw(std::mt19937& random, double lower, double upper) {
  std::uniform_real_distribution<double> draw(lower, upper);
  const double x = draw(random);
  const double y = draw(random);
  return {x, y, draw(random)};
}

LeafIndex LeafOf(const Vec3& p_vox) {
  const CellPoint cell = FindCell(p_vox);
  return {cell.x >> 3, cell.y >> 3, cell.z >> 3};
}

TEST(BoneField, ReadsTheValuesOfTheGridsAtEveryPoint) {
  Bone bone = MakeLargeBox();
  const Bone untouched = bone;
  const BoneField field(bone, 1);
  EXPECT_EQ(bone.CalcHash(), untouched.CalcHash());
  EXPECT_EQ(bone.CalcVolume(), untouched.CalcVolume());
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    // Points inside, on and well outside the table's box; every other point is near the surface.
    Vec3 p = Draw(random, -80, 160);
    if (i % 2 == 0) p.z = 72 + 0.05 * (p.z - 40);
    EXPECT_EQ(field.Sample(p / 0.5), untouched.SignedDistance(p));
    EXPECT_EQ(field.RegionAt(p), untouched.RegionAt(p));
    double E_sum_MPa = 0;
    double weights = 0;
    const double by_ct = field.ModulusAt(p);
    const BoneField::RegionCell cell = field.FindRegionCell(p);
    VisitRegions(cell.regions, cell.f, [&](int region, double weight) {
      const double by_table = untouched.materials().regions().at(region).E_MPa;
      E_sum_MPa += weight * (by_ct > 0 && field.by_modulus(region) ? by_ct : by_table);
      weights += weight;
    });
    EXPECT_EQ(weights > 0 ? E_sum_MPa / weights : 0, untouched.ModulusAt(p));
  }
  EXPECT_EQ(field.Sample({1e300, 0, -1e300}), field.band_mm());
}

TEST(BoneField, GradientIsThatOfTheInterpolation) {
  Bone bone = test::MakeSphere({0.1, 0.2, 0.3}, 4, 0.2);
  const BoneField field(bone, 1);
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    // Within a cell the interpolation is linear along each axis, so a difference has only rounding errors: 1e-15 / 0.1.
    const Vec3 p = glm::floor(Draw(random, -22, 22)) + Draw(random, 0.1, 0.9);
    const Vec3 gradient = field.SampleGradient(p);
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 step(0);
      step[axis] = 0.1;
      EXPECT_NEAR(gradient[axis], (field.Sample(p + step) - field.Sample(p - step)) / (0.2 * 0.2), 1e-10);
    }
    const Vec3 r = 0.2 * p - Vec3(0.1, 0.2, 0.3);
    // Near the surface the field is a distance: the gradient's error is due to curvature, about h / r.
    if (std::abs(glm::length(r) - 4) < 0.2) {
      EXPECT_LT(glm::length(gradient - r / glm::length(r)), 0.1);
    }
  }
}

TEST(BoneField, WritingIntoPureBoneChangesBoneAndFieldAndUsesASpareLeaf) {
  Bone bone = MakeLargeBox();
  const std::uint64_t hash = bone.CalcHash();
  BoneField field(bone, 3);
  const Vec3 p(32, 30, 33);
  const LeafIndex leaf = LeafOf(p / 0.5);
  ASSERT_EQ(field.kind(leaf), BoneField::LeafKind::kInside);
  float* values = field.Write(leaf).cut;
  ASSERT_NE(values, nullptr);
  EXPECT_EQ(field.kind(leaf), BoneField::LeafKind::kOwn);
  EXPECT_EQ(field.spare_leaves(), 2);
  EXPECT_EQ(bone.CalcHash(), hash);  // no value has changed yet
  EXPECT_EQ(field.Read(leaf), values);
  std::fill_n(values, BoneField::kLeafVoxels, 0.25f);
  EXPECT_EQ(field.Sample(p / 0.5 + 0.5), 0.25);
  EXPECT_EQ(bone.SignedDistance(p + 0.25), 0.25);
  EXPECT_NE(bone.CalcHash(), hash);
}

TEST(BoneField, EveryBoneLeafCanBeWrittenWithoutAllocation) {
  Bone bone = MakeLargeBox();
  BoneField field(bone, 30000);
  const LeafIndex lowest = field.lowest();
  const LeafIndex highest = field.highest();
  int taken = 0;
  bool right = true;
  double sum = 0;
  const HeapUseCounter heap_uses;
  {
    const HeapGuard guard;
    for (int x = lowest.x - 3; x <= highest.x + 3; ++x) {
      for (int y = lowest.y - 3; y <= highest.y + 3; ++y) {
        for (int z = lowest.z - 3; z <= highest.z + 3; ++z) {
          const LeafIndex leaf{x, y, z};
          const BoneField::LeafKind before = field.kind(leaf);
          taken += field.CountNeededSpares(leaf);
          const float* values = field.Write(leaf).cut;
          taken -= before == BoneField::LeafKind::kOutside ? 1 : 0;
          right = right && (values == nullptr) == (before == BoneField::LeafKind::kOutside);
          sum += field.Sample({8.0 * leaf.x + 7.3, 8.0 * leaf.y, 8.0 * leaf.z}) +
                 field.ModulusAt({4.0 * leaf.x, 4.0 * leaf.y, 4.0 * leaf.z});
        }
      }
    }
    field.ClearChanged();
  }
  EXPECT_TRUE(right);
  EXPECT_NE(sum, 0);
  EXPECT_EQ(heap_uses.count(), 0);
  EXPECT_GT(taken, 16 * 16 * 16);  // these include all leaves of an upper node
  EXPECT_EQ(field.spare_leaves(), 30000 - taken);
}

TEST(BoneField, ListsEachChangedLeafOnceInTheOrderOfTheFirstWrite) {
  Bone bone = test::MakeSphere({0, 0, 0}, 5, 0.2);
  BoneField field(bone, 4);
  const LeafIndex a = LeafOf({0, 0, 0});
  const LeafIndex b = LeafOf({25, 0, 0});  // on the surface: takes two spare leaves
  const LeafIndex c = LeafOf({-8, 0, 0});
  const LeafIndex d = LeafOf({0, -8, 0});
  for (const LeafIndex& leaf : {b, a, b, c, a}) EXPECT_NE(field.Write(leaf).cut, nullptr);
  EXPECT_EQ(field.Write(d).cut, nullptr);  // no spare leaf is left
  EXPECT_EQ(field.kind(d), BoneField::LeafKind::kInside);
  EXPECT_EQ(field.Write({1000, 0, 0}).cut, nullptr);  // air
  const auto changed = field.changed();
  EXPECT_EQ(std::vector<LeafIndex>(changed.begin(), changed.end()), (std::vector<LeafIndex>{b, a, c}));
  field.ClearChanged();
  EXPECT_TRUE(field.changed().empty());
  field.Write(c);
  EXPECT_EQ(field.changed().size(), 1u);
  field.Refill(2);
  EXPECT_NE(field.Write(d).cut, nullptr);
}

TEST(BoneField, AChangedLeafIsListedAgainOnlyAfterItWasCleared) {
  for (const int first : {0, 1, 2, 3, 4, 5}) {
    Bone bone = test::MakeSphere({0, 0, 0}, 5, 0.2);
    BoneField field(bone, 5);
    const auto leaf = [](int i) { return LeafIndex{-1, i / 2 - 1, i % 2 - 1}; };
    for (int i = 0; i < 5; ++i) ASSERT_NE(field.Write(leaf(i)).cut, nullptr);
    field.ClearChanged(first);
    std::vector<bool> listed(5, false);
    for (const LeafIndex& changed : field.changed()) {
      for (int i = 0; i < 5; ++i) {
        if (changed == leaf(i)) listed[static_cast<std::size_t>(i)] = true;
      }
    }
    EXPECT_EQ(field.changed().size(), static_cast<std::size_t>(5 - first));
    for (int i = 0; i < 5; ++i) EXPECT_EQ(listed[static_cast<std::size_t>(i)], i >= first) << first << " " << i;
    for (int i = 0; i < 5; ++i) field.Write(leaf(i));
    EXPECT_EQ(field.changed().size(), 5u);
  }
}

TEST(BoneField, SettleActivatesTheBandAndFreesEmptiedLeaves) {
  Bone bone = test::MakeSphere({0, 0, 0}, 5, 0.2);
  const std::uint64_t active = bone.CountActiveVoxels();
  BoneField field(bone, 16);
  const LeafIndex cut = LeafOf({-8, 0, 0});
  const auto band = static_cast<float>(field.band_mm());
  std::uint64_t cleared = 0;  // number of band voxels that the eight leaves clear
  for (int i = 0; i < 16 * 16 * 16; ++i) {
    const Vec3 p_vox(i / 256, i / 16 % 16, i % 16);
    cleared += std::abs(field.Sample(p_vox)) < field.band_mm() ? 1u : 0u;
  }
  // Of the eight leaves only the lowest one becomes air. The cells of a leaf extend into its upper neighbours, and each
  // of the other seven has an upper neighbour that still holds bone.
  for (int corner = 0; corner < 8; ++corner) {
    const LeafIndex leaf{(corner >> 2) & 1, (corner >> 1) & 1, corner & 1};
    const BoneField::CutValues values = field.Write(leaf);
    std::fill_n(values.cut, BoneField::kLeafVoxels, band);
    BoneField::SetPhi(values);
  }
  float* values = field.Write(cut).cut;
  for (int i = 0; i < 100; ++i) values[i] = -0.5f * band;
  // One voxel holds the lowest leaf open, so that the bone knows its cut before the leaf is emptied.
  field.Write({0, 0, 0}).cut[0] = 0.9f * band;
  field.Settle();
  ASSERT_EQ(field.kind({0, 0, 0}), BoneField::LeafKind::kOwn);
  field.Write({0, 0, 0}).cut[0] = band;
  const int spare = field.spare_leaves();
  const double volume = bone.CalcVolume();
  const std::uint64_t hash = bone.CalcHash();
  field.Settle();
  EXPECT_EQ(field.spare_leaves(), spare + 1);
  EXPECT_EQ(field.kind({0, 0, 0}), BoneField::LeafKind::kOutside);
  EXPECT_EQ(field.kind({1, 1, 1}), BoneField::LeafKind::kOwn);
  EXPECT_EQ(bone.CountActiveVoxels(), active + 100 - cleared);
  EXPECT_EQ(bone.CalcHash(), hash);
  EXPECT_NEAR(bone.CalcVolume(), volume, 1e-12 * volume);
  EXPECT_EQ(field.Sample({0, 0, 0}), field.band_mm());
  // The leaf that was given back is pure bone again.
  ASSERT_EQ(field.kind({-1, -1, -1}), BoneField::LeafKind::kInside);
  const float* again = field.Write({-1, -1, -1}).cut;
  ASSERT_NE(again, nullptr);
  EXPECT_TRUE(std::all_of(again, again + BoneField::kLeafVoxels, [&](float v) { return v == -band; }));
}

TEST(BoneField, TooLargeBoxIsRefusedBeforeAllocation) {
  // The largest box in which a bone may be made is accepted: 2^36 voxels, 512 per leaf, plus the layer around it.
  EXPECT_EQ(LeafTable<float>::CheckedSize({514, 514, 514}), std::size_t{514} * 514 * 514);
  // This is the box of a bone with crumbs at opposite corners of a large space.
  const float air = 1;
  for (const int far : {1 << 10, 1 << 27}) {
    const std::string message = test::MessageOf([&] {
      const LeafTable<float> table({0, 0, 0}, {far, far, far}, &air);
    });
    EXPECT_NE(message.find("limit is 2^36 voxels; use larger voxels"), std::string::npos) << message;
  }
}

TEST(BoneField, EmptyBoneIsAir) {
  Bone bone;
  BoneField field(bone, 1);
  EXPECT_EQ(field.Sample({0.3, -0.4, 100}), field.band_mm());
  EXPECT_EQ(field.RegionAt({0, 0, 0}), 0);
  EXPECT_EQ(field.Write({0, 0, 0}).cut, nullptr);
  EXPECT_LT(field.highest().x, field.lowest().x);
}

}  // namespace
}  // namespace kerf
