// Tests of the measures of drilled holes and of several cuts, on exact holes and cuts at known positions.
#include "session/score/holes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>

#include "bone/models/block.h"
#include "exact_cut.h"
#include "session/score/cut_measures.h"
#include "session/score/review.h"
#include "session/score/review_figures.h"

namespace kerf {
namespace {

constexpr double kFiveDegrees = 5 * std::numbers::pi / 180;

/// A plate 6 mm thick in an oblique pose, with its top at z = 0 of its own frame B.
BlockParams Plate() {
  BlockParams block;
  block.size_mm = {24, 10, 6};
  block.voxel_mm = 0.25;
  block.X_WB = {glm::normalize(Quat(0.8, 0.3, -0.4, 0.2)), {3, -5, 7}};
  return block;
}

/// Four holes that end 1 mm beyond the plate, 5 mm apart.
SceneExercise FourHoles(const Pose& X_WB) {
  SceneExercise exercise;
  exercise.given = true;
  exercise.kind = ExerciseKind::kDrillHoles;
  exercise.start_mm = X_WB.Point({-7.5, 0, 0});
  exercise.into = X_WB.Vector({0, 0, -1});
  exercise.depth_mm = 7;
  exercise.margin_mm = 0.8;
  for (const double x : {-2.5, 2.5, 7.5}) {
    exercise.further.push_back({.start_mm = X_WB.Point({x, 0, 0}), .into = exercise.into, .depth_mm = 7});
  }
  return exercise;
}

/// Scores exact holes. `change`: alters those that are made.
ScoreSheet ScoreHoles(const std::function<void(std::vector<WantedCut>&)>& change) {
  const BlockParams block = Plate();
  const Tool drill = TwistDrill{.diameter_mm = 2, .length_mm = 20, .point_angle_deg = 118};
  const std::vector<WantedCut> wanted = MakeWantedCuts(FourHoles(block.X_WB), drill);
  std::vector<WantedCut> made = wanted;
  change(made);
  const Bone before = test::CutExactly(block, {});
  const Bone after = test::CutExactly(block, made);
  ScoreSheet sheet = MakeSheet(ExerciseKind::kDrillHoles);
  std::vector<std::optional<Pose>> deepest;
  for (const WantedCut& hole : made) deepest.emplace_back(hole.CalcToolPose(0, hole.depth_mm));
  MeasureCut(before, after, wanted, {}, sheet);
  MeasureHoles(before, wanted, deepest, sheet);
  SetValue(sheet, "path_length_mm", 0);
  SetValue(sheet, "time_total_s", 0);
  for (MeasureRow& row : sheet.rows) row.half = std::max(row.half, 1.0);
  CalcTotal(sheet);
  return sheet;
}

double PointsOf(const ScoreSheet& sheet, std::string_view key) {
  return RowOf(sheet, key).points.value();
}

TEST(Holes, ExactHolesGetAllPoints) {
  const ScoreSheet sheet = ScoreHoles([](auto&) {});
  EXPECT_GT(sheet.total.value(), 99) << FormatSheet(sheet);
  EXPECT_EQ(sheet.Get("holes_through"), 4);
  EXPECT_EQ(sheet.Get("line_share"), 1);
  // Four cylinders of 2 mm through 6 mm.
  EXPECT_NEAR(sheet.Get("planned_mm3").value(), 4 * 6 * std::numbers::pi, 0.5);
  ASSERT_EQ(sheet.holes.size(), 4U);
  for (const auto& hole : sheet.holes) {
    ASSERT_TRUE(hole);
    EXPECT_NEAR(hole->beyond_mm, 1, 0.02);
    EXPECT_NEAR(hole->depth_mm, 7, 0.02);
    EXPECT_NEAR(hole->offset_mm, 0, 0.01);
    EXPECT_NEAR(hole->angle_deg, 0, 0.01);
    EXPECT_TRUE(hole->through);
  }
}

// Each fault of one hole costs points of its own measure only.
TEST(Holes, EachFaultLowersExactlyItsMeasure) {
  struct HoleFault {
    const char* key;
    double value;
    std::function<void(WantedCut&)> change;
  };
  const HoleFault cases[] = {
      {"plunge_max_mm", 4, [](WantedCut& hole) { hole.depth_mm += 3; }},
      {"hole_offset_mm", 0.6, [](WantedCut& hole) { hole.start_W += 0.6 * hole.across_W; }},
      {"hole_angle_deg", 5,
       [](WantedCut& hole) {
         const Quat turn = glm::angleAxis(kFiveDegrees, hole.along_W);
         hole.into_W = turn * hole.into_W;
         hole.across_W = turn * hole.across_W;
       }},
  };
  for (const HoleFault& c : cases) {
    const ScoreSheet sheet = ScoreHoles([&](std::vector<WantedCut>& holes) { c.change(holes[2]); });
    EXPECT_NEAR(sheet.Get(c.key).value(), c.value, 0.05) << c.key;
    EXPECT_LT(sheet.total.value(), 95) << c.key;
    for (const Goal& goal : GoalsOf(ExerciseKind::kDrillHoles)) {
      if (std::string_view(goal.key) == c.key) {
        EXPECT_LT(PointsOf(sheet, goal.key), 0.75) << c.key;
      } else {
        EXPECT_GT(PointsOf(sheet, goal.key), 0.98) << c.key << " changes " << goal.key;
      }
    }
    EXPECT_NE(FormatMessage(MakeReview(sheet).headline).find("drill"), std::string::npos) << c.key;
  }
}

TEST(Holes, AHoleThatStopsInTheBoneIsNotThroughAndOneThatWasNotBegunHasNoResult) {
  const ScoreSheet sheet = ScoreHoles([](std::vector<WantedCut>& holes) {
    holes[1].depth_mm = 4;
    holes[3].depth_mm = -1;
  });
  EXPECT_EQ(sheet.Get("holes_through"), 2);
  EXPECT_EQ(sheet.Get("line_share"), 0.75);
  EXPECT_NEAR(sheet.holes[1].value().beyond_mm, -2, 0.02);
  EXPECT_FALSE(sheet.holes[1]->through);
  EXPECT_FALSE(sheet.holes[3]);
  EXPECT_NEAR(sheet.Get("cut_share").value(), (2 + 4.0 / 6) / 4, 0.03);
}

// Of two planned cuts, the one that is worse counts, and each is measured by what was removed nearer to it.
TEST(SeveralCuts, TheWorstCutCounts) {
  const BlockParams block = Plate();
  const DiscSaw saw{.diameter_mm = 16, .thickness_mm = 0.5};
  SceneExercise exercise;
  exercise.kind = ExerciseKind::kOsteotomy;
  exercise.start_mm = block.X_WB.Point({-5, -1, 0});
  exercise.end_mm = block.X_WB.Point({-5, 1, 0});
  exercise.into = block.X_WB.Vector({0, 0, -1});
  exercise.depth_mm = 10;
  exercise.margin_mm = 1;
  exercise.further.push_back({.start_mm = block.X_WB.Point({5, -1, 0}),
                              .end_mm = block.X_WB.Point({5, 1, 0}),
                              .into = exercise.into,
                              .depth_mm = 10});
  const std::vector<WantedCut> wanted = MakeWantedCuts(exercise, saw);
  const Bone before = test::CutExactly(block, {});
  const auto measure = [&](const std::vector<WantedCut>& made) {
    ScoreSheet sheet = MakeSheet(ExerciseKind::kOsteotomy);
    MeasureCut(before, test::CutExactly(block, made), wanted, {}, sheet);
    return sheet;
  };
  const ScoreSheet exact = measure(wanted);
  EXPECT_GT(exact.Get("cut_share").value(), 0.99);
  EXPECT_NEAR(exact.Get("plane_angle_deg").value(), 0, 0.4);
  EXPECT_NEAR(exact.Get("outside_mm3").value(), 0, 1e-9);
  EXPECT_NEAR(exact.Get("planned_mm3").value(), 2 * 0.5 * 10 * 6, 3);
  std::vector<WantedCut> made = wanted;
  // 5 degrees about the line, at half of the plate's thickness.
  const Quat turn = glm::angleAxis(kFiveDegrees, made[1].along_W);
  const Vec3 about_W = made[1].ToWorld({1, 3, 0});
  made[1].start_W = about_W + turn * (made[1].start_W - about_W);
  made[1].into_W = turn * made[1].into_W;
  made[1].across_W = turn * made[1].across_W;
  const ScoreSheet tilted = measure(made);
  EXPECT_NEAR(tilted.Get("plane_angle_deg").value(), 5, 0.4);
  EXPECT_NEAR(tilted.Get("plane_offset_mm").value(), 0, 0.2);
  EXPECT_GT(tilted.Get("cut_share").value(), 0.98);
  const ScoreSheet one = measure({wanted[0]});
  EXPECT_NEAR(one.Get("cut_share").value(), 0.5, 0.01);
  EXPECT_FALSE(one.Get("plane_angle_deg"));
}

}  // namespace
}  // namespace kerf
