// Tests of the share of a wanted cut that is made, against areas that are known.
#include "session/score/cut_area.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bone/grid/build.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "session/score/cut_measures.h"

namespace kerf {
namespace {

BlockParams Block() {
  BlockParams block;
  block.size_mm = {40, 10, 12};
  block.voxel_mm = 0.25;
  return block;
}

/// A line of 6 mm on the block's top face.
WantedCut Wanted(double depth_mm) {
  DiscSaw saw;
  saw.diameter_mm = 12;
  saw.thickness_mm = 0.5;
  SceneExercise exercise;
  exercise.start_mm = {-3, 0, 0};
  exercise.end_mm = {3, 0, 0};
  exercise.into = {0, 0, -1};
  exercise.depth_mm = depth_mm;
  return MakeWantedCut(exercise, saw);
}

/// Area that the disc cuts along the line: a rectangle and two halves of a circle's segment.
double CalcArea(const WantedCut& cut) {
  const double r = cut.radius_mm;
  const double h = r - cut.depth_mm;
  return cut.length_mm * cut.depth_mm + r * r * std::acos(h / r) - h * std::sqrt(r * r - h * h);
}

Bone Cut(const BlockParams& block, const WantedCut& cut) {
  SolidField solid;
  solid.value = [&](const Vec3& p_W) { return std::max(CalcBlockDistance(block, p_W), -cut.CalcDistance(p_W)); };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = [](const Vec3&) { return 24; };
  BuildOptions options;
  options.voxel_mm = block.voxel_mm;
  options.region_voxel_mm = block.voxel_mm;
  return MakeBone(solid, Box3{{-20, -5, -12}, {20, 5, 0}}.Grown(2), options, DefaultMandibleTable());
}

TEST(CalcCutArea, IsTheShareOfThePlaneInBone) {
  const BlockParams block = Block();
  const Bone before = MakeBlock(block, DefaultMandibleTable());
  const WantedCut wanted = Wanted(4);
  const double tolerance_mm2 = 0.5 * 0.125 * 2 * (16 + 4);  // half a step along the border
  EXPECT_NEAR(CalcCutArea(before, before, wanted).bone_mm2, CalcArea(wanted), tolerance_mm2);
  EXPECT_EQ(CalcCutArea(before, before, wanted).share(), 0);
  EXPECT_NEAR(CalcCutArea(before, Cut(block, wanted), wanted).share(), 1, 0.01);
  // A cut of half the depth along the whole line is less than half of the area.
  WantedCut half = Wanted(2);
  EXPECT_NEAR(CalcCutArea(before, Cut(block, half), wanted).share(), CalcArea(half) / CalcArea(wanted), 0.02);
  // One that lies beside the plane counts as long as it is within the margin.
  half.start_W += 0.4 * half.across_W;
  EXPECT_NEAR(CalcCutArea(before, Cut(block, half), wanted).share(), CalcArea(half) / CalcArea(wanted), 0.02);
  half.start_W += 1.2 * half.across_W;
  EXPECT_EQ(CalcCutArea(before, Cut(block, half), wanted).share(), 0);
}

TEST(CalcCutArea, TakesTheWidthOfATaperedBurAtEachDepth) {
  const Bone before = MakeBlock(Block(), DefaultMandibleTable());
  SceneExercise exercise;
  exercise.start_mm = {-3, 0, 0};
  exercise.end_mm = {3, 0, 0};
  exercise.into = {0, 0, -1};
  exercise.depth_mm = 4;
  const FissureBur bur{.diameter_mm = 4, .length_mm = 4, .taper = 0.5};
  const WantedCut wanted = MakeWantedCut(exercise, bur);
  // The radius is 1 mm at the floor and 2 mm at the surface, or the other way round: the cut is 6 mm long with the two
  // halves of a truncated cone at its ends.
  const double volume_mm3 = 6 * 4 * 3 + std::numbers::pi * 4 * (1 + 2 + 4) / 3;
  // A voxel's half of the floor and of the surface may be missed; steps of 0.125 mm along the border.
  EXPECT_NEAR(CalcCutArea(before, before, wanted).bone_mm3, volume_mm3, 0.02 * volume_mm3);
}

// The window shows this share while the bone is cut.
TEST(CalcCutArea, IsWhatTheScoreShows) {
  const BlockParams block = Block();
  const Bone before = MakeBlock(block, DefaultMandibleTable());
  const WantedCut wanted = Wanted(4);
  for (const double depth_mm : {0.7, 1.9, 3.3, 5.0}) {
    const Bone after = Cut(block, Wanted(depth_mm));
    ScoreSheet sheet = MakeSheet(ExerciseKind::kOsteotomy);
    MeasureCut(before, after, {wanted}, {}, sheet);
    EXPECT_EQ(sheet.Get("cut_share").value(), CalcCutArea(before, after, wanted).share());
  }
}

TEST(CalcCutArea, WithoutBoneIsNothing) {
  const Bone before = MakeBlock(Block(), DefaultMandibleTable());
  WantedCut away = Wanted(4);
  away.start_W.y += 30;
  EXPECT_EQ(CalcCutArea(before, before, away).bone_mm2, 0);
  EXPECT_EQ(CalcCutArea(before, before, away).share(), 0);
}

}  // namespace
}  // namespace kerf
