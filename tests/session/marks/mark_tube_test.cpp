#include "session/marks/mark_tube.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <random>

#include "cut/tool/shape.h"

namespace kerf {
namespace {

// The search along a segment stops at 1e-4 mm.
constexpr double kSearchError_mm = 1.1e-4;

Pose AnyPose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> in(-15, 15);
  return {glm::normalize(Quat(normal(random), normal(random), normal(random), normal(random))),
          Vec3(in(random), in(random), in(random))};
}

TEST(MarkTube, MatchesTheClosedFormOfAStraightTube) {
  const MarkTube tube({.name = "n", .radius_mm = 1.5, .points_W = {{-50, 0, 0}, {50, 0, 0}}});
  DiscSaw saw;
  saw.diameter_mm = 20;
  saw.thickness_mm = 0.5;
  // The disc lies in the plane z = height, above the line.
  for (const double height_mm : {5.0, 2.0, 1.75, 1.0, 0.0}) {
    const MarkTube::Nearest found = tube.Find(Tool(saw), Pose{{1, 0, 0, 0}, {3, 0, height_mm}});
    EXPECT_NEAR(found.distance_mm, std::max(height_mm - 0.25, 0.0) - 1.5, kSearchError_mm) << height_mm;
  }
  // Beside the line: the rim is nearest. Beyond its end: the end.
  EXPECT_NEAR(tube.Find(Tool(saw), Pose{{1, 0, 0, 0}, {0, 14, 0}}).distance_mm, 14 - 10 - 1.5, kSearchError_mm);
  const MarkTube::Nearest end = tube.Find(Tool(saw), Pose{{1, 0, 0, 0}, {65, 0, 0}});
  EXPECT_NEAR(end.distance_mm, 65 - 50 - 10 - 1.5, kSearchError_mm);
  EXPECT_NEAR(glm::length(end.p_W - Vec3(50, 0, 0)), 0, kSearchError_mm);
  BallBurr burr;
  burr.diameter_mm = 4;
  EXPECT_NEAR(tube.Find(Tool(burr), Pose{{1, 0, 0, 0}, {7, 3, 4}}).distance_mm, 5 - 2 - 1.5, kSearchError_mm);
  EXPECT_NEAR(tube.Find(Vec3(7, 3, 4)).distance_mm, 5 - 1.5, 1e-12);
  // A point is a ball.
  const MarkTube ball({.name = "n", .radius_mm = 2, .points_W = {{0, 0, 10}}});
  EXPECT_NEAR(ball.Find(Tool(saw), Pose{}).distance_mm, 10 - 0.25 - 2, 1e-12);
  EXPECT_TRUE(MarkTube({.name = "none"}).empty());
  EXPECT_EQ(MarkTube({.name = "none"}).Find(Vec3(0)).distance_mm, 1e9);
}

TEST(MarkTube, MatchesBruteForceForAnyCurve) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> in(-20, 20);
  for (int i = 0; i < 60; ++i) {
    Mark mark{.name = "n", .radius_mm = 0.8, .points_W = {}};
    for (int k = 0; k < 2 + i % 6; ++k) mark.points_W.emplace_back(in(random), in(random), in(random));
    const MarkTube tube(mark);
    const Pose X_WT = AnyPose(random);
    const Tool tool = i % 3 == 0 ? Tool(BallBurr{}) : Tool(DiscSaw{});
    // Points along the curve every 5 um: at most half of that from the nearest one.
    double expected = 1e9;
    const std::vector<Vec3>& line = tube.curve_W();
    for (std::size_t k = 1; k < line.size(); ++k) {
      const int steps = std::max(1, static_cast<int>(glm::length(line[k] - line[k - 1]) / 0.005));
      for (int s = 0; s <= steps; ++s) {
        const Vec3 p_W = line[k - 1] + static_cast<double>(s) / steps * (line[k] - line[k - 1]);
        expected = std::min(expected, CalcToolDistance(tool, X_WT.InversePoint(p_W)));
      }
    }
    const MarkTube::Nearest found = tube.Find(tool, X_WT);
    EXPECT_NEAR(found.distance_mm, expected - 0.8, 0.005);
    EXPECT_LE(found.distance_mm, expected - 0.8 + kSearchError_mm);
    EXPECT_NEAR(CalcToolDistance(tool, X_WT.InversePoint(found.p_W)) - 0.8, found.distance_mm, 1e-9);
  }
}

TEST(MarkTube, ChangesByAtMostTheMotion) {
  std::mt19937 random(6);
  const MarkTube tube({.name = "n", .radius_mm = 1, .points_W = {{-10, 0, 0}, {0, 5, 2}, {10, -3, 1}, {15, 4, 8}}});
  const Tool tool = DiscSaw{};
  for (int i = 0; i < 50; ++i) {
    Pose X = AnyPose(random);
    const double before = tube.Find(tool, X).distance_mm;
    X.p_AB += Vec3(0.3, -0.2, 0.1);
    EXPECT_LE(std::abs(tube.Find(tool, X).distance_mm - before), glm::length(Vec3(0.3, -0.2, 0.1)) + kSearchError_mm);
  }
}

}  // namespace
}  // namespace kerf
