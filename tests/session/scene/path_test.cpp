// Tests that compare the path with closed forms: position, orientation and duration.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "session/scene/path.h"

namespace kerf {
namespace {

// Rotations and sums of a few dozen doubles of size 100 have rounding errors far below this.
constexpr double kRounding = 1e-12;

SceneStroke Stroke(Vec3 start, Vec3 end, double feed, Vec3 normal) {
  SceneStroke stroke;
  stroke.start_mm = start;
  stroke.end_mm = end;
  stroke.feed_mm_per_s = feed;
  stroke.disc_normal = normal;
  return stroke;
}

Scene SceneOf(std::vector<SceneStroke> strokes) {
  Scene scene;
  scene.path.strokes = std::move(strokes);
  return scene;
}

void ExpectNear(const Vec3& a, const Vec3& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(StrokePath, MovesAtTheFeedAlongTheLine) {
  // The path is 50 mm long (3-4-5), which takes 12.5 s at 4 mm/s.
  const Path path = MakePath(SceneOf({Stroke({10, 0, 0}, {40, 40, 0}, 4, {0, 0, 2})}));
  EXPECT_DOUBLE_EQ(path.duration_s(), 12.5);
  EXPECT_DOUBLE_EQ(path.length_mm(), 50);
  EXPECT_NEAR(path.CalcMaxSpeed(), 4, kRounding);
  for (const double t : {0.0, 0.001, 3.0, 12.499, 12.5}) {
    ExpectNear(path.CalcPose(0, t).p_AB, Vec3{10, 0, 0} + t * Vec3{2.4, 3.2, 0}, 1e-12);
  }
  // Outside the duration, the time is clamped.
  EXPECT_EQ(path.CalcPose(0, -1).p_AB, Vec3(10, 0, 0));
  EXPECT_EQ(path.CalcPose(0, 99).p_AB, Vec3(40, 40, 0));
}

TEST(StrokePath, ToolFrameHasZAlongTheNormalAndXAlongTheFeed) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const Vec3 normal{u(random), u(random), u(random)};
    const Vec3 end{u(random), u(random), u(random)};
    if (glm::length(normal) < 0.1 || glm::length(glm::cross(normal, end)) < 0.01) continue;
    const Pose X = MakePath(SceneOf({Stroke({0, 0, 0}, end, 1, 3.0 * normal)})).CalcPose(0, 0);
    EXPECT_TRUE(IsValid(X));
    ExpectNear(X.Vector({0, 0, 1}), glm::normalize(normal), kRounding);
    const Vec3 nhat = glm::normalize(normal);
    // Division by the projected feed, at least 0.01 long, amplifies rounding a hundredfold.
    ExpectNear(X.Vector({1, 0, 0}), glm::normalize(end - glm::dot(end, nhat) * nhat), 100 * kRounding);
  }
}

TEST(StrokePath, FeedAlongTheNormalUsesTheAxisFurthestFromIt) {
  const Pose X = MakePath(SceneOf({Stroke({0, 0, 0}, {0, 0, 5}, 1, {0.1, 0, 5})})).CalcPose(0, 0);
  EXPECT_TRUE(IsValid(X));
  const Pose along = MakePath(SceneOf({Stroke({0, 0, 0}, {0, 0, 5}, 1, {0, 0, -1})})).CalcPose(0, 0);
  EXPECT_TRUE(IsValid(along));
  ExpectNear(along.Vector({0, 0, 1}), {0, 0, -1}, kRounding);
  ExpectNear(along.Vector({1, 0, 0}), {1, 0, 0}, kRounding);
}

TEST(StrokePath, SegmentsAreConsecutiveInTimeAndMarkRetracts) {
  SceneStroke first = Stroke({0, 0, 0}, {6, 0, 0}, 3, {0, 1, 0});
  first.dwell_s = 0.5;
  SceneStroke second = Stroke({6, 0, 0}, {6, 0, -4}, 2, {0, 1, 0});
  second.retract = false;
  const SceneStroke third = Stroke({0, 9, 0}, {1, 9, 0}, 1, {0, 0, 1});
  const Path path = MakePath(SceneOf({first, second, third}));
  ASSERT_EQ(path.segments().size(), 3U);
  EXPECT_DOUBLE_EQ(path.segments()[0].end_s, 2.5);  // 2 s of travel, 0.5 s of rest
  EXPECT_DOUBLE_EQ(path.segments()[1].end_s, 4.5);
  EXPECT_DOUBLE_EQ(path.duration_s(), 5.5);
  EXPECT_TRUE(path.segments()[0].retract_before);
  EXPECT_FALSE(path.segments()[1].retract_before);
  EXPECT_TRUE(path.segments()[2].retract_before);
  EXPECT_DOUBLE_EQ(path.length_mm(), 11);
  // The dwell is at the end of the stroke.
  EXPECT_EQ(path.CalcPose(0, 2.1).p_AB, Vec3(6, 0, 0));
  // Without a retract the pose is continuous, including rotation, although the feed changes direction.
  const Pose before = path.CalcPose(0, 2.5);
  const Pose after = path.CalcPose(1, 2.5);
  EXPECT_EQ(before.p_AB, after.p_AB);
  EXPECT_EQ(before.R_AB, after.R_AB);
}

TEST(StrokePath, TicksCoverASegmentWithoutOneTooMany) {
  const Path path = MakePath(SceneOf({Stroke({0, 0, 0}, {0.3, 0, 0}, 3, {0, 1, 0}),    // 0.1 s, not exact in binary
                                      Stroke({0, 0, 0}, {0.301, 0, 0}, 3, {0, 1, 0}),  // longer by a third of a tick
                                      Stroke({0, 0, 0}, {1e-4, 0, 0}, 3, {0, 1, 0})}));
  EXPECT_EQ(path.CountTicks(0, 1000), 100U);
  EXPECT_EQ(path.CountTicks(1, 1000), 101U);
  EXPECT_EQ(path.CountTicks(2, 1000), 1U);
  EXPECT_EQ(path.CountTicks(1000), 202U);
}

TEST(PathDriver, StepsThroughEachSegmentAndPlacesTheTool) {
  // Segments of 2.5, 1 and 0.5 ticks at 10 Hz; the second continues the first without a placement.
  SceneStroke second = Stroke({5, 0, 0}, {7, 0, 0}, 20, {0, 0, 1});
  second.retract = false;
  const Path path = MakePath(
      SceneOf({Stroke({0, 0, 0}, {5, 0, 0}, 20, {0, 0, 1}), second, Stroke({0, 3, 0}, {1, 3, 0}, 20, {0, 0, 1})}));
  struct Expected {
    std::size_t segment;
    bool set_down;
    double x_mm, time_s, dt_s;
  };
  const Expected expected[] = {{0, true, 0, 0, 0},        {0, false, 2, 0.1, 0.1},  {0, false, 4, 0.2, 0.1},
                               {0, false, 5, 0.25, 0.05}, {1, false, 7, 0.35, 0.1}, {2, true, 0, 0.35, 0},
                               {2, false, 1, 0.40, 0.05}};
  PathDriver driver(path, 10);
  for (const Expected& e : expected) {
    const std::optional<PathStep> step = driver.Next();
    ASSERT_TRUE(step.has_value());
    EXPECT_EQ(step->segment, e.segment);
    EXPECT_EQ(step->set_down, e.set_down);
    EXPECT_NEAR(step->X_WT.p_AB.x, e.x_mm, kRounding);
    EXPECT_NEAR(step->time_s, e.time_s, kRounding);
    EXPECT_NEAR(step->dt_s, e.dt_s, kRounding);
  }
  EXPECT_FALSE(driver.Next().has_value());
  EXPECT_FALSE(driver.Next().has_value());
}

TEST(PosePath, TurnsBySlerp) {
  // The tool is unrotated at 2 s and rotated by 90 degrees about z at 4 s, so it is at 45 degrees at 3 s and at 9
  // degrees at 2.2 s.
  const double half = std::numbers::pi / 4;
  Scene scene;
  scene.path.poses = {{2, {Quat(1, 0, 0, 0), {0, 0, 0}}}, {4, {Quat(std::cos(half), 0, 0, std::sin(half)), {8, 0, 0}}}};
  const Path path = MakePath(scene);
  EXPECT_DOUBLE_EQ(path.duration_s(), 2);
  for (const double t : {0.2, 1.0, 1.7}) {
    const double angle = t / 2 * std::numbers::pi / 2;
    const Pose X = path.CalcPose(0, t);
    ExpectNear(X.p_AB, {4 * t, 0, 0}, kRounding);
    ExpectNear(X.Vector({1, 0, 0}), {std::cos(angle), std::sin(angle), 0}, kRounding);
  }
}

TEST(PosePath, TakesTheShorterArcForEitherSignOfTheQuaternion) {
  const double half = std::numbers::pi / 8;
  const Quat turned(std::cos(half), std::sin(half), 0, 0);
  Scene plus;
  plus.path.poses = {{0, {Quat(1, 0, 0, 0), {0, 0, 0}}}, {1, {turned, {0, 0, 0}}}};
  Scene minus = plus;
  minus.path.poses[1].X_WT.R_AB = -turned;
  for (const double t : {0.1, 0.5, 0.9}) {
    ExpectNear(MakePath(plus).CalcPose(0, t).Vector({0, 0, 1}), MakePath(minus).CalcPose(0, t).Vector({0, 0, 1}),
               kRounding);
  }
}

TEST(PosePath, PassesThroughEveryRowExactly) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-1, 1);
  Scene scene;
  double t = 5;
  for (int i = 0; i < 500; ++i) {
    const Quat R = glm::normalize(Quat(u(random), u(random), u(random), u(random)));
    scene.path.poses.push_back({t, {R, {u(random), u(random), u(random)}}});
    t += 0.001 + std::abs(u(random));
  }
  const Path path = MakePath(scene);
  for (const TimedPose& row : scene.path.poses) {
    const Pose X = path.CalcPose(0, row.time_s - 5);
    ExpectNear(X.p_AB, row.X_WT.p_AB, kRounding);
    EXPECT_NEAR(std::abs(glm::dot(X.R_AB, row.X_WT.R_AB)), 1, kRounding);
  }
}

}  // namespace
}  // namespace kerf
