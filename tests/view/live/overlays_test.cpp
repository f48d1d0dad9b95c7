// Tests of overlays: places of labels, levels of alarms, the free area, and what is visible through bone.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "view/live/nearest.h"
#include "view/live/overlay_colours.h"
#include "view/live/scene_actors.h"
#include "view/live/scene_shapes.h"

namespace kerf {
namespace {

double Draw(std::mt19937& random, double lower, double upper) {
  return lower + (upper - lower) * (static_cast<double>(random()) / 4294967296.0);
}

TEST(Alarms, LevelGrowsAsTheDistanceShrinks) {
  EXPECT_EQ(AlarmLevelFor(5), AlarmLevel::kNone);
  EXPECT_EQ(AlarmLevelFor(3), AlarmLevel::kNotice);
  EXPECT_EQ(AlarmLevelFor(1.5), AlarmLevel::kWarning);
  EXPECT_EQ(AlarmLevelFor(-0.2), AlarmLevel::kDanger);
}

TEST(Nearest, DistanceToDiscAndBallIsThatOfTheClosedForm) {
  DiscSaw saw;
  saw.diameter_mm = 20;
  saw.thickness_mm = 1;
  const Pose X_WT{glm::angleAxis(0.7, glm::normalize(Vec3{1, 2, 3})), {4, -2, 6}};
  const auto at = [&](const Tool& tool, const Vec3& p_T) {
    TriangleMesh one;
    one.points = {X_WT.Point(p_T), X_WT.Point({200, 0, 0})};
    const auto nearest = FindNearest(tool, X_WT, one);
    EXPECT_NEAR(glm::length(nearest->p_W - one.points[0]), 0, 1e-12);
    return nearest->distance_mm;
  };
  EXPECT_NEAR(at(saw, {3, 4, 2.5}), 2, 1e-12);                       // above the flat
  EXPECT_NEAR(at(saw, {0, 13, 0.2}), 3, 1e-12);                      // beside the rim
  EXPECT_NEAR(at(saw, {13, 0, -4.5}), 5, 1e-12);                     // off the edge: 3, 4, 5
  EXPECT_NEAR(at(saw, {9.8, 0, 0}), -0.2, 1e-12);                    // inside, next to the rim
  EXPECT_NEAR(at(BallBurr{.diameter_mm = 6}, {0, 4, 3}), 2, 1e-12);  // from the centre 5
  EXPECT_FALSE(FindNearest(saw, X_WT, {}));
}

TEST(ForceArrowLength, NeverSpansMoreThanAThirdOfTheView) {
  std::mt19937 random(11);
  for (const bool parallel : {true, false}) {
    for (int i = 0; i < 200; ++i) {
      ViewCamera camera;
      camera.SetSize(1280, 720);
      camera.set_parallel(parallel);
      camera.set_height_mm(Draw(random, 2, 300));
      camera.Look({Draw(random, -1, 1), Draw(random, -1, 1), Draw(random, 0.1, 1)}, {0, 1, 0});
      const Vec3 tip = camera.Unproject({Draw(random, 0, 1280), Draw(random, 0, 720)}, camera.target_W());
      const Vec3 back = glm::normalize(Vec3{Draw(random, -1, 1), Draw(random, -1, 1), Draw(random, -1, 1)});
      const double length = CalcArrowLength(camera, tip, back, 60);
      EXPECT_LE(length, 60);
      const auto a = camera.Project(tip);
      const auto b = camera.Project(tip + length * back);
      ASSERT_TRUE(a && b);
      const double px = std::hypot(a->x - b->x, a->y - b->y);
      EXPECT_LE(px, 240 * (1 + 1e-9));
      // It is not shorter than it must be.
      if (length < 60) {
        EXPECT_GT(px, 239);
      }
    }
  }
}

TEST(ForceArrowLength, TailStaysInTheArea) {
  ViewCamera camera;
  camera.SetSize(1280, 720);
  camera.set_height_mm(60);
  camera.Look({0, 1, 0}, {0, 0, 1});
  const ScreenBox area{262, 59, 1018, 629};
  const Vec3 tip = camera.Unproject({700, 620}, camera.target_W());
  const double length = CalcArrowLength(camera, tip, {0, 0, -1}, 60, area);
  const auto tail = camera.Project(tip + length * Vec3{0, 0, -1});
  ASSERT_TRUE(tail);
  EXPECT_LE(tail->y, area.top + area.height);
  EXPECT_GT(tail->y, 660);
  // A tip outside of the area does not shorten it to nothing.
  const Vec3 outside = camera.Unproject({100, 300}, camera.target_W());
  EXPECT_GT(CalcArrowLength(camera, outside, {0, 0, -1}, 60, area), 1);
}

TEST(Tube, IsClosedAndHasTheVolumeOfAPrism) {
  // A straight tube with 20 corners: the area of a regular polygon times its length.
  const TriangleMesh straight = MakeTubeMesh({{1, 2, 3}, {1, 2, 3}, {4, 2, 3}, {11, 2, 3}}, 2);
  EXPECT_EQ(CountOpenEdges(straight), 0u);
  EXPECT_NEAR(CalcEnclosedVolume(straight), 10 * 10 * 4 * std::sin(2 * std::numbers::pi / 20), 1e-9);
  const TriangleMesh bent = MakeTubeMesh({{0, 0, 0}, {10, 0, 0}, {14, 6, 0}, {14, 12, 5}}, 1);
  EXPECT_EQ(CountOpenEdges(bent), 0u);
  EXPECT_GT(CalcEnclosedVolume(bent), 0);
  EXPECT_TRUE(MakeTubeMesh({{1, 1, 1}, {1, 1, 1}}, 1).triangles.empty());
  EXPECT_TRUE(MakeTubeMesh({}, 1).triangles.empty());
}

}  // namespace
}  // namespace kerf
