// Distances from a field of which only the zero level counts.
#include "bone/grid/solve_distances.h"

#include <gtest/gtest.h>
#include <openvdb/tools/FastSweeping.h>
#include <tbb/global_control.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "kerf/geometry.h"

namespace kerf {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;

constexpr int kBand = 4;

/// Returns the field in the leaves of a box in which it is at most `near` somewhere, and tiles of its sign elsewhere.
/// `value`: of a point, in voxels.
template <typename Value>
FloatGrid::Ptr MakeField(int reach, double voxel_mm, Value&& value, double near = 8) {
  auto field = FloatGrid::create(1.0f);
  field->setTransform(openvdb::math::Transform::createLinearTransform(voxel_mm));
  for (int x = -reach; x < reach; x += 8) {
    for (int y = -reach; y < reach; y += 8) {
      for (int z = -reach; z < reach; z += 8) {
        const Coord origin(x, y, z);
        auto* const leaf = new openvdb::FloatTree::LeafNodeType(origin, 0.0f, true);
        int inside = 0;
        double least = 1e9;
        for (openvdb::Index i = 0; i < 512; ++i) {
          const Coord ijk = leaf->offsetToGlobalCoord(i);
          const double at = value(Vec3(ijk.x(), ijk.y(), ijk.z()));
          leaf->setValueOnly(i, static_cast<float>(at));
          inside += at < 0 ? 1 : 0;
          least = std::min(least, std::abs(at));
        }
        if (least > near) {
          delete leaf;
          if (inside > 0) field->tree().addTile(1, origin, -1.0f, false);
        } else {
          field->tree().addLeaf(leaf);
        }
      }
    }
  }
  return field;
}

/// A lumpy ball with a sheet and thin holes; far from a distance.
double Lumps(const Vec3& p) {
  const double ball = glm::length(p) - 19 + 2.5 * std::sin(0.5 * p.x) * std::cos(0.4 * p.y) * std::sin(0.3 * p.z + 1);
  const double hole = std::hypot(p.x - 3.3, p.y + 2.1) - 1.2;
  const double sheet = std::max(std::abs(p.z - 21.4) - 0.4, glm::length(p) - 24);
  return (1 + 0.5 * std::sin(p.x)) * std::min(std::max(ball, -hole), sheet);
}

TEST(SolveDistances, HaveTheBitsOfOpenVdbsFastSweeping) {
  // The nearer the leaves end to the surface, the more solved voxels are beside tiles, whose values are no distances.
  for (const auto& [voxel_mm, near] : {std::pair{0.1, 8.0}, {0.37, 4.0}, {0.8, 1.0}, {2.0, 0.5}}) {
    const FloatGrid::Ptr field = MakeField(32, voxel_mm, Lumps, near);
    KeepNearSurface(field->tree(), kBand);
    const FloatGrid::Ptr expected = openvdb::tools::sdfToSdf(*field, 0.0f, 1);
    const FloatGrid::Ptr parallel = field->deepCopy();
    {
      const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
      ASSERT_TRUE(SolveDistances(field->tree(), static_cast<float>(voxel_mm)));
    }
    ASSERT_TRUE(SolveDistances(parallel->tree(), static_cast<float>(voxel_mm)));
    // OpenVDB replaces what it could not solve by the largest distance that it found.
    int solved = 0;
    for (auto leaf = expected->tree().cbeginLeaf(); leaf; ++leaf) {
      const auto* const own = field->tree().probeConstLeaf(leaf->origin());
      ASSERT_NE(own, nullptr);
      for (openvdb::Index i = 0; i < 512; ++i) {
        const float value = own->getValue(i);
        ASSERT_EQ(value, parallel->tree().getValue(leaf->offsetToGlobalCoord(i)));
        ASSERT_EQ(value < 0, leaf->getValue(i) < 0);
        if (std::abs(value) > 1000) continue;
        ASSERT_EQ(value, leaf->getValue(i)) << leaf->offsetToGlobalCoord(i);
        ++solved;
      }
    }
    EXPECT_GT(solved, 40000);
  }
}

// First-order sweeping is exact for a plane along the axes, and a ball's error falls with the voxel.
TEST(SolveDistances, PlanesAreExactAndBallsConverge) {
  const FloatGrid::Ptr plane = MakeField(16, 0.2, [](const Vec3& p) { return 1.5 * (p.x - 2.25); });
  KeepNearSurface(plane->tree(), kBand);
  ASSERT_TRUE(SolveDistances(plane->tree(), 0.2f));
  for (int x = -1; x <= 5; ++x) {
    EXPECT_NEAR(plane->tree().getValue(Coord(x, 3, -2)), 0.2 * (x - 2.25), 1e-6) << x;
  }
  double last = 1e9;
  for (const double radius : {6.0, 12.0, 24.0}) {
    const double voxel_mm = 1 / radius;
    const FloatGrid::Ptr ball = MakeField(32, voxel_mm, [&](const Vec3& p) { return glm::length(p) - radius; });
    KeepNearSurface(ball->tree(), kBand);
    ASSERT_TRUE(SolveDistances(ball->tree(), static_cast<float>(voxel_mm)));
    double worst = 0;
    for (auto it = ball->tree().cbeginLeaf(); it; ++it) {
      for (openvdb::Index i = 0; i < 512; ++i) {
        const double value = static_cast<double>(it->getValue(i));
        const Coord ijk = it->offsetToGlobalCoord(i);
        const double true_mm = voxel_mm * (glm::length(Vec3(ijk.x(), ijk.y(), ijk.z())) - radius);
        if (std::abs(value) < 1000 && std::abs(true_mm) < 3 * voxel_mm)
          worst = std::max(worst, std::abs(value - true_mm));
      }
    }
    EXPECT_LT(worst, 0.3 * voxel_mm);  // first order: 0.29 voxels after a way of 3, as OpenVDB's
    EXPECT_LT(worst, last);
    last = worst;
  }
}

TEST(SolveDistances, AFieldOfOneSignIsRefusedUnchanged) {
  const FloatGrid::Ptr field = MakeField(8, 0.1, [](const Vec3&) { return 2.0; });
  EXPECT_FALSE(SolveDistances(field->tree(), 0.1f));
  EXPECT_EQ(field->tree().getValue(Coord(0, 0, 0)), 2.0f);
}

}  // namespace
}  // namespace kerf
