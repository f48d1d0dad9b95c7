// Tests of the wanted cut of an exercise.
#include "session/scene/exercise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "kerf/error.h"
#include "scene_text.h"

namespace kerf {
namespace {

SceneExercise RandomExercise(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  SceneExercise exercise;
  exercise.start_mm = 20.0 * vector();
  exercise.end_mm = exercise.start_mm + 10.0 * vector();
  exercise.into = vector();
  exercise.depth_mm = 4;
  return exercise;
}

TEST(WantedCut, FrameIsRightHandedAndContainsTheLine) {
  std::mt19937 random(3);
  for (int i = 0; i < 50; ++i) {
    const SceneExercise exercise = RandomExercise(random);
    const WantedCut cut = MakeWantedCut(exercise, DiscSaw{});
    const Vec3 end = cut.ToCut(exercise.end_mm);
    EXPECT_NEAR(end.x, cut.length_mm, 1e-9);  // rounding of coordinates of about 10 mm
    EXPECT_NEAR(end.y, 0, 1e-9);
    EXPECT_NEAR(end.z, 0, 1e-9);
    EXPECT_GT(glm::dot(cut.into_W, exercise.into), 0);
    EXPECT_NEAR(glm::dot(glm::cross(cut.along_W, cut.into_W), cut.across_W), 1, 1e-12);
    const Vec3 p = cut.ToWorld({1, 2, 3});
    EXPECT_NEAR(glm::distance(cut.ToCut(p), Vec3(1, 2, 3)), 0, 1e-9);
  }
}

TEST(WantedCut, ToolOnTheWantedCutReachesExactlyItsDepth) {
  std::mt19937 random(4);
  for (int i = 0; i < 50; ++i) {
    const WantedCut cut = MakeWantedCut(RandomExercise(random), DiscSaw{});
    const Pose X_WT = cut.CalcToolPose(0.3 * cut.length_mm, cut.depth_mm);
    EXPECT_TRUE(IsValid(X_WT));
    EXPECT_NEAR(glm::distance(X_WT.Vector({0, 0, 1}), cut.across_W), 0, 1e-12);
    EXPECT_NEAR(glm::distance(X_WT.Vector({1, 0, 0}), cut.along_W), 0, 1e-12);
    // The disc's lowest point is on the border of the wanted cut. Inside, the nearest border is half the kerf's width
    // away.
    const Vec3 lowest = X_WT.p_AB + cut.radius_mm * cut.into_W;
    EXPECT_NEAR(cut.CalcDistance(lowest), 0, 1e-9);
    EXPECT_NEAR(cut.CalcDistance(lowest + 0.5 * cut.into_W), 0.5, 1e-9);
    EXPECT_NEAR(cut.CalcDistance(X_WT.p_AB), -0.5 * cut.thickness_mm, 1e-9);
    EXPECT_NEAR(cut.CalcDistance(X_WT.p_AB + 2.0 * cut.across_W), 2 - 0.5 * cut.thickness_mm, 1e-9);
  }
}

TEST(WantedCut, RefusesALineWithoutLengthAndADirectionAlongIt) {
  SceneExercise exercise;
  exercise.into = {2, 0, 0};
  EXPECT_THROW(MakeWantedCut(exercise, DiscSaw{}), Error);
  exercise = {};
  exercise.end_mm = exercise.start_mm;
  EXPECT_THROW(MakeWantedCut(exercise, DiscSaw{}), Error);
  EXPECT_NE(test::MessageFor(test::ShortScene() + "[exercise]\ninto = [3, 0, 0]\n").find("[exercise] into"),
            std::string::npos);
}

}  // namespace
}  // namespace kerf
