// Tests of the wanted cut of an exercise.
#include "session/scene/exercise.h"

#include <gtest/gtest.h>

#include <algorithm>
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

/// Burs with a flat end, with a point, and tapered with a point.
const FissureBur kFlat{.diameter_mm = 2.1, .length_mm = 8};
const FissureBur kPointed{.diameter_mm = 2.1, .length_mm = 8, .point_angle_deg = 120};
const FissureBur kTapered{.diameter_mm = 2.4, .length_mm = 6, .taper = 0.7, .point_angle_deg = 140};

TEST(WantedCut, BurStandsOnTheWantedFloorAndItsDistanceHasAClosedForm) {
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    const WantedCut cut = MakeWantedCut(RandomExercise(random), kFlat);
    const double s_mm = 0.3 * cut.length_mm;
    const Pose X_WT = cut.CalcToolPose(s_mm, cut.depth_mm);
    EXPECT_TRUE(IsValid(X_WT));
    EXPECT_NEAR(glm::distance(X_WT.Vector({0, 0, 1}), -cut.into_W), 0, 1e-12);
    EXPECT_NEAR(glm::distance(X_WT.Vector({1, 0, 0}), cut.along_W), 0, 1e-12);
    EXPECT_NEAR(glm::distance(cut.ToCut(cut.FindLowest(X_WT)), Vec3(s_mm, cut.depth_mm, 0)), 0, 1e-9);
    const auto distance = [&](double s, double t, double w) { return cut.CalcDistance(cut.ToWorld({s, t, w})); };
    const double r = kFlat.radius_mm();
    EXPECT_NEAR(distance(s_mm, cut.depth_mm + 0.7, 0.4), 0.7, 1e-9);                            // below the floor
    EXPECT_NEAR(distance(s_mm, cut.depth_mm - 0.2, 0), -0.2, 1e-9);                             // in it
    EXPECT_NEAR(distance(s_mm, cut.depth_mm - 3, 2.5), 2.5 - r, 1e-9);                          // beside it
    EXPECT_NEAR(distance(s_mm, -40, -2.5), 2.5 - r, 1e-9);                                      // above the bur
    EXPECT_NEAR(distance(-3, cut.depth_mm - 3, 4), 5 - r, 1e-9);                                // beyond its start
    EXPECT_NEAR(distance(cut.length_mm + 3, cut.depth_mm + 2, 4), std::hypot(5 - r, 2), 1e-9);  // its end's edge
  }
}

TEST(WantedCut, DistanceOfAnyBurIsTheLeastOnItsWay) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const FissureBur& bur : {kFlat, kPointed, kTapered}) {
    const WantedCut cut = MakeWantedCut(RandomExercise(random), bur);
    for (int i = 0; i < 60; ++i) {
      const Vec3 stw(cut.length_mm * (0.5 + 0.7 * any(random)), -3 + 9 * any(random), 4 * any(random));
      // The place along the line where the bur is nearest, and each height above the floor.
      Vec3 p(stw.x - std::clamp(stw.x, 0.0, cut.length_mm), stw.z, 0);
      double least_mm = 1e300;
      for (double up_mm = 0; up_mm < 25; up_mm += 0.001) {
        p.z = cut.depth_mm - stw.y - up_mm;
        least_mm = std::min(least_mm, cut.solid->CalcSignedDistance(p));
      }
      const double distance_mm = cut.CalcDistance(cut.ToWorld(stw));
      if (least_mm > 0) {
        EXPECT_NEAR(distance_mm, least_mm, 0.001);
      } else {
        EXPECT_LT(distance_mm, 0.001);
      }
    }
  }
}

TEST(WantedCut, LowestPointOfALeaningBurIsThatOfItsEnd) {
  std::mt19937 random(7);
  const WantedCut cut = MakeWantedCut(RandomExercise(random), kFlat);
  Pose X_WT = cut.CalcToolPose(1, 2);
  const double lean_rad = 0.2;
  X_WT.R_AB = glm::angleAxis(lean_rad, cut.along_W) * X_WT.R_AB;
  const double lower_mm = kFlat.radius_mm() * std::sin(lean_rad);
  EXPECT_NEAR(glm::distance(cut.ToCut(cut.FindLowest(X_WT)), Vec3(1, 2 + lower_mm, 0)), 0, 1e-9);
  EXPECT_NEAR(cut.CalcTilt_deg(X_WT), lean_rad * kDegreesPerRad, 1e-9);
  // Along the line, a bur may lean.
  X_WT.R_AB = glm::angleAxis(lean_rad, cut.across_W) * cut.CalcToolPose(1, 2).R_AB;
  EXPECT_NEAR(cut.CalcTilt_deg(X_WT), 0, 1e-9);
}

TEST(WantedCut, OutlineOfABurIsItsSilhouetteAcrossTheCut) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const FissureBur& bur : {kFlat, kPointed, kTapered}) {
    const WantedCut cut = MakeWantedCut(RandomExercise(random), bur);
    for (int i = 0; i < 20; ++i) {
      Pose X_WT = cut.CalcToolPose(1, 2);
      X_WT.R_AB = glm::normalize(Quat(1, any(random), any(random), any(random))) * X_WT.R_AB;
      const std::vector<Vec3> outline = cut.CalcOutline(X_WT, 120);
      double deepest_mm = -1e300;
      for (std::size_t j = 0; j < outline.size(); ++j) {
        EXPECT_LT(cut.solid->CalcSignedDistance(X_WT.InversePoint(cut.ToWorld(outline[j]))), 1e-9);
        const Vec3 next = outline[(j + 1) % outline.size()] - outline[j];
        EXPECT_LT(glm::length(next), 4 * cut.reach_mm / 120 + 1e-9);
        deepest_mm = std::max(deepest_mm, outline[j].y);
      }
      EXPECT_NEAR(deepest_mm, cut.ToCut(cut.FindLowest(X_WT)).y, 1e-9);
    }
  }
}

TEST(WantedCut, FloorThatABurLeavesIsItsProfile) {
  std::mt19937 random(9);
  for (const FissureBur& bur : {kPointed, kTapered}) {
    const WantedCut cut = MakeWantedCut(RandomExercise(random), bur);
    for (const double above_mm : {0.1, 0.3, 0.4}) {
      const double along_mm = cut.CalcReachAlong(above_mm);
      EXPECT_NEAR(cut.solid->CalcSignedDistance({along_mm, 0, above_mm}), 0, 1e-12);
      EXPECT_NEAR(cut.CalcFloor(along_mm), cut.depth_mm - above_mm, 1e-12);
    }
  }
  const WantedCut flat = MakeWantedCut(RandomExercise(random), kFlat);
  EXPECT_NEAR(flat.CalcReachAlong(0.3), flat.radius_mm, 1e-12);
  EXPECT_EQ(flat.CalcFloor(0.99 * flat.radius_mm), flat.depth_mm);
  EXPECT_LT(flat.CalcFloor(flat.radius_mm), 0);
}

std::vector<Tool> BladesWithAStroke() {
  return {OscillatingBlade{}, PiezoInsert{}, ReciprocatingBlade{}};
}

TEST(WantedCut, BladeWithAStrokePointsIntoTheBoneWithItsEdgeAlongTheLine) {
  std::mt19937 random(10);
  for (const Tool& tool : BladesWithAStroke()) {
    const WantedCut cut = MakeWantedCut(RandomExercise(random), tool);
    const Pose X_WT = cut.CalcToolPose(2, 3);
    EXPECT_TRUE(IsValid(X_WT));
    EXPECT_NEAR(glm::distance(X_WT.Vector({1, 0, 0}), cut.into_W), 0, 1e-12);
    EXPECT_NEAR(glm::distance(X_WT.Vector({0, 1, 0}), cut.along_W), 0, 1e-12);
    EXPECT_NEAR(glm::distance(cut.ToCut(cut.FindLowest(X_WT)), Vec3(2, 3, 0)), 0, 1e-9);
    // The last plunge is at the line's end, and each overlaps the one before.
    EXPECT_GE((cut.plunges - 1) * 1.5 * cut.radius_mm, cut.length_mm);
    Pose leaning = X_WT;
    leaning.R_AB = glm::angleAxis(0.1, cut.along_W) * X_WT.R_AB;
    EXPECT_NEAR(cut.CalcTilt_deg(leaning), 0.1 * kDegreesPerRad, 1e-9);
    leaning.R_AB = glm::angleAxis(0.1, cut.across_W) * X_WT.R_AB;
    EXPECT_NEAR(cut.CalcTilt_deg(leaning), 0, 1e-6);
    double deepest_mm = -1e300;
    for (const Vec3& p : cut.CalcOutline(leaning, 120)) deepest_mm = std::max(deepest_mm, p.y);
    EXPECT_NEAR(deepest_mm, cut.ToCut(cut.FindLowest(leaning)).y, 1e-9);
  }
}

TEST(WantedCut, DistanceOfABladeWithAStrokeIsTheLeastOnItsWay) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const Tool& tool : BladesWithAStroke()) {
    const WantedCut cut = MakeWantedCut(RandomExercise(random), tool);
    for (int i = 0; i < 60; ++i) {
      const Vec3 stw(0.5 * cut.length_mm + (0.5 * cut.length_mm + 1.5 * cut.radius_mm) * any(random),
                     cut.depth_mm - 1 + 4 * any(random), any(random));
      const double s = stw.x - std::clamp(stw.x, 0.0, cut.length_mm);
      double in_plane = 1e300;
      for (double up_mm = 0; up_mm < 15; up_mm += 0.001) {
        in_plane = std::min(in_plane, cut.outline.CalcSignedDistance({stw.y - cut.depth_mm + up_mm, s}));
      }
      const double across = std::abs(stw.z) - 0.5 * CalcCutWidth(tool);
      const double least_mm = in_plane > 0 && across > 0 ? std::hypot(in_plane, across) : std::max(in_plane, across);
      const double distance_mm = cut.CalcDistance(cut.ToWorld(stw));
      if (least_mm > 0) {
        EXPECT_NEAR(distance_mm, least_mm, 0.02);  // the outline has chords instead of the arc
      } else {
        EXPECT_LT(distance_mm, 0.02);
      }
    }
  }
}

TEST(WantedCut, FloorOfAPlungeIsTheArcOfTheTeeth) {
  std::mt19937 random(12);
  const OscillatingBlade blade;
  const WantedCut arc = MakeWantedCut(RandomExercise(random), blade);
  const double along_mm = 3;
  const double above_mm = blade.radius_mm - std::sqrt(blade.radius_mm * blade.radius_mm - along_mm * along_mm);
  EXPECT_NEAR(arc.CalcFloor(along_mm), arc.depth_mm - above_mm, 1e-12);
  EXPECT_NEAR(arc.CalcReachAlong(above_mm), along_mm, 0.02);  // of a parabola
  const WantedCut straight = MakeWantedCut(RandomExercise(random), PiezoInsert{});
  EXPECT_EQ(straight.CalcFloor(1), straight.depth_mm);
  EXPECT_NEAR(straight.CalcReachAlong(0.3), 0.5 * (4 + 0.12), 1e-12);
}

TEST(Exercise, FurtherCutsAreReadAndWrittenForTheKindsThatHaveThem) {
  const auto scene = [](const std::string& tool, const std::string& kind) {
    return test::ShortScene() + "[tool]\nshape = \"" + tool + "\"\n[exercise]\nkind = \"" + kind +
           "\"\ndepth_mm = 7\n[[exercise.cut]]\nstart_mm = [0, 5, 0]\ninto = [0, 0, -2]\n" +
           (kind == "drill_holes" ? "" : "end_mm = [8, 5, 0]\n");
  };
  const Scene read = ParseScene(scene("drill", "drill_holes"), "s.toml");
  ASSERT_EQ(read.exercise.further.size(), 1U);
  const Scene again = ParseScene(ResolvedToml(read), "s.toml");
  for (const Scene& s : {read, again}) {
    const std::vector<WantedCut> holes = MakeWantedCuts(s.exercise, MakeTool(s));
    ASSERT_EQ(holes.size(), 2U);
    EXPECT_EQ(holes[1].start_W, Vec3(0, 5, 0));
    EXPECT_EQ(holes[1].depth_mm, 7);  // that of the section
    EXPECT_EQ(holes[1].length_mm, 0);
    // A hole has no line, so that its direction is as given.
    EXPECT_NEAR(glm::distance(holes[1].into_W, Vec3(0, 0, -1)), 0, 1e-12);
    EXPECT_NEAR(glm::dot(glm::cross(holes[1].along_W, holes[1].into_W), holes[1].across_W), 1, 1e-12);
    EXPECT_EQ(&FindNearestCut(holes, {0, 4, 0}), &holes[1]);
    EXPECT_EQ(&FindNearestCut(holes, {0, 1, 0}), &holes[0]);
  }
  EXPECT_EQ(MakeWantedCuts(ParseScene(scene("disc", "osteotomy"), "s.toml").exercise, DiscSaw{})[1].length_mm, 8);
  EXPECT_NE(test::MessageFor(scene("disc", "groove")).find("several cuts are only for"), std::string::npos);
  EXPECT_NE(test::MessageFor(scene("disc", "osteotomy\"\ndepth_stop = true\n#")).find("a depth stop is only for"),
            std::string::npos);
  EXPECT_NE(test::MessageFor(scene("disc", "drill_holes")).find("requires a drill or a bur"), std::string::npos);
}

TEST(Exercise, DrillMakesOnlyHoles) {
  for (const std::string_view kind : kExerciseKindWords) {
    for (const char* shape : {"drill", "bur"}) {
      const bool fits = kind == "drill_holes" || std::string_view(shape) == "bur";
      const std::string message = test::MessageFor(test::ShortScene() + "[tool]\nshape = \"" + shape +
                                                   "\"\n[exercise]\nkind = \"" + std::string(kind) + "\"\n");
      EXPECT_EQ(message.find("but a drill cuts only with its tip; use kind = \"drill_holes\"") == std::string::npos,
                fits)
          << message;
    }
  }
}

TEST(Exercise, OfHolesRefusesAnEndAndTheSameHoleTwice) {
  const std::string holes =
      test::ShortScene() + "[tool]\nshape = \"drill\"\n[exercise]\nkind = \"drill_holes\"\nstart_mm = [1, 2, 3]\n";
  const std::string hole = "[[exercise.cut]]\ninto = [0, 0, -2]\nstart_mm = ";
  EXPECT_EQ(test::MessageFor(holes + hole + "[1, 2, 4]\n"), "");
  EXPECT_EQ(test::MessageFor(holes + "end_mm = [4, 5, 6]\n" + hole + "[1, 2, 4]\nend_mm = [4, 5, 6]\n"),
            "s.toml:13:1: end_mm is not used: a hole has no end on the surface; remove it\n"
            "s.toml:17:1: end_mm is not used: a hole has no end on the surface; remove it");
  // Depth and length of the direction do not make another hole of it.
  EXPECT_EQ(test::MessageFor(holes + hole + "[1, 2, 4]\n" + hole + "[1, 2, 3]\ndepth_mm = 5\n"),
            "s.toml:18:1: hole 3 has the place and the direction of hole 1; move it or remove it");
}

TEST(Exercise, RefusesTheSameCutTwiceFromEitherEnd) {
  const std::string cuts = test::ShortScene() +
                           "[exercise]\nkind = \"osteotomy\"\nstart_mm = [1, 2, 3]\nend_mm = [4, 2, 3]\n"
                           "[[exercise.cut]]\ninto = [0, 0, -1]\n";
  EXPECT_EQ(test::MessageFor(cuts + "start_mm = [4, 2, 3]\nend_mm = [1, 2, 2]\n"), "");
  for (const char* line :
       {"start_mm = [4, 2, 3]\nend_mm = [1, 2, 3]\n", "start_mm = [1, 2, 3]\nend_mm = [4, 2, 3]\n"}) {
    EXPECT_EQ(test::MessageFor(cuts + line),
              "s.toml:14:1: cut 2 has the place and the direction of cut 1; move it or remove it");
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
