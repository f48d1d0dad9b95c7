// Samples at many points at once, compared with single ones.
#include "cut/contact/probe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "base/core/heap_guard.h"
#include "cut/contact/met_material.h"
#include "cut/removal/carve.h"
#include "support/solids.h"

namespace kerf {
namespace {

/// A block of two layers of tissue, with region voxels of another size than those of the distance.
Bone MakeTwoLayers() {
  SolidField solid;
  solid.value = [](const Vec3& p) { return test::BoxDistance(p - Vec3(1, 2, 3), {8, 7, 6}); };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = [](const Vec3& p) { return p.x + p.z > 4 ? 24 : 32; };
  MaterialTable table = test::OneRegionTable(24);
  table.Add({32, "cancellous", Tissue::kCancellous, 1370, 0.3, true, "test"});
  return MakeBone(solid, Box3{Vec3(-8), Vec3(10)}.Grown(1), {0.2, 0.31, {}}, table);
}

/// Draws points of which most are in the bone or near it, and some are far beyond the reach of a grid's index.
std::vector<Vec3> DrawPoints(std::size_t count) {
  std::mt19937 random(1);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double reach = i % 16 == 5 ? 1e10 : 11;
    std::uniform_real_distribution<double> draw(-reach, reach);
    const double x = draw(random);
    const double y = draw(random);
    points.emplace_back(x, y, draw(random));
  }
  return points;
}

class ManyPoints : public testing::Test {
 protected:
  ManyPoints() : bone_(MakeTwoLayers()), field_(bone_, 0) {}
  ~ManyPoints() override { SetVectorTarget(""); }

  const Pose X_WT_{glm::angleAxis(0.7, glm::normalize(Vec3(1, -2, 3))), {0.3, -0.2, 0.1}};
  Bone bone_;
  BoneField field_;
};

TEST_F(ManyPoints, HaveTheBitsOfSingleOnesAtEveryVectorWidth) {
  const Probe probe(field_, X_WT_);
  // Counts below, at and above those of points that are computed together.
  for (const std::size_t count : {0u, 1u, 7u, 8u, 63u, 64u, 65u, 5000u}) {
    const std::vector<Vec3> points = DrawPoints(count);
    PointList list;
    list.Reserve(count);
    for (const Vec3& p : points) list.Add(p);
    std::vector<double> expected;
    for (const Vec3& p : points) expected.push_back(probe.Distance(p));
    for (const std::string& target : VectorTargets()) {
      SetVectorTarget(target);
      std::vector<double> distances(count + 1, 7.5);
      probe.Distances(list, distances.data());
      EXPECT_EQ(distances.back(), 7.5) << "written beyond the end";
      distances.pop_back();
      EXPECT_EQ(distances, expected) << target << ", " << count;
    }
  }
}

TEST_F(ManyPoints, RegionsAndModuliAreThoseOfTheVoxelsAroundAtEveryVectorWidth) {
  const Probe probe(field_, X_WT_);
  const MaterialLookup materials(bone_, DiscSaw{});
  const std::vector<Vec3> points = DrawPoints(20000);
  PointList list;
  list.Reserve(points.size());
  for (const Vec3& p : points) list.Add(p);
  for (const std::string& target : VectorTargets()) {
    SCOPED_TRACE(target);
    SetVectorTarget(target);
    std::vector<std::uint8_t> regions(points.size());
    std::vector<double> E_MPa(points.size()), E_star_MPa(points.size());
    probe.InterpolateUniform(list, materials.moduli(), regions.data(), E_MPa.data(), E_star_MPa.data());
    int known = 0;
    int uniform = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto around = field_.FindRegionCell(probe.World(points[i])).regions;
      const bool is_one = std::ranges::all_of(around, [&](int region) { return region == around[0]; });
      uniform += is_one && around[0] != 0 ? 1 : 0;
      if (regions[i] == 0) continue;
      ++known;
      EXPECT_TRUE(is_one) << i;
      EXPECT_EQ(regions[i], around[0]) << i;
      ToothCut single;
      EXPECT_EQ(materials.Find(field_, probe.World(points[i]), kReadsTissue, single), regions[i]);
      ToothCut many;
      EXPECT_TRUE(materials.SetUniform(regions[i], E_MPa[i], E_star_MPa[i], kReadsTissue, many));
      EXPECT_EQ(many.E_MPa, single.E_MPa) << i;
      EXPECT_EQ(many.E_star_MPa, single.E_star_MPa) << i;
      EXPECT_EQ(many.tissue, single.tissue) << i;
    }
    // The rest is in leaves with a border between the tissues, or with air.
    EXPECT_GT(known, uniform / 5);
    EXPECT_LT(known, uniform);
  }
}

TEST_F(ManyPoints, UseNoHeap) {
  const Probe probe(field_, X_WT_);
  PointList list;
  list.Reserve(300);
  std::vector<double> distances(300);
  std::vector<std::uint8_t> regions(300);
  std::vector<double> E_MPa(300), E_star_MPa(300);
  const MaterialLookup materials(bone_, DiscSaw{});
  const std::vector<Vec3> points = DrawPoints(300);
  const HeapUseCounter heap_uses;
  {
    const HeapGuard guard;
    for (const Vec3& p : points) list.Add(p);
    probe.Distances(list, distances.data());
    probe.InterpolateUniform(list, materials.moduli(), regions.data(), E_MPa.data(), E_star_MPa.data());
    list.Clear();
  }
  EXPECT_EQ(heap_uses.count(), 0);
}

}  // namespace
}  // namespace kerf
