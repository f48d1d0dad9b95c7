// Nearest triangles and closest points, compared with slow computations in double precision.
#include "bone/mesh/near_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <random>

namespace kerf {
namespace {

constexpr float kLimit2 = 0.01F;
constexpr float kMinCosine = 0.2F;

/// Returns the distance from `p` to the plane of a triangle with a corner at the origin, if p lies above or below it;
/// none within `margin_mm` of the border.
std::optional<double> CalcHeight(const Vec3& p, const Vec3& from, const Vec3& to, double margin_mm) {
  const Vec3 n = glm::normalize(glm::cross(from, to));
  const Vec3 corners[3] = {Vec3(0), from, to};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 side = glm::normalize(corners[(k + 1) % 3] - corners[k]);
    if (glm::dot(glm::cross(n, side), p - corners[k]) < margin_mm) return std::nullopt;
  }
  return std::abs(glm::dot(p, n));
}

/// Makes the triangles around the origin of a cone with its tip there.
std::vector<PlaceTriangle> MakeCone(std::size_t count, float height) {
  std::vector<PlaceTriangle> triangles;
  const auto corner = [&](std::size_t i) {
    const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i % count) / static_cast<float>(count);
    return Vec3f(std::cos(angle), std::sin(angle), height);
  };
  for (std::size_t i = 0; i < count; ++i) triangles.emplace_back(corner(i), corner(i + 1));
  return triangles;
}

TEST(NearPoints, NearestTriangleIsTheOneBelowThePoint) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> at(-0.6F, 0.6F);
  const std::vector<PlaceTriangle> triangles = MakeCone(7, 0.1F);
  // Counts around the lengths of vectors.
  for (const std::size_t count : {1U, 4U, 8U, 15U, 16U, 17U, 100U}) {
    NearPoints points;
    points.Resize(count);
    ASSERT_EQ(points.size(), count);
    for (std::size_t i = 0; i < count; ++i) points.Set(i, {at(random), at(random), 0.1F * at(random)}, {0, 0, 1});
    points.FindNearest(triangles, kLimit2, kMinCosine);
    for (std::size_t i = 0; i < count; ++i) {
      const NearPoints::Nearest nearest = points.nearest(i);
      const Vec3 p(points.point(i));
      for (std::size_t k = 0; k < triangles.size(); ++k) {
        const std::optional<double> height = CalcHeight(p, Vec3(triangles[k].from), Vec3(triangles[k].to), 1e-5);
        if (!height) continue;
        // Single precision, for lengths of up to 1 mm.
        EXPECT_LT(static_cast<double>(nearest.distance2), *height * *height + 1e-6);
      }
      if (nearest.triangle < 0) continue;
      const PlaceTriangle& t = triangles[static_cast<std::size_t>(nearest.triangle)];
      const std::optional<double> height = CalcHeight(p, Vec3(t.from), Vec3(t.to), -1e-5);
      ASSERT_TRUE(height.has_value());
      EXPECT_NEAR(static_cast<double>(nearest.distance2), *height * *height, 1e-6);
      if (nearest.distance2 >= kLimit2) continue;
      EXPECT_LE(nearest.least_cosine, glm::dot(t.normal, points.normal(i)) + 1e-6F);
    }
  }
}

TEST(NearPoints, TrianglesOfAnotherWallDoNotCount) {
  NearPoints points;
  points.Resize(2);
  points.Set(0, {0.3F, 0.1F, 0.05F}, {0, 0, 1});
  points.Set(1, {0.3F, 0.1F, 0.05F}, {0, 0, -1});
  points.FindNearest(MakeCone(5, 0), kLimit2, kMinCosine);
  EXPECT_GE(points.nearest(0).triangle, 0);
  EXPECT_NEAR(points.nearest(0).distance2, 0.0025F, 1e-6F);
  EXPECT_EQ(points.nearest(1).triangle, -1);
  EXPECT_EQ(points.nearest(1).least_cosine, 1);
}

TEST(NearPoints, DistanceBeyondSides) {
  const PlaceTriangle t({1, 0, 0}, {0, 1, 0});
  EXPECT_FLOAT_EQ(t.CalcArea_mm2(), 0.5F);
  EXPECT_EQ(t.CalcDistance2BeyondSides({0.2F, 0.2F, 3}), NearPoints::kFar);
  EXPECT_NEAR(t.CalcDistance2BeyondSides({0.5F, -0.3F, 0.4F}), 0.25F, 1e-6F);  // beyond the side along x
  EXPECT_NEAR(t.CalcDistance2BeyondSides({-0.3F, 0.5F, 0.4F}), 0.25F, 1e-6F);  // beyond the side along y
  EXPECT_NEAR(t.CalcDistance2BeyondSides({1, 1, 0}), 0.5F, 1e-6F);             // beyond the third
  EXPECT_NEAR(t.CalcDistance2BeyondSides({-3, -4, 0}), 25, 1e-5F);             // beyond the corner at the place
}

TEST(NearPoints, ClosestPointsAreInOrder) {
  NearPoints points;
  points.Resize(2);
  points.Set(0, {5, 0, 0}, {0, 0, 1});
  points.Set(1, {1, 0, 0}, {0, 0, 1});
  ASSERT_EQ(points.FindClosest({0, 0, 0}).size(), 2u);
  points.Resize(20);
  for (std::size_t i = 0; i < 20; ++i) points.Set(i, {static_cast<float>(7 * i % 20), 0, 0}, {0, 0, 1});
  const auto closest = points.FindClosest({11.2F, 0, 0});
  ASSERT_EQ(closest.size(), 3u);
  EXPECT_EQ(points.point(closest[0]).x, 11);
  EXPECT_EQ(points.point(closest[1]).x, 12);
  EXPECT_EQ(points.point(closest[2]).x, 10);
}

}  // namespace
}  // namespace kerf
