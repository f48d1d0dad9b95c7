#include "session/plan/moments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

namespace kerf {
namespace {

// The corners of a box have the standard deviations of half its edges.
TEST(FitMoments, FindsTheAxesAndSpreadsOfABox) {
  std::vector<WeightedPoint> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back(
        {{1 + ((i & 1) != 0 ? 3.0 : -3.0), 2 + ((i & 2) != 0 ? 0.5 : -0.5), (i & 4) != 0 ? 2.0 : -2.0}, 0.7});
  }
  const auto fit = FitMoments(corners);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(glm::distance(fit->p, Vec3(1, 2, 0)), 0, 1e-12);
  EXPECT_NEAR(std::abs(fit->normal.y), 1, 1e-12);
  EXPECT_NEAR(std::abs(fit->along.x), 1, 1e-12);
  EXPECT_NEAR(fit->thickness, 0.5, 1e-12);
  EXPECT_NEAR(fit->breadth, 2, 1e-12);
  EXPECT_NEAR(fit->length, 3, 1e-12);
}

TEST(FitMoments, WeightsMoveTheCentre) {
  const auto fit = FitMoments({{{0, 0, 0}, 1}, {{4, 0, 0}, 3}}, 2);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->p.x, 3, 1e-12);
  EXPECT_NEAR(fit->length, std::sqrt(3.0), 1e-12);
}

TEST(FitMoments, ReturnsNoneForTooFewPointsOrNoWeight) {
  EXPECT_FALSE(FitMoments({{{0, 0, 0}, 1}, {{4, 0, 0}, 3}}));
  EXPECT_FALSE(FitMoments({}, 0));
  EXPECT_FALSE(FitMoments({{{0, 0, 0}, 1}, {{4, 0, 0}, -1}}, 2));
}

}  // namespace
}  // namespace kerf
