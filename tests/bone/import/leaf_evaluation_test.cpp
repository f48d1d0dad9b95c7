// What is computed for a whole leaf has the bits of what is computed point by point.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <utility>

#include "bone/import/ct_solid.h"
#include "bone/import/spline_field.h"
#include "bone/import/tissue.h"

namespace kerf {
namespace {

TEST(SplineField, LatticeHasTheBitsOfItsPoints) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> sample(-1000, 2000);
  const std::array<int, 3> size{9, 17, 23};
  std::vector<float> samples(static_cast<std::size_t>(size[0]) * size[1] * size[2]);
  for (float& s : samples) s = sample(random);
  const SplineField field(size, samples, true);
  std::uniform_real_distribution<double> first(-4, 20);  // also beyond the lattice
  std::uniform_real_distribution<double> reach(-SplineField::kLatticeReach, SplineField::kLatticeReach);
  for (int round = 0; round < 200; ++round) {
    LatticePositions at_V{};
    for (auto& along : at_V) {
      const double from = first(random), step = reach(random) / 7;
      for (std::size_t n = 0; n < along.size(); ++n) along[n] = from + step * static_cast<double>(n);
    }
    std::array<double, 512> values{};
    field.AtLattice(at_V, values);
    for (std::size_t n = 0; n < values.size(); ++n) {
      ASSERT_EQ(values[n], field.At({at_V[0][n / 64], at_V[1][n / 8 % 8], at_V[2][n % 8]})) << round << " " << n;
    }
  }
}

/// A ball of bone with a bright core in soft tissue, in a CT whose axes are turned by `angle` about z.
Isolation MakeBall(const Vec3& spacing_mm, double angle) {
  Isolation ball;
  Volume& ct = ball.ct;
  ct.size = {30, 26, 22};
  ct.spacing_mm = spacing_mm;
  ct.origin_W = {-7.3, 4.1, 100.2};
  ct.axes_W = glm::dmat3(std::cos(angle), std::sin(angle), 0, -std::sin(angle), std::cos(angle), 0, 0, 0, 1);
  const Vec3 centre_W = ct.WorldFromVoxel({14.2, 12.7, 10.6});
  for (int k = 0; k < ct.size[2]; ++k) {
    for (int j = 0; j < ct.size[1]; ++j) {
      for (int i = 0; i < ct.size[0]; ++i) {
        const double r = glm::length(ct.WorldFromVoxel({i, j, k}) - centre_W);
        ct.hu.push_back(static_cast<std::int16_t>(std::clamp(2600 - 460 * r, 40.0, 2200.0)));
        ball.bone.push_back(ct.hu.back() >= 300 ? 1 : 0);
        ball.keep.push_back(i + j > 14 ? 1 : 0);  // the other side was dropped
      }
    }
  }
  return ball;
}

// Turned axes have no positions by axis, and are computed point by point.
TEST(LeafEvaluation, ValuesAndRegionsHaveTheBitsOfTheirPoints) {
  for (const auto& [spacing_mm, angle] : {std::pair(Vec3(0.5), 0.0), {Vec3(0.4, 0.4, 0.9), 0.0}, {Vec3(0.5), 0.3}}) {
    const Isolation ball = MakeBall(spacing_mm, angle);
    const std::vector<std::uint8_t> no_cavities(ball.bone.size(), 0);
    const CtSolid solid(ball, no_cavities, 300, 575);
    EXPECT_EQ(solid.map().HasPositions(0.1), angle == 0);
    const TissueMap tissue(ball.ct, ball.bone, ball.bone, &solid.hu(), false, {});
    EXPECT_GT(tissue.tooth_mm3(), 0);  // the core is as bright as enamel
    std::set<int> found;
    int inside = 0;
    const Vec3 middle_W = solid.box().centre();
    for (int leaf = 0; leaf < 64; ++leaf) {
      LeafPlace place{{}, 0.2};
      for (int a = 0; a < 3; ++a) {
        place.first[static_cast<std::size_t>(a)] =
            static_cast<int>(std::floor(middle_W[a] / place.voxel_mm)) + 8 * ((leaf >> 2 * a & 3) - 2);
      }
      LeafValues values{};
      if (angle == 0) solid.EvaluateLeaf(place, values);
      WantedVoxels wanted;
      for (int n = 0; n < kLeafVoxels; ++n) wanted[static_cast<std::size_t>(n)] = n % 3 != 0;
      LeafRegions regions;
      regions.fill(-1);
      tissue.FindRegions(place, wanted, regions);
      for (int n = 0; n < kLeafVoxels; ++n) {
        const auto at = static_cast<std::size_t>(n);
        const Vec3 p_W = place.CalcPosition(n);
        if (angle == 0) {
          ASSERT_EQ(values[at], static_cast<float>(solid.Value(p_W)));
          inside += values[at] < 0 ? 1 : 0;
        }
        ASSERT_EQ(regions[at], wanted[at] ? tissue.RegionAt(p_W) : -1);
        found.insert(regions[at]);
      }
    }
    EXPECT_EQ(inside > 0, angle == 0);
    EXPECT_GE(found.size(), 3u);  // tooth, another region, and those that are not wanted
  }
}

}  // namespace
}  // namespace kerf
